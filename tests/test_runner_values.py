"""What a run keeps and tells: pictures, spans of states, a log of commands, how a phase began, what k leaves open."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fsm_calib.actions.bench import KeptFrame
from fsm_calib.diagnosis.design.from_turns import ONCE
from fsm_calib.errors import DataError, InputError, RobotLost
from fsm_calib.outcome import Outcome
from fsm_calib.runner import loop
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.knowledge import teach_files
from fsm_calib.runner.lane_doubt import DRIVE, MEASURE, LaneDoubt, straights_of
from fsm_calib.runner.logged import LoggedRobot
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.record import RunRecord
from fsm_calib.types import STOP, Frame, WheelCommand


def kept(time: float) -> KeptFrame:
    return KeptFrame(np.zeros((4, 6), np.uint8), time, "look", np.array([[1.0, 2.0], [3.0, 4.004]]))


def files_in(directory: Path) -> list[str]:
    return sorted(str(path.relative_to(directory)) for path in directory.rglob("*.jpg"))


def test_a_kept_frame_is_written_with_what_was_found_in_it(tmp_path: Path) -> None:
    gallery = Gallery(tmp_path, 2)
    gallery.add(kept(1.25), "scan/turning", "A board.")
    (picture,) = gallery.pictures
    assert files_in(tmp_path) == [picture.file] == ["frames/scan-00001250.jpg"]
    assert (picture.path, picture.sentence, picture.width, picture.height) == (
        "scan/turning",
        "A board.",
        6,
        4,
    )
    assert picture.points == [[1.0, 2.0], [3.0, 4.0]]


def test_of_too_many_frames_of_a_phase_every_second_goes_and_other_phases_keep_theirs(tmp_path: Path) -> None:
    gallery = Gallery(tmp_path, 2)
    for path, time in (("focus", 0.0), ("scan/a", 1.0), ("scan/b", 2.0), ("scan/a", 3.0)):
        gallery.add(kept(time), path, "")
    assert [picture.time for picture in gallery.pictures] == [0.0, 1.0, 2.0, 3.0]
    gallery.add(kept(4.0), "scan/b", "")
    assert [picture.time for picture in gallery.pictures] == [0.0, 1.0, 3.0]
    assert files_in(tmp_path) == sorted(picture.file for picture in gallery.pictures)


def test_a_run_that_keeps_no_frames_writes_none(tmp_path: Path) -> None:
    gallery = Gallery(tmp_path, 0)
    gallery.add(kept(0.0), "scan", "")
    assert (gallery.pictures, files_in(tmp_path)) == ([], [])


def test_a_gallery_goes_on_with_the_pictures_of_its_state(tmp_path: Path) -> None:
    gallery = Gallery(tmp_path, 2)
    gallery.add(kept(1.0), "scan", "")
    assert Gallery.from_state(tmp_path, 2, gallery.to_state()).pictures == gallery.pictures


def record(directory: Path, events: list[tuple[str, float]]) -> RunRecord:
    told = [{"path": path, "time": time} for path, time in events]
    return RunRecord(directory, None, None, None, {}, told, None, None, (), {}, None, {})  # type: ignore[arg-type]


def test_stays_in_one_state_that_follow_each_other_are_one_span(tmp_path: Path) -> None:
    events = [("scan/a", 1.0), ("scan/a", 2.5), ("scan/b", 3.0), ("scan/a", 4.0)]
    assert record(tmp_path, events).spans == [
        ("scan/a", 0.0, 2.5),
        ("scan/b", 2.5, 3.0),
        ("scan/a", 3.0, 4.0),
    ]


def test_a_picture_is_shown_by_its_own_content(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(b"jpeg")
    url = record(tmp_path, []).data_url(SimpleNamespace(file="a.jpg"))  # type: ignore[arg-type]
    assert url == "data:image/jpeg;base64,anBlZw=="


class Still:
    """A robot that keeps what it is told; its camera gives the frame that it was made with."""

    def __init__(self, frame: Frame | None = None) -> None:
        self.told: list[object] = []
        self.time, self.frame = 2.0, frame

    def command(self, command: WheelCommand) -> None:
        self.told.append(command)

    def run(self, command: WheelCommand, duration: float) -> None:
        self.told.append((command, duration))
        self.time += duration

    def wait(self, duration: float) -> None:
        self.time += duration

    def now(self) -> float:
        return self.time

    def capture(self) -> Frame | None:
        return self.frame


FRAME = Frame(np.zeros((2, 2), np.uint8), 2.0, 0)
HALF = WheelCommand(0.5, 0.25)


def logged(robot: Still, **given: float) -> LoggedRobot:
    return LoggedRobot(robot, Parts("rest"), **given)  # type: ignore[arg-type]


def test_every_command_is_logged_with_the_time_at_which_it_begins() -> None:
    still = Still()
    robot = logged(still)
    robot.command(HALF)
    robot.wait(1.0)
    robot.run(HALF, 0.5)
    assert still.told == [HALF, (HALF, 0.5)]
    assert robot.drain() == [(2.0, 0.5, 0.25), (3.0, 0.5, 0.25), (3.5, 0.0, 0.0)]
    assert robot.drain() == []


def test_the_stop_at_the_end_is_not_logged() -> None:
    still = Still()
    robot = logged(still)
    robot.stop()
    assert (still.told, robot.drain()) == ([STOP], [])


@pytest.mark.parametrize("command", [WheelCommand(float("nan"), 0.0), WheelCommand(0.0, float("inf"))])
def test_a_command_that_is_no_number_is_neither_logged_nor_passed_on(command: WheelCommand) -> None:
    still = Still()
    robot = logged(still)
    with pytest.raises(DataError, match="not finite"):
        robot.command(command)
    assert (still.told, robot.drain()) == ([], [])


def test_a_frame_of_a_run_that_goes_on_has_the_run_s_time() -> None:
    robot = logged(Still(FRAME), frames=4, began=100.0)
    frame = robot.capture()
    assert frame is not None
    assert (frame.time, robot.now(), robot.frames) == (102.0, 102.0, 5)


def test_a_frame_of_a_new_run_is_the_robot_s_own() -> None:
    assert logged(Still(FRAME)).capture() is FRAME


def test_a_lost_frame_of_a_run_that_goes_on_is_lost_and_counted() -> None:
    robot = logged(Still(None), frames=4, began=100.0)
    assert robot.capture() is None
    assert robot.frames == 5


class Wheels:
    """A logged robot of which only its stop matters."""

    def __init__(self, lost: bool = False) -> None:
        self.stops, self.lost = 0, lost

    def stop(self) -> None:
        self.stops += 1
        if self.lost:
            raise RobotLost("gone")

    def now(self) -> float:
        return 4.0


def ending(*, terminal: bool = False, wheels: Wheels | None = None) -> SimpleNamespace:
    """A run that is to be ended: its machine, what it appends and tells."""
    appended, told = [], []
    machine = SimpleNamespace(
        is_terminal=terminal, state="aborted", fire=lambda outcome: "fired", activity=None
    )
    return SimpleNamespace(
        machine=machine,
        robot=wheels or Wheels(),
        journal=SimpleNamespace(append=appended.append),
        observer=SimpleNamespace(event=lambda *given: told.append(given)),
        appended=appended,
        told=told,
    )


ABORT = Outcome("abort", {}, "Stopped.", "")


@pytest.mark.parametrize("lost", [False, True])
def test_a_run_ends_with_stopped_wheels_a_journal_line_and_word_to_who_watches(
    monkeypatch: pytest.MonkeyPatch, lost: bool
) -> None:
    monkeypatch.setattr(loop, "event_record", lambda run, activity, outcome, fired: (activity, fired))
    run = ending(wheels=Wheels(lost))
    loop.step_abort(run, ABORT)
    assert (run.robot.stops, run.appended, run.told) == (1, [("", "fired")], [("aborted", "", ABORT, 4.0)])


def test_a_run_that_has_ended_is_not_ended_again() -> None:
    run = ending(terminal=True)
    loop.step_abort(run, ABORT)
    assert (run.robot.stops, run.appended, run.told) == (0, [], [])


def test_a_machine_at_its_end_has_no_step() -> None:
    run = ending()
    loop.step(run)
    assert (run.appended, run.told) == ([], [])


def test_a_phase_begins_with_the_state_the_books_and_what_the_bench_holds() -> None:
    machine = SimpleNamespace(state="between", books=SimpleNamespace(to_dict=lambda: {"ticks": 3}))
    run = SimpleNamespace(machine=machine, bench=SimpleNamespace(to_state=lambda: {"k": 1.0}))
    assert loop.begun_of(run) == {"state": "between", "books": {"ticks": 3}, "bench": {"k": 1.0}}  # type: ignore[arg-type]


@pytest.mark.parametrize(("dest", "begun"), [("scan/turning", "earlier"), ("between", "now")])
def test_a_real_robot_s_checkpoint_holds_the_beginning_of_its_phase(
    monkeypatch: pytest.MonkeyPatch, dest: str, begun: str
) -> None:
    monkeypatch.setattr(loop, "event_record", lambda *given: {})
    monkeypatch.setattr(loop, "begun_of", lambda run: {"state": "now"})
    kept: list[dict] = []
    journal = SimpleNamespace(
        append=lambda line: None, checkpoint=lambda state, durable: kept.append(state | {"durable": durable})
    )
    run = SimpleNamespace(
        heading={}, sequence=3, begun={"state": "earlier"}, journal=journal, gallery=Gallery(Path(), 0),
        machine=SimpleNamespace(state=dest, books=SimpleNamespace(to_dict=dict)),
        robot=SimpleNamespace(now=lambda: 1.0, frames=2),
        bench=SimpleNamespace(to_state=dict, seen_frames=2),
    )  # fmt: skip
    loop.record(run, "look", ABORT, SimpleNamespace(source="scan/a", dest=dest))  # type: ignore[arg-type]
    (state,) = kept
    assert (state["begun"], run.begun) == ({"state": begun}, {"state": begun})
    assert (state["sequence"], state["durable"]) == (4, dest == "between")


def test_a_lost_robot_ends_its_run_by_name_with_reason_and_cure() -> None:
    outcome = loop.lost_outcome(RobotLost("no answer", cure="Charge it."))
    assert (outcome.trigger, outcome.evidence) == ("abort", {"lost": "RobotLost"})
    assert (outcome.sentence, outcome.cure) == ("no answer.", "Charge it.")


@pytest.mark.parametrize(("files", "said"), [((), "no camera file"), (("a", "b"), "2 camera files")])
def test_a_folder_of_an_earlier_run_must_hold_one_camera(
    tmp_path: Path, files: tuple[str, ...], said: str
) -> None:
    for kind in ("intrinsic", "extrinsic"):
        folder = tmp_path / "calibrations" / f"camera_{kind}"
        folder.mkdir(parents=True)
        for name in files:
            (folder / f"{name}.yaml").touch()
    with pytest.raises(InputError, match=said):
        teach_files(None, tmp_path)  # type: ignore[arg-type]


SETTLES = SimpleNamespace(seconds=12.0, why="tells a from b")


def doubt(*likely: tuple[str, float], plan: object = None) -> str:
    return LaneDoubt(0.02, 5, SimpleNamespace(probabilities=likely), plan).sentence  # type: ignore[arg-type]


def test_what_happened_once_is_said_where_it_is_likelier_than_not() -> None:
    assert "Something happened once" in doubt((ONCE, 0.5), ("", 0.5))
    assert "Something happened once" not in doubt((ONCE, 0.45), ("tyre_scrub", 0.4))


def test_drives_that_tell_nothing_say_so() -> None:
    assert "do not tell" in doubt(("", 0.6), ("tyre_scrub", 0.4))


def test_one_likely_name_is_said_alone_and_of_unlikely_ones_each() -> None:
    assert doubt(("tyre_scrub", 0.5), ("wheel_slip", 0.3)).endswith("Likely tyre_scrub (50%).")
    assert doubt(("tyre_scrub", 0.45), ("wheel_slip", 0.4)).endswith(
        "Likely tyre_scrub (45%) or wheel_slip (40%)."
    )
    assert doubt((ONCE, 0.45), ("", 0.4)).endswith("Likely nothing of the catalogue.")


def test_a_drive_that_would_settle_it_is_proposed() -> None:
    assert "A drive of 12 s tells a from b" in doubt(("tyre_scrub", 0.8), plan=SETTLES)


def event(activity: str, trigger: str, *times: float) -> dict[str, object]:
    return {"activity": activity, "trigger": trigger, "commands": [(time, 0.0, 0.0) for time in times]}


def test_straights_are_the_drives_that_were_measured_and_the_last_ones_of_them() -> None:
    events = [
        event(DRIVE, "marker_reached", 1.0, 2.0),
        event("look", MEASURE),
        event(DRIVE, "marker_missed", 3.0, 4.0),
        event(DRIVE, "marker_reached", 5.0, 6.0),
        event("look", MEASURE),
        event("look", MEASURE),
        event(DRIVE, "marker_reached", 7.0, 8.0),
        event("look", "marker_missed"),
        event("look", MEASURE),
    ]
    runs = [SimpleNamespace(distance=0.1, turned=0.01, sd=0.002)] * 2
    straights = straights_of(runs, events)  # type: ignore[arg-type]
    assert (straights.begin.tolist(), straights.stop.tolist()) == ([5.0, 7.0], [6.0, 8.0])
    assert straights.way.tolist() == [0.1, 0.1]
