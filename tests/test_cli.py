"""The command line: exit codes, one clear message on standard error, results on standard output."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import fsm_calib
from fsm_calib.cli import app

ROOT = Path(fsm_calib.__file__).parent.parent
SCENARIOS = ROOT / "scenarios"
QUICK = """
name: quick
seed: 4
robot: {source: nominal, known: {camera: true}}
plan: [orientation]
output: {recording: false, frames: 3}
"""


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def quick(tmp_path: Path) -> Path:
    path = tmp_path / "quick.yaml"
    path.write_text(QUICK)
    return path


def test_linear_algebra_has_one_thread_before_numpy_is_there() -> None:
    code = """
import builtins, os, sys
os.environ.pop("OPENBLAS_NUM_THREADS", None)
real = builtins.__import__
def watched(name, *arguments):
    if name == "numpy" and "numpy" not in sys.modules:
        print(os.environ.get("OPENBLAS_NUM_THREADS"))
    return real(name, *arguments)
builtins.__import__ = watched
import fsm_calib.cli
import numpy
"""
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.split()[0] == "1"


def test_help_lists_the_commands_of_the_contract() -> None:
    result = call("--help")
    assert result.exit_code == 0
    for name in ("run", "validate", "diagrams", "schema", "calibrate-camera", "focus", "identify"):
        assert f"  {name} " in result.stdout


def test_help_imports_no_heavy_library() -> None:
    heavy = "{'cv2', 'numba', 'scipy', 'matplotlib', 'pymunk'}"
    code = f"import sys, fsm_calib.cli; print(*sorted({heavy} & set(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == ""


def test_version_is_printed() -> None:
    assert call("--version").stdout.startswith("fsm-calib ")


@pytest.mark.parametrize(
    "arguments",
    [["nothing"], ["run"], ["validate"], ["run", "a.yaml", "--seed", "x"], ["validate", "no.yaml"]],
)
def test_wrong_use_exits_with_2_and_says_so_on_standard_error(arguments: list[str]) -> None:
    result = call(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr


def test_validate_accepts_a_good_scenario(quick: Path) -> None:
    result = call("validate", quick)
    assert result.exit_code == 0
    assert "valid" in result.stdout


def test_validate_reports_every_error_with_its_place(quick: Path) -> None:
    quick.write_text("name: x\nsed: 1\nplan: [scam]\n")
    result = call("validate", quick)
    assert result.exit_code == 2
    assert f"{quick}:2:1: unknown setting 'sed'. Did you mean seed?" in result.stderr
    assert f"{quick}:3:8: plan[0] is 'scam'. Did you mean scan?" in result.stderr
    assert "Traceback" not in result.output


def test_validate_accepts_a_study() -> None:
    result = call("validate", SCENARIOS / "study.yaml")
    assert result.exit_code == 0
    assert "a study of 10 robots" in result.stdout


def test_run_sends_a_study_to_its_command(tmp_path: Path) -> None:
    result = call("run", SCENARIOS / "study.yaml", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "fsm-calib study" in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_bad_scenario_writes_nothing(quick: Path, tmp_path: Path) -> None:
    quick.write_text("name: x\nplan: []\n")
    result = call("run", quick, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (["--seed", "-1"], "the seed is -1"),
        (["--out", "a", "--resume", "b"], "two directories"),
        (["--resume", "b"], "b"),
    ],
)
def test_wrong_options_of_run_exit_with_2(quick: Path, extra: list[str], message: str) -> None:
    result = call("run", quick, *extra)
    assert result.exit_code == 2
    assert message in result.stderr


def test_run_prints_a_summary_and_writes_its_files(quick: Path, tmp_path: Path) -> None:
    result = call("run", quick, "--out", tmp_path / "out", "--seed", "9")
    assert result.exit_code == 0
    assert "outcome      done" in result.stdout
    assert "by part" in result.stdout
    written = json.loads((tmp_path / "out" / "result.json").read_text())
    assert (written["outcome"], written["seed"], written["camera"]) == ("done", 9, None)
    assert sum(written["seconds"]["by_part"].values()) == pytest.approx(
        written["seconds"]["wall"], rel=0.2, abs=0.2
    )
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<svg" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert "https://" not in page


def files_of(directory: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(directory)): path.read_bytes() for path in directory.rglob("*") if path.is_file()
    }


def test_the_directory_of_an_earlier_run_is_refused_and_keeps_every_byte(quick: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "frames").mkdir(parents=True)
    (out / "journal.jsonl").write_text("{}\n")
    before = files_of(out)
    result = call("run", quick, "--out", out)
    assert result.exit_code == 2
    assert f"{out}: holds an earlier run (journal.jsonl, frames)" in result.stderr
    assert all(option in result.stderr for option in ("another directory", f"--resume {out}", "--overwrite"))
    assert files_of(out) == before


def test_overwrite_replaces_an_earlier_run_and_leaves_other_files(quick: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "frames").mkdir(parents=True)
    (out / "frames" / "old.jpg").write_text("old")
    (out / "notes.txt").write_text("mine")
    assert call("run", quick, "--out", out, "--overwrite").exit_code == 0
    assert json.loads((out / "result.json").read_text())["outcome"] == "done"
    assert not (out / "frames" / "old.jpg").exists()
    assert (out / "notes.txt").read_text() == "mine"


def test_without_a_directory_the_next_free_name_is_taken(
    quick: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "result.json").write_text("{}")
    (tmp_path / "out-2").write_text("a file of that name")
    result = call("run", quick)
    assert result.exit_code == 0
    assert "files        out-3/" in result.stdout
    assert (tmp_path / "out" / "result.json").read_text() == "{}"


def test_resume_and_overwrite_contradict_each_other(quick: Path, tmp_path: Path) -> None:
    result = call("run", quick, "--resume", tmp_path, "--overwrite")
    assert result.exit_code == 2
    assert "--resume keeps what --overwrite removes" in result.stderr


def test_a_failed_robot_exits_with_1_reason_and_cure(quick: Path, tmp_path: Path) -> None:
    quick.write_text(QUICK + "faults: [{kind: dropped_frames}]\n")
    result = call("run", quick, "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert "camera_silent" in result.stderr
    assert len(result.stderr.strip().splitlines()[-1]) > 40
    failure = json.loads((tmp_path / "out" / "result.json").read_text())["failure"]
    assert failure["name"] == "camera_silent"
    assert failure["cure"]


def test_schema_is_printed_as_json() -> None:
    result = call("schema")
    assert json.loads(result.stdout)["title"] == "Scenario"


def test_diagrams_are_written_and_checked(tmp_path: Path) -> None:
    assert call("diagrams", "--out", tmp_path).exit_code == 0
    assert call("diagrams", "--check", "--out", tmp_path).exit_code == 0
    next(tmp_path.glob("*.mmd")).write_text("stale")
    stale = call("diagrams", "--check", "--out", tmp_path)
    assert stale.exit_code == 1
    assert "fsm-calib diagrams" in stale.stderr


def test_the_committed_diagrams_are_current() -> None:
    assert call("diagrams", "--check", "--out", ROOT / "diagrams").exit_code == 0


@pytest.mark.parametrize("group", [[], ["robot"], ["recording"]], ids=str)
def test_short_help_lists_every_command_in_whole_sentences(group, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    told = CliRunner().invoke(app, [*group, "-h"]).output
    assert "..." not in told[told.index("Commands:") :]
    assert max(len(line) for line in told.splitlines()) <= 80


def test_one_effect_is_told_within_eighty_columns() -> None:
    told = CliRunner().invoke(app, ["effects", "wheel_eccentricity"]).output
    assert told.startswith("wheel_eccentricity (wheel):")
    assert "floor_tilt" not in told
    assert max(len(line) for line in told.splitlines()) <= 80


def test_unknown_effect_is_answered_with_the_nearest() -> None:
    done = CliRunner().invoke(app, ["effects", "wheel_eccentrisity"])
    assert done.exit_code == 2
    assert "wheel_eccentricity" in done.output
