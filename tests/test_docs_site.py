"""The documentation: a site that builds without a warning and loads nothing else; a tutorial that does what it says."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.world2d.effects import registry

ROOT = Path(__file__).parents[1]
STEP = re.compile(r"^ {4}(fsm-calib [^\n]*)$|^```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
LOADED = re.compile(r"<(?:script|img|iframe)\b[^>]*\bsrc=\"([^\"]+)|<link\b[^>]*\bhref=\"([^\"]+)")
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
