"""What `pip install` of a built wheel gives: everything that the source tree does, in an empty folder."""

import os
import shutil
import subprocess
import sys
import zipfile
from functools import lru_cache
from pathlib import Path

import pytest
from browser import PROGRAM, faults

ROOT = Path(__file__).parents[1]
RUN = "from fsm_calib.cli import main; main()"
SHORT = """\
name: short
seed: 5
robot: {source: nominal, wheel_ratio: 1.11, known: {camera: true}}
plan: [orientation]
"""
"""The shortest plan: a robot whose camera is known turns to the floor markers."""


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """Return a folder that holds what a wheel of the source tree installs."""
    pytest.importorskip("setuptools", minversion="77")
    place = tmp_path_factory.mktemp("wheel")
    source = place / "source"
    source.mkdir()
    names = ("fsm_calib", "scenarios", "diagrams", "pyproject.toml", "setup.py", "README.md", "LICENSE")
    for name in names:  # links, so that the build leaves nothing in the source tree
        (source / name).symlink_to(ROOT / name)
    build = "from setuptools import build_meta; print(build_meta.build_wheel('..'))"
    done = subprocess.run([sys.executable, "-c", build], cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    (wheel,) = place.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place / "site")
    return place / "site"


@lru_cache
def offline() -> tuple[str, ...]:
    """Return what makes a command run without any network, where this machine lets us."""
    command = ("unshare", "--map-root-user", "--net")
    if shutil.which(command[0]) is None or subprocess.run([*command, "true"], capture_output=True).returncode:
        return ()
    return command


def fsm_calib(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    """Run the installed command line in a folder, without a network."""
    environment = os.environ | {"PYTHONPATH": str(installed), "COLUMNS": "80"}
    command = [*offline(), sys.executable, "-c", RUN, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)


def test_wheel_holds_every_scenario_diagram_and_template(installed) -> None:
    for folder in ("scenarios", "diagrams"):
        there = {path.name for path in (installed / "fsm_calib" / "_shipped" / folder).iterdir()}
        assert there >= {path.name for path in (ROOT / folder).iterdir() if path.is_file()}
    pages = [path.relative_to(ROOT) for path in (ROOT / "fsm_calib").rglob("*.j2")]
    assert pages
    assert all((installed / page).is_file() for page in pages)


@pytest.mark.slow
def test_shipped_scenario_runs_by_name_in_an_empty_folder(installed, tmp_path) -> None:
    done = fsm_calib(installed, tmp_path, "run", "full_calibration", "--out", "here")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "here" / "report.html").read_text(encoding="utf-8")
    assert all(f"<h2>{part}</h2>" in page for part in ("Wheels", "Camera", "Time line of states"))
    if PROGRAM is not None:
        assert faults({"run": page}, tmp_path) == []


def test_schema_diagrams_targets_and_validate_work_in_an_empty_folder(installed, tmp_path) -> None:
    for arguments in (("schema",), ("schema", "--study"), ("diagrams",), ("targets",), ("validate", "study")):
        done = fsm_calib(installed, tmp_path, *arguments)
        assert done.returncode == 0, done.stderr
    drawn = {path.name for path in (tmp_path / "diagrams").iterdir()}
    assert {"whole.svg", "scan.svg", "README.md"} <= drawn
    printed = {path.name for path in (tmp_path / "targets").iterdir()}
    assert {"plan.pdf", "boards.pdf", "tags.pdf", "area.pdf", "poster.pdf"} <= printed


def test_short_run_ends_with_its_page_in_an_empty_folder(installed, tmp_path) -> None:
    (tmp_path / "short.yaml").write_text(SHORT, encoding="utf-8")
    done = fsm_calib(installed, tmp_path, "run", "short.yaml", "--out", "here")
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "here" / "report.html").stat().st_size > 10_000


def test_written_scenario_is_valid_and_never_replaced(installed, tmp_path) -> None:
    first = fsm_calib(installed, tmp_path, "init", "mine.yaml", "--from", "wheels_only")
    assert first.returncode == 0, first.stderr
    assert (tmp_path / "schema.json").is_file()
    assert fsm_calib(installed, tmp_path, "validate", "mine.yaml").returncode == 0
    again = fsm_calib(installed, tmp_path, "init", "mine.yaml")
    assert again.returncode == 2
    assert "exists already" in again.stderr


def test_unknown_scenario_name_is_answered_with_the_nearest(installed, tmp_path) -> None:
    done = fsm_calib(installed, tmp_path, "run", "full_calibraton")
    assert done.returncode == 2
    assert "full_calibration" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_demo_names_what_the_robot_hid_in_an_empty_folder(installed, tmp_path) -> None:
    done = fsm_calib(installed, tmp_path, "demo", "--no-open", "--out", "demo")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "A wheel sits off its centre by 0.0" in done.stdout
    assert (tmp_path / "demo" / "report.html").is_file()
    assert (tmp_path / "demo" / "world.yaml").is_file()
