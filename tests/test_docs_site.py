"""The documentation: a site that builds without a warning and loads nothing else; a tutorial that does what it says."""

import ast
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest
from browser import faults, needs_browser
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.world2d.effects import registry

ROOT = Path(__file__).parents[1]
STEP = re.compile(r"^ {4}(fsm-calib [^\n]*)$|^```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
LOADED = re.compile(r"<(?:script|img|iframe)\b[^>]*\bsrc=\"([^\"]+)|<link\b[^>]*\bhref=\"([^\"]+)")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
AT_ONCE = 12
"""Pages that a browser looks at together."""
NUMBER = re.compile(r"\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Build the site as `mkdocs build --strict` does: a link to nothing or a page outside the contents ends it."""
    build = pytest.importorskip("mkdocs.commands.build", reason="no mkdocs here (pip install -e '.[docs]')")
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    build.build(load_config(str(ROOT / "mkdocs.yml"), strict=True, site_dir=str(folder)))
    return folder


def test_site_loads_nothing_from_other_places(site) -> None:
    for page in site.rglob("*.html"):
        loaded = [a or b for a, b in LOADED.findall(page.read_text(encoding="utf-8"))]
        assert loaded
        assert not [address for address in loaded if "//" in address], page


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on this machine, as `mkdocs serve` does."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *arguments: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.mark.slow
@needs_browser
def test_every_page_is_sound_in_a_browser(site) -> None:
    by_folder: dict[Path, list[Path]] = {}
    for path in sorted(site.rglob("*.html")):
        by_folder.setdefault(path.parent, []).append(path)
    found: list[str] = []
    with served(site) as address:
        for folder, paths in by_folder.items():
            place = f"{address}/{folder.relative_to(site).as_posix()}"
            for first in range(0, len(paths), AT_ONCE):
                pages = {
                    path.stem: path.read_text(encoding="utf-8") for path in paths[first : first + AT_ONCE]
                }
                found += faults(pages, folder, place)
    assert found == []


def test_reference_holds_every_public_function_and_command(site) -> None:
    import fsm_calib

    python, commands = (
        (site / name).read_text(encoding="utf-8") for name in ("python.html", "commands.html")
    )
    for name in fsm_calib.__all__:
        assert re.search(rf'id="fsm_calib\.[\w.]*\b{name}"', python), name
    for name in ("diagnose", "recording init", "calibrate-camera", "targets"):
        assert f"fsm-calib {name}</h2>" in commands


def test_every_effect_is_in_the_advice_on_what_to_drive() -> None:
    text = (ROOT / "docs" / "what-to-drive.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| `")]
    advice = {name.strip("|` "): row[-1].rstrip(" |") for row in rows for name in row[0].split(", ")}
    assert {name: advice.get(name) for name in registry()} == {
        name: effect.manoeuvre for name, effect in registry().items()
    }


def test_links_of_the_readme_lead_to_files() -> None:
    links = re.findall(r"\]\(([^)#\s]+)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if "://" not in link and not (ROOT / link).exists()] == []


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda page: page.stem)
def test_python_in_the_docs_can_be_read_and_its_imports_are_there(page) -> None:
    for block in PYTHON.findall(page.read_text(encoding="utf-8")):
        tree = ast.parse(block)
        imports = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
        exec(compile(ast.Module(imports, []), str(page), "exec"), {})


def test_the_worlds_example_runs() -> None:
    (block,) = PYTHON.findall((ROOT / "docs" / "world.md").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    exec(block, names)
    assert names["frame"].image.shape == (480, 640, 3)


def test_tutorial_ends_where_it_says(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed, is_told = "", False
    for command, shown in STEP.findall((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")):
        if command:
            done = CliRunner().invoke(app, shlex.split(command)[1:])
            assert done.exit_code == 0, f"{command}\n{done.output}"
            printed = ("" if is_told else printed + " ") + _shape(done.output)
        for line in shown.splitlines():
            assert _shape(line) in printed, line
        is_told = bool(shown)
    for file in ("answer/report.html", "answer/world.yaml", "export/corrections.py", "next/commands.csv"):
        assert (tmp_path / "lab" / file).is_file()


def _shape(text: str) -> str:
    """Return a text with its numbers made alike: what the last digits are may differ between machines."""
    return " ".join(NUMBER.sub("#", text).split())
