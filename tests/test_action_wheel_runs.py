"""The shuttle over the markers: obstacles, the bounds of k, what a drive tells of the camera's yaw."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fsm_calib.actions import Bench, wheel_runs, with_published
from fsm_calib.actions.held_up import DRIVE_BLOCKED
from fsm_calib.actions.looking import FRAME_FROZEN
from fsm_calib.actions.notebook import MarkerReading, WheelRun
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.actions.turning import WHEEL_STALLED
from fsm_calib.actions.wheel_runs import drive_back, drive_forward, learn_yaw, update_ratio
from fsm_calib.outcome import Outcome
from fsm_calib.types import STOP, Pose2, TagObservation, WheelCommand


class Wheels:
    """A robot that only keeps what it was commanded."""

    def __init__(self) -> None:
        self.commands: list[WheelCommand] = []

    def command(self, command: WheelCommand) -> None:
        self.commands.append(command)

    def run(self, command: WheelCommand, duration: float) -> None:
        self.commands += [command, STOP]

    def wait(self, duration: float) -> None:
        pass


def marker(number: int, x: float) -> TagObservation:
    return TagObservation(number, x, 0.0, 0.0, x)


def reading(*tags: TagObservation) -> MarkerReading:
    return MarkerReading(tags, 0.0, 0.0)


@pytest.fixture(autouse=True)
def held_by_an_obstacle(monkeypatch: pytest.MonkeyPatch) -> None:
    """What holds a robot up is asked of it elsewhere (`test_action_held_up.py`)."""
    monkeypatch.setattr(wheel_runs, "why_held_up", lambda bench: DRIVE_BLOCKED)


def bench_after_a_drive(back_at: float, settings: ActionSettings | None = None) -> Bench:
    """A bench whose robot drove 0.4 m and back; marker 7, at 0.3 m then, is now at `back_at` [m]."""
    bench = Bench(Wheels(), settings or ActionSettings())
    notebook = bench.notebook
    notebook.runs = [WheelRun(1.0, 2.0, 0.4, 0.0, 0.003, 1.0)]
    notebook.readings = [reading(marker(7, 0.3)), reading(marker(9, 0.4))]
    notebook.reading = reading(marker(7, back_at))
    return bench


def test_a_robot_that_comes_back_to_its_start_drives_on() -> None:
    bench = bench_after_a_drive(back_at=0.33)
    assert drive_forward(bench).trigger == "drive_finished"
    assert bench.robot.commands[-1] == STOP


def test_a_robot_that_the_way_back_took_beyond_its_start_was_held_up_before() -> None:
    bench = bench_after_a_drive(back_at=0.3 + 0.25)
    assert drive_forward(bench).trigger == "robot_blocked"
    assert bench.robot.commands == []


def test_a_camera_yaw_learnt_in_between_is_no_obstacle() -> None:
    bench = bench_after_a_drive(back_at=0.3 + 0.045)
    bench.notebook.runs = [WheelRun(1.0, 0.7, 0.1, 0.0, 0.003, 1.0)]
    assert drive_forward(bench).trigger == "drive_finished"


@pytest.mark.parametrize(
    ("told", "sight", "trigger"),
    [
        (True, (), "drive_finished"),
        (False, (marker(7, 0.33),), "drive_finished"),
        (False, (marker(7, 0.3 + 0.25),), "robot_blocked"),
        (False, (), "robot_blocked"),
    ],
)
def test_a_way_back_that_ends_elsewhere_tells_an_obstacle_where_no_marker_told_the_way_there(
    monkeypatch: pytest.MonkeyPatch, told: bool, sight: tuple[TagObservation, ...], trigger: str
) -> None:
    bench = bench_after_a_drive(back_at=0.3)
    bench.notebook.is_length_told = told
    monkeypatch.setattr(wheel_runs, "look_at_markers", lambda bench: sight)
    assert drive_back(bench).trigger == trigger


def test_a_robot_that_is_back_by_its_picture_lost_the_markers_and_not_its_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = bench_after_a_drive(back_at=0.3)
    bench.notebook.is_length_told = False
    bench.notebook.start_panorama = np.random.default_rng(1).integers(0, 255, (24, 385), dtype=np.uint8)
    bench.notebook.panorama = np.roll(bench.notebook.start_panorama, 8, axis=1)
    monkeypatch.setattr(wheel_runs, "look_at_markers", lambda bench: ())
    assert drive_back(bench).trigger == "drive_finished"
    bench.notebook.panorama = np.random.default_rng(2).integers(0, 255, (24, 385), dtype=np.uint8)
    assert drive_back(bench).trigger == "robot_blocked"


def test_a_camera_that_froze_on_the_way_back_is_no_obstacle(monkeypatch: pytest.MonkeyPatch) -> None:
    bench, sights = bench_after_a_drive(back_at=0.3), [(), FRAME_FROZEN]
    bench.notebook.is_length_told = False
    monkeypatch.setattr(wheel_runs, "look_at_markers", lambda bench: sights.pop(0))
    assert drive_back(bench).trigger == "drive_finished"


def test_as_published_nothing_looks_for_obstacles() -> None:
    settings = with_published(ActionSettings(), "equation_3")
    assert drive_forward(bench_after_a_drive(0.6, settings)).trigger == "drive_finished"


@pytest.mark.parametrize(("k_i", "expected"), [(9.0, 2.0), (-9.0, 0.5)])
def test_k_stays_within_what_wheels_can_differ_by(k_i: float, expected: float) -> None:
    bench = Bench(Wheels())
    bench.notebook.runs = [WheelRun(1.0, 2.0, 0.4, 0.0, 0.003, k_i)]
    update_ratio(bench)
    assert bench.notebook.wheel_ratio == expected


def test_a_straight_drive_teaches_the_cameras_yaw_and_a_turn_does_not() -> None:
    bench, yaw = Bench(Wheels()), 0.04
    bench.notebook.last_step = Pose2(0.5 * math.cos(yaw), -0.5 * math.sin(yaw), 0.0)
    learn_yaw(bench, 0.5)
    assert bench.notebook.mount.yaw == pytest.approx(yaw)
    bench.notebook.last_step = Pose2(-0.1, 0.1, 2.5)
    learn_yaw(bench, 0.5)
    assert bench.notebook.mount.yaw == pytest.approx(yaw)


def test_a_drive_along_an_arc_teaches_the_yaw_about_its_chord() -> None:
    bench, yaw, turned = Bench(Wheels()), 0.04, 0.3
    along = 0.5 * turned - yaw
    bench.notebook.last_step = Pose2(0.5 * math.cos(along), 0.5 * math.sin(along), turned)
    learn_yaw(bench, 0.5)
    assert bench.notebook.mount.yaw == pytest.approx(yaw)


def test_longer_drives_count_more_for_the_yaw_by_the_square_of_their_length() -> None:
    bench = Bench(Wheels())
    for length, yaw in ((0.2, 0.0), (0.4, 0.05)):
        seen = bench.notebook.mount.yaw - yaw
        bench.notebook.last_step = Pose2(length * math.cos(seen), length * math.sin(seen), 0.0)
        learn_yaw(bench, length)
    assert bench.notebook.mount.yaw == pytest.approx(0.04)


@pytest.mark.parametrize(("sideways", "trigger"), [(0.0, "drive_finished"), (0.25, "robot_blocked")])
def test_a_start_that_moved_sideways_is_elsewhere_too(sideways: float, trigger: str) -> None:
    bench = bench_after_a_drive(back_at=0.3)
    bench.notebook.readings[0] = reading(TagObservation(7, 0.3, 0.2, 0.0, 0.36))
    bench.notebook.reading = reading(TagObservation(7, 0.3, 0.2 + sideways, 0.0, 0.36))
    assert drive_forward(bench).trigger == trigger


@pytest.mark.parametrize(
    ("told", "trigger"),
    [(WHEEL_STALLED, "wheel_stalled"), (DRIVE_BLOCKED, "robot_blocked"), (FRAME_FROZEN, "robot_blocked")],
)
def test_a_frame_lost_after_the_robot_was_seen_elsewhere_excuses_no_obstacle(
    monkeypatch: pytest.MonkeyPatch, told: Outcome, trigger: str
) -> None:
    monkeypatch.setattr(wheel_runs, "why_held_up", lambda bench: told)
    assert drive_forward(bench_after_a_drive(back_at=0.3 + 0.25)).trigger == trigger
