"""One step of a turn: what the picture tells, and what follows when it tells nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fsm_calib.actions import Bench
from fsm_calib.actions.looking import FRAME_MISSING
from fsm_calib.actions.moving import CLOCKWISE, COUNTERCLOCKWISE
from fsm_calib.actions.turning import Step, turn_step, turned_evidence
from fsm_calib.perception.turning import panorama, turn_between
from fsm_calib.types import Frame, WheelCommand

SIZE = (480, 640)
STEP = math.radians(5.0)


class Slides:
    """A robot whose camera shows prepared pictures, one after the other, with fresh noise."""

    def __init__(self, *pictures: np.ndarray | None) -> None:
        self.pictures, self.commands = list(pictures), []
        self._rng = np.random.default_rng(0)

    def command(self, command: WheelCommand) -> None:
        self.commands.append(command)

    def wait(self, duration: float) -> None:
        pass

    def run(self, command: WheelCommand, duration: float) -> None:
        self.commands.append(command)

    def now(self) -> float:
        return 0.0

    def capture(self) -> Frame | None:
        picture = self.pictures.pop(0) if len(self.pictures) > 1 else self.pictures[0]
        if picture is None:
            return None
        noisy = np.clip(picture + self._rng.normal(0.0, 1.5, SIZE), 0, 255).astype(np.uint8)
        return Frame(noisy, 0.0, 0)


def scene(seed: int) -> np.ndarray:
    """A picture of coarse blocks."""
    blocks = np.random.default_rng(seed).integers(20, 230, (24, 32)).astype(float)
    return np.kron(blocks, np.ones((20, 20)))


def test_a_turn_in_the_dark_is_one_however_little_it_changes() -> None:
    room = 0.04 * np.hstack([scene(1), scene(2)])
    bench = Bench(Slides(room[:, 40 : 40 + SIZE[1]], room[:, : SIZE[1]]))
    step = turn_step(bench, COUNTERCLOCKWISE, STEP)
    assert isinstance(step, Step)
    assert (
        turn_between(*(panorama(room[:, at : at + SIZE[1]].astype(np.uint8)) for at in (40, 0))).change < 4.0
    )
    assert step.turned == pytest.approx(math.radians(6.0), abs=math.radians(2.0))


@pytest.mark.parametrize(("way", "sign"), [(CLOCKWISE, -1.0), (COUNTERCLOCKWISE, 1.0)])
def test_a_picture_that_changed_beyond_any_shift_counts_as_the_turn_expected(way: str, sign: float) -> None:
    bench = Bench(Slides(scene(1), scene(2)))
    step = turn_step(bench, way, STEP)
    assert isinstance(step, Step)
    assert step.turned == pytest.approx(sign * STEP)
    assert bench.notebook.push_gain == {}


def test_a_picture_that_stays_raises_the_command_up_to_the_most_and_then_tries_backwards() -> None:
    robot = Slides(scene(1))
    outcome = turn_step(Bench(robot), CLOCKWISE, STEP)
    pushes = [command.left for command in robot.commands if command.left != 0.0]
    most = Bench(robot).settings.turn.largest_command
    assert outcome.trigger == "wheel_stalled"
    assert pushes[:-1] == sorted(pushes[:-1])
    assert pushes[-2:] == [most, -most]


def turned_scene(columns: int) -> np.ndarray:
    """The picture of scene 1 moved to the right by so many pixels: the robot turned counter-clockwise."""
    return np.roll(scene(1), columns, axis=1)


@pytest.mark.parametrize(("way", "columns", "sign"), [(CLOCKWISE, -24, -1.0), (COUNTERCLOCKWISE, 24, 1.0)])
def test_a_shifted_picture_tells_the_turn_and_what_a_push_does(way: str, columns: int, sign: float) -> None:
    bench = Bench(Slides(scene(1), turned_scene(columns)))
    step = turn_step(bench, way, STEP)
    assert sign * step.turned > math.radians(1.0)
    assert bench.notebook.push_gain == {
        way: pytest.approx(abs(step.turned) / bench.settings.turn.first_command)
    }


def test_the_gain_learnt_is_the_mean_of_what_was_known_and_the_newest_push() -> None:
    bench = Bench(Slides(scene(1), turned_scene(24)))
    bench.notebook.push_gain = {COUNTERCLOCKWISE: 2.0}
    step = turn_step(bench, COUNTERCLOCKWISE, STEP)
    command = STEP / 2.0
    assert bench.notebook.push_gain[COUNTERCLOCKWISE] == pytest.approx(0.5 * (2.0 + step.turned / command))


def test_a_turn_the_wrong_way_teaches_nothing() -> None:
    bench = Bench(Slides(scene(1), turned_scene(24)))
    turn_step(bench, CLOCKWISE, STEP)
    assert bench.notebook.push_gain == {}


def test_a_way_that_was_never_pushed_takes_the_gain_of_the_other() -> None:
    robot = Slides(scene(1), turned_scene(24))
    bench = Bench(robot)
    bench.notebook.push_gain = {CLOCKWISE: 4.0}
    turn_step(bench, COUNTERCLOCKWISE, STEP)
    assert -robot.commands[0].left == pytest.approx(STEP / 4.0)


def test_a_lost_first_frame_is_told_before_anything_moves() -> None:
    robot = Slides(None)
    assert turn_step(Bench(robot), CLOCKWISE, STEP) is FRAME_MISSING
    assert robot.commands == []


def test_a_lost_frame_after_a_push_is_made_up_for_by_a_look_without_one() -> None:
    robot = Slides(scene(1), None, turned_scene(24))
    bench = Bench(robot)
    assert turn_step(bench, COUNTERCLOCKWISE, STEP) is FRAME_MISSING
    pushes = len(robot.commands)
    step = turn_step(bench, COUNTERCLOCKWISE, STEP)
    assert isinstance(step, Step)
    assert step.turned > math.radians(1.0)
    assert len(robot.commands) == pushes


def test_a_lost_frame_when_looking_again_is_told_again() -> None:
    bench = Bench(Slides(scene(1), None, None))
    turn_step(bench, COUNTERCLOCKWISE, STEP)
    assert turn_step(bench, COUNTERCLOCKWISE, STEP) is FRAME_MISSING


def test_a_first_look_that_was_lost_tells_no_turn_when_it_comes_after_all() -> None:
    bench = Bench(Slides(None, scene(1)))
    turn_step(bench, COUNTERCLOCKWISE, STEP)
    step = turn_step(bench, COUNTERCLOCKWISE, STEP)
    assert isinstance(step, Step)
    assert step.turned == 0.0


def test_a_robot_that_turns_one_way_only_stands_against_something() -> None:
    robot = Slides(*[scene(1)] * 8, turned_scene(24))
    bench = Bench(robot)
    assert turn_step(bench, CLOCKWISE, STEP).trigger == "robot_blocked"
    assert robot.commands[-1].left == -bench.settings.turn.largest_command


def test_a_push_that_moved_nothing_is_remembered_as_too_weak() -> None:
    robot = Slides(scene(1), scene(1), turned_scene(24), turned_scene(48))
    bench = Bench(robot)
    turn_step(bench, COUNTERCLOCKWISE, STEP)
    first, second = (abs(command.left) for command in robot.commands if command.left)
    assert second == pytest.approx(first * bench.settings.turn.raise_factor)
    assert bench.notebook.push_floor == pytest.approx(first)
    turn_step(bench, COUNTERCLOCKWISE, math.radians(0.1))
    assert -robot.commands[-1].left == pytest.approx(1.05 * first)


@pytest.mark.parametrize(("turned", "told"), [(0.1234567, 0.12346), (math.nan, 0.0), (math.inf, 0.0)])
def test_the_journal_hears_a_finite_angle(turned: float, told: float) -> None:
    frame = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 0)
    assert turned_evidence(Step(frame, turned)) == {"turned": told}
