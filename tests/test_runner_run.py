"""A run is repeatable, survives a kill at any event, and always ends with the wheels at zero."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from fsm_calib.errors import DataError, InputError
from fsm_calib.journal import Journal, read_checkpoint, read_journal
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.outcome import Outcome
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Silent
from fsm_calib.runner.run import Stopped, drive, run_scenario
from fsm_calib.runner.session import new_session
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.types import STOP, WheelCommand

SHORT = """
name: short
seed: 4
robot: {source: nominal, wheel_ratio: 1.05, known: {camera: true}}
plan: [orientation]
output: {report: false, recording: false, frames: 4}
"""


def scenario(text: str = SHORT, **changes: object) -> Scenario:
    return scenario_from(parse_yaml(text)).model_copy(update=changes)


def without_times(directory: Path) -> dict:
    result = json.loads((directory / "result.json").read_text())
    result["seconds"].pop("wall")
    result["seconds"].pop("by_part")
    return result


def pictures_in(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (directory / "frames").iterdir()}


class Snapshots(Silent):
    """Copies the run's directory after each event, as a kill at that moment would leave it."""

    def __init__(self, run: Path, copies: Path) -> None:
        self.run, self.copies, self.count = run, copies, 0

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        shutil.copytree(self.run, self.copies / f"{self.count:03d}")
        self.count += 1


@pytest.fixture(scope="module")
def short_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the directory of a finished run and of its snapshots."""
    run, copies = tmp_path_factory.mktemp("run"), tmp_path_factory.mktemp("copies")
    finished = run_scenario(scenario(), run, observer=Snapshots(run, copies))
    assert finished.result["outcome"] == "done"
    return run, copies


def test_events_are_numbered_timed_and_chained(short_run: tuple[Path, Path]) -> None:
    events = list(read_journal(short_run[0] / "journal.jsonl"))
    assert [event["seq"] for event in events] == list(range(len(events)))
    assert all(a["time"] <= b["time"] for a, b in pairwise(events))
    assert all(a["dest"] == b["path"] for a, b in pairwise(events))
    assert events[-1]["dest"] == "done"
    asked = {name: value for event in events for name, value in event["guards"].items()}
    assert asked
    assert set(map(type, asked.values())) == {bool}


def test_the_same_seed_gives_the_same_journal_byte_for_byte(
    short_run: tuple[Path, Path], tmp_path: Path
) -> None:
    run_scenario(scenario(), tmp_path)
    assert (tmp_path / "journal.jsonl").read_bytes() == (short_run[0] / "journal.jsonl").read_bytes()
    assert without_times(tmp_path) == without_times(short_run[0])


def test_another_seed_gives_another_run(short_run: tuple[Path, Path], tmp_path: Path) -> None:
    run_scenario(scenario(seed=5), tmp_path)
    assert (tmp_path / "journal.jsonl").read_bytes() != (short_run[0] / "journal.jsonl").read_bytes()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.99])
def test_a_run_killed_at_any_event_resumes_to_the_same_result(
    short_run, tmp_path: Path, share: float
) -> None:
    run, copies = short_run
    snapshots = sorted(copies.iterdir())
    directory = tmp_path / "run"
    shutil.copytree(snapshots[int(share * len(snapshots))], directory)
    with (directory / "journal.jsonl").open("ab") as journal:
        journal.write(b'{"seq": 999, "torn')
    run_scenario(scenario(), directory, resume=True)
    assert without_times(directory) == without_times(run)
    for name in ("journal.jsonl", "checkpoint.json", "checkpoint.previous.json"):
        assert (directory / name).read_bytes() == (run / name).read_bytes()
    assert pictures_in(directory) == pictures_in(run)


def test_a_run_killed_between_journal_and_checkpoint_resumes_to_the_same_result(
    short_run, tmp_path: Path
) -> None:
    run, copies = short_run
    before, after = sorted(copies.iterdir())[3:5]
    directory = tmp_path / "run"
    shutil.copytree(after, directory)
    shutil.copy(before / "checkpoint.json", directory / "checkpoint.json")
    run_scenario(scenario(), directory, resume=True)
    assert without_times(directory) == without_times(run)


def test_a_run_killed_before_its_first_checkpoint_starts_again(short_run, tmp_path: Path) -> None:
    run_scenario(scenario(), tmp_path, resume=True)
    assert without_times(tmp_path) == without_times(short_run[0])


def test_a_finished_run_can_be_resumed_and_stays_as_it_is(short_run, tmp_path: Path) -> None:
    directory = tmp_path / "run"
    shutil.copytree(short_run[0], directory)
    run_scenario(scenario(), directory, resume=True)
    assert without_times(directory) == without_times(short_run[0])


@pytest.mark.parametrize("changes", [{"seed": 5}, {"name": "other"}])
def test_a_run_of_another_scenario_is_not_resumed(short_run, changes: dict) -> None:
    with pytest.raises(DataError, match="another scenario or seed"):
        run_scenario(scenario(**changes), short_run[0], resume=True)


def test_a_changed_journal_is_noticed_when_the_robot_is_driven_again(short_run, tmp_path: Path) -> None:
    directory = tmp_path / "run"
    shutil.copytree(sorted(short_run[1].iterdir())[-2], directory)
    events = list(read_journal(directory / "journal.jsonl"))
    moved = next(event for event in events if any(left or right for _, left, right in event["commands"]))
    moved["commands"] = [[time, -left, -right] for time, left, right in moved["commands"]]
    state = read_checkpoint(directory)
    assert state is not None
    forged = Journal(directory)
    for event in events[: state["sequence"]]:
        forged.append(event)
    own = ("schema", "journal_length", "journal_chain")
    forged.checkpoint({name: value for name, value in state.items() if name not in own})
    forged.close()
    with pytest.raises(DataError, match="away from where the journal says"):
        run_scenario(scenario(), directory, resume=True)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [("checkpoint.json", b'"time":', b'"time":1'), ("journal.jsonl", b'"frames":', b'"frames":1')],
)
def test_a_run_with_a_changed_number_is_refused_and_keeps_its_files(
    short_run, tmp_path: Path, name: str, old: bytes, new: bytes
) -> None:
    directory = tmp_path / "run"
    shutil.copytree(sorted(short_run[1].iterdir())[-2], directory)
    path = directory / name
    path.write_bytes(path.read_bytes().replace(old, new, 1))
    before = {file.name: file.read_bytes() for file in directory.iterdir() if file.is_file()}
    with pytest.raises(DataError, match=name.replace(".", "[.]")):
        run_scenario(scenario(), directory, resume=True)
    assert {file.name: file.read_bytes() for file in directory.iterdir() if file.is_file()} == before


def last_command(session) -> WheelCommand:
    return session.world.robot.command_log[-1][1]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_the_wheels_are_at_zero_when_an_activity_raises(tmp_path: Path, error: type[BaseException]) -> None:
    session = new_session(scenario(), tmp_path, Parts("rest"), Silent())

    def broken(bench) -> Outcome:
        bench.robot.command(WheelCommand(0.4, 0.4))
        raise error

    session.run.activities = {**session.run.activities, "turn_to_marker": broken}
    with pytest.raises(error):
        drive(session)
    assert last_command(session) == STOP


def test_a_request_to_stop_ends_in_aborted_with_the_wheels_at_zero_and_can_be_resumed(
    short_run, tmp_path
) -> None:
    session = new_session(scenario(), tmp_path, Parts("rest"), Silent())

    def stopped(bench) -> Outcome:
        bench.robot.command(WheelCommand(0.4, 0.4))
        raise Stopped("Stopped by SIGTERM.")

    session.run.activities = {**session.run.activities, "turn_counterclockwise": stopped}
    drive(session)
    assert session.run.machine.state == "aborted"
    assert last_command(session) == STOP
    run_scenario(scenario(), tmp_path, resume=True)
    assert without_times(tmp_path) == without_times(short_run[0])


def test_a_command_that_is_no_number_never_reaches_the_wheels(tmp_path: Path) -> None:
    session = new_session(scenario(), tmp_path, Parts("rest"), Silent())
    with pytest.raises(DataError, match="not finite"):
        session.run.robot.command(WheelCommand(float("nan"), 0.0))
    assert session.world.robot.command_log == ()


KILLED = """
import os, signal, sys
from fsm_calib.cli import main
from fsm_calib.journal import Journal

