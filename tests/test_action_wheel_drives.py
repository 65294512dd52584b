"""A drive over the markers and what follows: its length, its k_i, what stood in the way, how long the next one is."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from fsm_calib.actions import Bench, wheel_runs, with_published
from fsm_calib.actions.held_up import DRIVE_BLOCKED
from fsm_calib.actions.looking import FRAME_MISSING
from fsm_calib.actions.notebook import MarkerReading, WheelRun
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.actions.turning import WHEEL_STALLED
from fsm_calib.actions.wheel_runs import drive_back, drive_forward, driven, measure_ratio
from fsm_calib.types import STOP, Pose2, TagObservation, WheelCommand

FIELD = {number: Pose2(0.25 + 0.15 * number, 0.1 * (number % 3 - 1), 0.0) for number in range(6)}
PUBLISHED = with_published(ActionSettings(), "equation_3")


class Wheels:
    """A robot that only keeps what it was commanded."""

    def __init__(self) -> None:
        self.commands: list[tuple[WheelCommand, float]] = []

    def command(self, command: WheelCommand) -> None:
        pass

    def run(self, command: WheelCommand, duration: float) -> None:
        self.commands.append((command, duration))

    def wait(self, duration: float) -> None:
        pass

    def now(self) -> float:
        return 0.0


def seen_from(robot: Pose2, numbers: range = range(6)) -> tuple[TagObservation, ...]:
    """The markers of the field that a robot at a pose has ahead, the nearest first."""
    places = {number: robot.inverse().then(FIELD[number]) for number in numbers}
    tags = [
        TagObservation(n, p.x, p.y, p.theta, math.hypot(p.x, p.y)) for n, p in places.items() if p.x > 0.1
    ]
    return tuple(sorted(tags, key=lambda tag: tag.distance))


def reading_from(robot: Pose2, numbers: range = range(6)) -> MarkerReading:
    tags = seen_from(robot, numbers)
    return MarkerReading(tags, tags[0].heading, 0.0)


def run_of(distance: float, duration: float = 2.0, k_i: float = 1.0) -> WheelRun:
    return WheelRun(1.0, duration, distance, 0.0, 0.003, k_i)


@pytest.fixture
def bench() -> Bench:
    """A bench whose robot measured the markers at the origin and then drove for 2 s."""
    bench = Bench(Wheels())
    bench.notebook.reading, bench.notebook.last_duration = reading_from(Pose2()), 2.0
    return bench


def shows(monkeypatch: pytest.MonkeyPatch, reading: object) -> None:
    monkeypatch.setattr(wheel_runs, "read_markers", lambda bench: reading)


def looks(monkeypatch: pytest.MonkeyPatch, *sights: object) -> None:
    """Let each look show the next of these, and the last one from then on."""
    left = list(sights)
    monkeypatch.setattr(
        wheel_runs, "look_at_markers", lambda bench: left.pop(0) if len(left) > 1 else left[0]
    )


def test_a_drive_among_markers_tells_its_length_speed_and_mismatch(bench: Bench, monkeypatch) -> None:
    shows(monkeypatch, reading_from(Pose2(0.3, 0.0, 0.05)))
    assert measure_ratio(bench).trigger == "ratio_measured"
    (run,) = bench.notebook.runs
    assert run.distance == pytest.approx(0.3, rel=1e-3)
    assert run.k_i == pytest.approx(1.0 - 0.05 * bench.settings.ratio.axle_length / run.distance)
    assert bench.notebook.speed == pytest.approx(run.distance / 2.0)
    assert bench.notebook.is_length_told
    assert len(bench.notebook.readings) == 2


def test_a_drive_to_the_side_teaches_where_the_camera_looks(bench: Bench, monkeypatch) -> None:
    shows(monkeypatch, reading_from(Pose2(0.3, 0.012, 0.0)))
    measure_ratio(bench)
    assert bench.notebook.mount.yaw == pytest.approx(-math.atan2(0.012, 0.3))


def test_a_drive_that_no_marker_measures_is_as_long_as_its_speed_and_time(bench: Bench, monkeypatch) -> None:
    bench.notebook.reading = reading_from(Pose2(), range(2))
    shows(monkeypatch, reading_from(Pose2(0.3, 0.0, 0.0), range(3, 6)))
    assert measure_ratio(bench).trigger == "ratio_measured"
    assert bench.notebook.runs[0].distance == pytest.approx(2.0 * bench.settings.drive.expected_speed)
    assert bench.notebook.speed == 0.0
    assert not bench.notebook.is_length_told
    assert bench.notebook.mount.yaw == 0.0


def test_a_start_that_the_map_does_not_know_begins_a_new_map(bench: Bench) -> None:
    bench.notebook.marker_map = {99: Pose2(5.0, 5.0, 0.0)}
    distance, is_told = driven(bench, bench.notebook.reading, reading_from(Pose2(0.3, 0.0, 0.0)))
    assert (distance, is_told) == (pytest.approx(0.3), True)
    assert set(bench.notebook.marker_map) == set(FIELD)


def test_a_map_that_knows_the_start_grows_by_what_the_end_shows(bench: Bench) -> None:
    bench.notebook.marker_map = {1: Pose2(9.0, 0.0, 0.0)}
    driven(bench, reading_from(Pose2(), range(3)), reading_from(Pose2(0.3, 0.0, 0.0), range(2, 6)))
    assert set(bench.notebook.marker_map) == set(range(6))
    assert bench.notebook.marker_map[5].x == pytest.approx(9.0 + FIELD[5].x - FIELD[1].x)
    assert bench.notebook.last_step.x == pytest.approx(0.3)


def test_without_a_marker_before_the_drive_nothing_is_measured(bench: Bench) -> None:
    bench.notebook.reading = None
    assert measure_ratio(bench).trigger == "marker_missed"


def test_a_lost_frame_after_the_drive_is_told_and_keeps_nothing(bench: Bench, monkeypatch) -> None:
    shows(monkeypatch, FRAME_MISSING)
    assert measure_ratio(bench) is FRAME_MISSING
    assert (bench.notebook.runs, bench.notebook.readings) == ([], [])


@pytest.mark.parametrize(("excess", "is_stalled"), [(-0.05, False), (0.05, True)])
def test_a_mismatch_beyond_what_wheels_differ_by_is_a_wheel_that_stands(
    bench: Bench, monkeypatch, excess: float, is_stalled: bool
) -> None:
    most, axle = bench.settings.drive.one_wheel_mismatch, bench.settings.ratio.axle_length
    chord = 0.05
    shows(monkeypatch, reading_from(Pose2(chord, 0.0, (most + excess) * chord / axle)))
    outcome = measure_ratio(bench)
    assert (outcome is WHEEL_STALLED) is is_stalled
    assert len(bench.notebook.readings) == (0 if is_stalled else 2)
    assert len(bench.notebook.runs) == (0 if is_stalled else 1)


def test_as_published_no_mismatch_is_too_large(bench: Bench, monkeypatch) -> None:
    bench.settings = PUBLISHED
    monkeypatch.setattr(wheel_runs, "run_from_readings", lambda bench, distance: run_of(distance, k_i=3.0))
    shows(monkeypatch, reading_from(Pose2(0.3, 0.0, 0.0)))
    assert measure_ratio(bench).trigger == "ratio_measured"


@pytest.mark.parametrize(
    ("settings", "runs", "way", "is_blocked"),
    [
        (ActionSettings(), [0.5, 0.5, 0.1], 0.29, True),
        (ActionSettings(), [0.5, 0.5, 0.1], 0.31, False),
        (ActionSettings(), [], 0.1, False),
        (PUBLISHED, [0.5, 0.5, 0.1], 0.1, False),
    ],
)
def test_a_drive_shorter_than_the_usual_ones_was_held_up(
    bench: Bench, monkeypatch, settings: ActionSettings, runs: list[float], way: float, is_blocked: bool
) -> None:
    bench.settings = settings
    bench.notebook.runs = [run_of(distance) for distance in runs]
    monkeypatch.setattr(wheel_runs, "run_from_readings", lambda bench, distance: run_of(distance))
    monkeypatch.setattr(wheel_runs, "why_held_up", lambda bench: DRIVE_BLOCKED)
    shows(monkeypatch, reading_from(Pose2(way, 0.0, 0.0)))
    assert (measure_ratio(bench) is DRIVE_BLOCKED) is is_blocked
    assert len(bench.notebook.runs) == len(runs) + (not is_blocked)


def test_a_first_drive_that_moves_the_markers_is_made_once(bench: Bench, monkeypatch) -> None:
    looks(monkeypatch, seen_from(Pose2(0.2, 0.0, 0.0)))
    assert drive_forward(bench).trigger == "drive_finished"
    assert len(bench.robot.commands) == 1
    assert bench.notebook.drive_command == 0.0


def test_a_first_drive_that_moves_nothing_is_made_again_with_more(bench: Bench, monkeypatch) -> None:
    looks(monkeypatch, seen_from(Pose2()), seen_from(Pose2(0.2, 0.0, 0.0)))
    assert drive_forward(bench).trigger == "drive_finished"
    command, factor = bench.settings.drive.command, bench.settings.turn.raise_factor
    assert [asked.left for asked, _ in bench.robot.commands] == [command, command * factor]
    assert bench.notebook.drive_command == command * factor


def test_a_pure_turn_is_a_motion_too(bench: Bench, monkeypatch) -> None:
    start = bench.notebook.reading.tags
    looks(monkeypatch, tuple(replace(tag, heading=tag.heading - 0.3) for tag in start))
    assert drive_forward(bench).trigger == "drive_finished"
    assert len(bench.robot.commands) == 1


def test_markers_that_lie_askew_and_do_not_move_are_no_motion(bench: Bench, monkeypatch) -> None:
    askew = tuple(replace(tag, heading=0.4) for tag in seen_from(Pose2()))
    bench.notebook.reading = MarkerReading(askew, 0.4, 0.0)
    looks(monkeypatch, askew, seen_from(Pose2(0.2, 0.0, 0.0)))
    drive_forward(bench)
    assert len(bench.robot.commands) == 2


def test_a_shift_and_a_turn_add_up(bench: Bench, monkeypatch) -> None:
    start = bench.notebook.reading.tags
    looks(monkeypatch, tuple(replace(tag, x=tag.x - 0.015, heading=tag.heading + 0.05) for tag in start))
    drive_forward(bench)
    assert len(bench.robot.commands) == 1


@pytest.mark.parametrize(
    ("after_the_way_back", "expected"),
    [(seen_from(Pose2()), WHEEL_STALLED), (seen_from(Pose2(-0.2, 0.0, 0.0)), DRIVE_BLOCKED), ((), DRIVE_BLOCKED)],
)  # fmt: skip
def test_wheels_that_move_nothing_with_the_most_are_tried_backwards(
    bench: Bench, monkeypatch, after_the_way_back: tuple[TagObservation, ...], expected: object
) -> None:
    bench.settings = replace(bench.settings, turn=replace(bench.settings.turn, largest_command=0.3))
    looks(monkeypatch, seen_from(Pose2()), after_the_way_back)
    assert drive_forward(bench) is expected
    command = bench.settings.drive.command
    assert [asked.left for asked, _ in bench.robot.commands] == [command, -command]


def test_markers_that_are_gone_after_the_first_drive_do_not_say_that_it_stood(
    bench: Bench, monkeypatch
) -> None:
    looks(monkeypatch, ())
    assert drive_forward(bench).trigger == "drive_finished"


def test_a_way_back_is_as_long_as_the_way_there_with_its_ratio(bench: Bench) -> None:
    bench.notebook.last_ratio, bench.notebook.is_length_told = 1.1, True
    drive_back(bench)
    command = -bench.settings.drive.command
    assert bench.robot.commands == [(WheelCommand(command, 1.1 * command), 2.0)]


@pytest.mark.parametrize(("sight", "settings"), [(FRAME_MISSING, ActionSettings()), ((), PUBLISHED)])
def test_a_lost_frame_or_the_published_rules_tell_no_obstacle_on_the_way_back(
    bench: Bench, monkeypatch, sight: object, settings: ActionSettings
) -> None:
    bench.settings, bench.notebook.is_length_told = settings, False
    looks(monkeypatch, sight)
    assert drive_back(bench).trigger == "drive_finished"


def duration_of(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> float:
    """How long the next drive forward is [s]."""
    looks(monkeypatch, ())
    bench.notebook.reading = None
    drive_forward(bench)
    return bench.robot.commands[-1][1]


def test_the_first_drive_keeps_the_worst_mismatch_in_sight(bench: Bench, monkeypatch) -> None:
    drive, ratio = bench.settings.drive, bench.settings.ratio
    length = drive.largest_heading_change * ratio.axle_length / drive.first_mismatch
    assert duration_of(bench, monkeypatch) == pytest.approx(length / drive.expected_speed)


def test_a_drive_after_a_small_mismatch_grows_to_at_most_twice_the_last(bench: Bench, monkeypatch) -> None:
    bench.notebook.runs, bench.notebook.speed = [run_of(0.3, k_i=1.001)], 0.15
    assert duration_of(bench, monkeypatch) == pytest.approx(bench.settings.drive.growth * 0.3 / 0.15)


def test_a_drive_is_never_longer_than_a_full_one(bench: Bench, monkeypatch) -> None:
    bench.notebook.runs, bench.notebook.speed = [run_of(1.1, k_i=1.0)], 0.2
    assert duration_of(bench, monkeypatch) == pytest.approx(bench.settings.drive.distance / 0.2)


def test_a_drive_is_as_long_as_the_mismatch_that_the_last_one_leaves_allows(
    bench: Bench, monkeypatch
) -> None:
    bench.notebook.runs, bench.notebook.speed = [run_of(1.0, k_i=0.9)], 0.2
    drive, ratio = bench.settings.drive, bench.settings.ratio
    left = (1.0 - ratio.share) * 0.1 + drive.mismatch_margin
    length = drive.largest_heading_change * ratio.axle_length / left
    assert duration_of(bench, monkeypatch) == pytest.approx(length / 0.2)


def test_a_drive_is_never_shorter_than_the_shortest(bench: Bench, monkeypatch) -> None:
    bench.notebook.runs, bench.notebook.speed = [run_of(0.01, k_i=1.0)], 0.2
    assert duration_of(bench, monkeypatch) == pytest.approx(bench.settings.drive.shortest / 0.2)


def test_as_published_every_drive_takes_the_same_time(bench: Bench, monkeypatch) -> None:
    bench.settings = PUBLISHED
    assert duration_of(bench, monkeypatch) == PUBLISHED.ratio.published_duration
    assert bench.robot.commands[-1][0] != STOP
