"""One step of a turn: what the picture tells, and what follows when it tells nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fsm_calib.actions import Bench
from fsm_calib.actions.moving import CLOCKWISE, COUNTERCLOCKWISE
from fsm_calib.actions.turning import Step, turn_step
from fsm_calib.types import Frame, WheelCommand

SIZE = (480, 640)
STEP = math.radians(5.0)


class Slides:
    """A robot whose camera shows prepared pictures, one after the other, with fresh noise."""

    def __init__(self, *pictures: np.ndarray) -> None:
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

    def capture(self) -> Frame:
        picture = self.pictures.pop(0) if len(self.pictures) > 1 else self.pictures[0]
        noisy = np.clip(picture + self._rng.normal(0.0, 1.5, SIZE), 0, 255).astype(np.uint8)
        return Frame(noisy, 0.0, 0)


def scene(seed: int) -> np.ndarray:
    """A picture of coarse blocks."""
    blocks = np.random.default_rng(seed).integers(20, 230, (24, 32)).astype(float)
    return np.kron(blocks, np.ones((20, 20)))


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