append = Journal.append


def last(journal, event):
    append(journal, event)
    if event["seq"] == 4:
        os.kill(os.getpid(), signal.SIGKILL)


Journal.append = last
main()
"""


def test_sigkill_loses_nothing(short_run, tmp_path: Path) -> None:
    path = tmp_path / "short.yaml"
    path.write_text(SHORT)
    arguments = [sys.executable, "-c", KILLED, "run", str(path), "--out", str(tmp_path / "run")]
    assert subprocess.run(arguments, capture_output=True, check=False).returncode == -signal.SIGKILL
    assert len((tmp_path / "run" / "journal.jsonl").read_bytes().splitlines()) == 5
    assert not (tmp_path / "run" / "result.json").exists()
    run_scenario(scenario(), tmp_path / "run", resume=True)
    assert without_times(tmp_path / "run") == without_times(short_run[0])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"dest": "wheels/foward"}, "no state wheels/foward. Did you mean wheels/forward"),
        ({"guards": ("is_plan_don",)}, "no guard is_plan_don. Did you mean is_plan_done"),
    ],
)
def test_a_slip_in_a_table_is_said_before_anything_moves(
    tmp_path: Path, changes: dict, sentence: str
) -> None:
    root = CALIBRATION.root
    broken = replace(root, transitions=(*root.transitions[:-1], replace(root.transitions[-1], **changes)))
    with pytest.raises(InputError, match=re.escape(sentence)) as caught:
        run_scenario(scenario(), tmp_path / "run", machinery=replace(CALIBRATION, root=broken))
    assert caught.value.exit_code == 2
    assert not (tmp_path / "run").exists()


def test_a_run_of_another_machine_is_not_resumed(short_run, tmp_path: Path) -> None:
    root = replace(CALIBRATION.root, name="other")
    with pytest.raises(DataError, match="another machine"):
        run_scenario(scenario(), short_run[0], resume=True, machinery=replace(CALIBRATION, root=root))
