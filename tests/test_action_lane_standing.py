"""A robot that pushes at something in the lane is noticed by its pictures; driving back tells what holds it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from fsm_calib.actions import Bench
from fsm_calib.actions.lane_standing import LANE_BLOCKED, WHEELS_STALLED, Stretch, is_same, why_standing
from fsm_calib.actions.looking import FRAME_MISSING
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.perception.turning import panorama
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import STOP, Frame, WheelCommand

SETTINGS = ActionSettings()
ANSWER, PERIOD = SETTINGS.lane.motor_answer, SETTINGS.lane.period
BLOCKS = np.random.default_rng(3).uniform(20.0, 220.0, (12, 18))
ROOM = cv2.resize(BLOCKS, (720, 480), interpolation=cv2.INTER_CUBIC)
"""A room [grey levels] of which a picture shows 640 columns."""


def picture(at: int, light: float = 1.0, seed: int = 0) -> np.ndarray:
    """Return what the robot sees from a place, one column of the room per unit."""
    noise = np.random.default_rng(seed).normal(0.0, 2.0, (480, 640))
    gray = np.clip(ROOM[:, at : at + 640] * light + noise, 0.0, 255.0).astype(np.uint8)
    return np.repeat(gray[..., None], 3, axis=2)


def frame(time: float) -> Frame:
    return Frame(np.zeros((2, 2, 3), np.uint8), time, 0)


def stretch_of(pictures: list[np.ndarray], lag: float = 0.0) -> Stretch:
    """Return a stretch whose looks saw these panoramas, each `lag` [s] before it was at hand."""
    stretch = Stretch(SETTINGS)
    for number, seen in enumerate(pictures):
        stretch.see(frame(number * PERIOD - lag), seen)
        stretch.steer(number * PERIOD)
    return stretch


def panoramas(*places: int, light: float = 1.0) -> list[np.ndarray]:
    return [panorama(picture(at, light, seed=number)) for number, at in enumerate(places)]


def test_pictures_that_differ_by_their_noise_alone_are_of_a_robot_that_stands() -> None:
    assert stretch_of(panoramas(0, 0, 0, 0)).stands()


@pytest.mark.parametrize("light", [1.0, 0.2])
def test_pictures_of_a_moving_robot_differ_in_any_light(light: float) -> None:
    assert not stretch_of(panoramas(0, 12, 24, 36, light=light)).stands()


def test_one_step_among_the_pictures_is_a_motion() -> None:
    assert not stretch_of(panoramas(0, 12, 12, 24)).stands()


def test_a_picture_from_before_the_wheels_answered_tells_nothing() -> None:
    assert not stretch_of(panoramas(0, 0, 0, 0), lag=2.0 * PERIOD).stands()


def test_the_first_picture_which_no_command_preceded_is_left_out() -> None:
    assert stretch_of(panoramas(12, 0, 0, 0)).stands()


def zoomed(share: float, light: float, noise: float, seed: int) -> np.ndarray:
    """Return the panorama of a room that is nearer by a share, as after driving on."""
    near = cv2.resize(picture(0)[..., 0], None, fx=1.0 + share, fy=1.0 + share)[:480, :640]
    noisy = near * light + np.random.default_rng(seed).normal(0.0, noise, near.shape)
    return panorama(np.clip(noisy, 0.0, 255.0).astype(np.uint8))


@pytest.mark.parametrize(("light", "noise"), [(1.0, 2.0), (1.0, 10.0), (0.1, 1.2)])
def test_a_picture_that_came_nearer_is_another_one_in_the_dark_and_in_noise(
    light: float, noise: float
) -> None:
    far, again, near = (zoomed(share, light, noise, seed) for seed, share in enumerate((0.0, 0.0, 0.1)))
    assert is_same(SETTINGS, far, again)
    assert not is_same(SETTINGS, far, near)


class Held:
    """A robot that gets away backward from the given command on."""

    def __init__(self, moves_from: float, frames: int = 99) -> None:
        self.moves_from, self.frames = moves_from, frames
        self.time, self.place, self.driven = 0.0, 0, []

    def command(self, command: WheelCommand) -> None:
        self.driven.append(command)

    def wait(self, duration: float) -> None:
        self.time += duration

    def run(self, command: WheelCommand, duration: float) -> None:
        self.driven.append(command)
        self.time += duration
        if -command.left >= self.moves_from:
            self.place += 12

    def now(self) -> float:
        return self.time

    def capture(self) -> Frame | None:
        self.frames -= 1
        return None if self.frames < 0 else Frame(picture(self.place, seed=self.frames), self.time, 0)


def test_a_robot_that_gets_away_backward_was_blocked() -> None:
    robot = Held(moves_from=SETTINGS.lane.command)
    assert why_standing(Bench(robot)) is LANE_BLOCKED
    back = [WheelCommand(-command, -command) for command in (SETTINGS.lane.command, SETTINGS.drive.command)]
    assert robot.driven == [STOP, *back]


def test_wheels_that_move_nothing_at_their_most_are_dead() -> None:
    robot = Held(moves_from=2.0)
    assert why_standing(Bench(robot)) is WHEELS_STALLED
    assert robot.driven[-1].left == -SETTINGS.turn.largest_command


@pytest.mark.parametrize("frames", [0, 1])
def test_a_frame_that_is_lost_meanwhile_is_told(frames: int) -> None:
    assert why_standing(Bench(Held(moves_from=0.0, frames=frames))) is FRAME_MISSING


def test_a_wall_across_the_lane_ends_the_run_by_its_name_within_seconds(tmp_path: Path) -> None:
    wall = {"x0": -1.57, "y0": 0.2087, "x1": -2.17, "y1": 0.2087, "height": 0.1}
    scenario = Scenario.model_validate(
        {
            "name": "lane",
            "seed": 3,
            "robot": {"source": "fleet", "known": {"camera": True}, "start_in_lane": 0.3},
            "plan": ["lane"],
            "faults": [{"kind": "obstacle", "wall": wall, "at": 1.4}],
            "output": {"report": False, "recording": False, "frames": 0},
        }
    )
    result = run_scenario(scenario, tmp_path).result
    assert (result["failure"]["name"], result["failure"]["state"]) == ("wall_hit", "lane/following")
    assert result["seconds"]["simulated"] < 60.0
