"""Commands, benchmarks and files that the documentation names are there, with the options that it gives them."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

from fsm_calib.cli import app

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "benchmarks").rglob("*.md")),
]
CALL = re.compile(r"fsm-calib ((?:[a-z][a-z-]*\b)[^#`\n]*)")
BENCHMARK = re.compile(r"(benchmarks/[\w/]+\.py)([^#`\n|]*)")
NAMED = re.compile(r"(?<![\w./-])((?:fsm_calib|tests|benchmarks|scenarios|docs)/[\w./-]+\.\w+)")
OPTION = re.compile(r"(?<![\w\"'-])--[a-z][a-z-]*")
QUOTED = re.compile(r"\"[^\"]*\"")
BESIDE = re.compile(r" \| (?=[a-z])|[;:,] |\(| 2?>")
"""Where in a line of the documentation the words of one call end."""


def joined(page: Path) -> str:
    """Return a page with calls that go on in the next line, or in the next line of a paragraph, in one."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    return re.sub(r"`[^`\n]+\n[^`\n]+`", lambda found: found[0].replace("\n", " "), text)


def calls(page: Path) -> Iterator[tuple[list[str], list[str]]]:
    """Yield the words and the options of every call of the program."""
    for found in CALL.findall(joined(page)):
        call = BESIDE.split(QUOTED.sub("", found))[0]
        yield re.findall(r"^[a-z -]*[a-z]|$", call)[0].split(), OPTION.findall(call)


def known(words: list[str]) -> set[str]:
    """Return the options of the command that the words name."""
    command = typer.main.get_command(app)
    for word in words:
        if not hasattr(command, "commands"):
            break
        command = command.commands[word]
    return {"--help", *(name for part in command.params for name in (*part.opts, *part.secondary_opts))}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_command_that_a_page_gives_is_there_with_its_options(page):
    assert [
        (words, set(options) - known(words)) for words, options in calls(page) if set(options) - known(words)
    ] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_benchmark_and_file_that_a_page_names_is_there(page):
    text = joined(page)
    assert [name for name in NAMED.findall(text) if not (ROOT / name).exists()] == []
    sources = "\n".join(
        path.read_text(encoding="utf-8") for path in sorted((ROOT / "benchmarks").rglob("*.py"))
    )
    options = {name for _, rest in BENCHMARK.findall(text) for name in OPTION.findall(QUOTED.sub("", rest))}
    assert {name for name in options if f'"{name}"' not in sources} == set()
