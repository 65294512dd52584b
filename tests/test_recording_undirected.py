"""Counts of encoders that cannot tell the direction, signed by what moved the wheel."""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import CommandTrack, WheelPair
from fsm_calib.recording.undirected import directed

STEP, EVERY = 0.001, 33
"""The wheels turn in steps of this [s]; every so many of them the driver tells its counts."""
ANSWER = 0.15
"""How long a wheel takes to answer a command [s]."""
TICK = 2.0 * np.pi / 135
"""One edge of Duckietown's encoders [rad]."""
Hold = tuple[float, float, float]
"""Seconds, and the commands of both wheels [1]."""
THERE_AND_BACK: tuple[Hold, ...] = ((1, 0.2, 0.2), (1, 0, 0), (1, -0.2, -0.2), (1, 0, 0), (1, 0, 0.3))


def angles(command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the true angle [rad] of a wheel under `command` (n,), and what Duckietown's driver tells of it."""
    speed = np.zeros(len(command))
    for k in range(1, len(command)):
        speed[k] = speed[k - 1] + (20.0 * command[k] - speed[k - 1]) * STEP / ANSWER
    signs = np.where(command < 0.0, -1.0, 1.0)
    return np.cumsum(speed) * STEP, np.cumsum(np.abs(speed) * signs) * STEP


def driven(*holds: Hold) -> tuple[CommandTrack, WheelPair, WheelPair]:
    """Return the commands, the wheels as they truly turn, and as the driver tells it."""
    rows = np.array([pair for seconds, *pair in holds for _ in range(round(seconds / STEP))], dtype=float)
    begins = np.cumsum([0.0, *(seconds for seconds, _, _ in holds[:-1])])
    command = CommandTrack(begins, *(np.array([float(hold[k]) for hold in holds]) for k in (1, 2)))
    (left, told_left), (right, told_right) = angles(rows[:, 0]), angles(rows[:, 1])
    time, seen = STEP * np.arange(len(rows)), slice(None, None, EVERY)
    return (
        command,
        WheelPair(time[seen], left[seen], right[seen], "rad"),
        WheelPair(time[seen], told_left[seen], told_right[seen], "rad"),
    )


def test_a_wheel_that_rolls_out_backwards_counts_backward() -> None:
    command, true, told = driven(*THERE_AND_BACK)
    assert told.left[-1] > true.left[-1] + 0.9
    found = directed(told, command)
    assert np.allclose(found.left, true.left, atol=TICK)
    assert np.allclose(found.right, true.right, atol=TICK)


def test_a_wheel_that_stands_while_the_other_drives_is_taken_as_standing() -> None:
    command, _, told = driven(*THERE_AND_BACK)
    pivots = told.time > 4.1
    dragged = told.left + np.where(pivots, 0.1 * (told.time - 4.1), 0.0)
    found = directed(WheelPair(told.time, dragged, told.right, "rad"), command)
    assert np.ptp(found.left[pivots]) == 0.0


def test_encoders_that_know_the_direction_stay_as_they_are() -> None:
    command, true, _ = driven(*THERE_AND_BACK)
    found = directed(true, command)
    assert np.array_equal(found.left, true.left)
    assert np.array_equal(found.right, true.right)


def test_wheels_without_a_command_stay_forward() -> None:
    time = 0.03 * np.arange(90)
    wheels = WheelPair(time, 2.0 * time, 2.0 * time, "rad")
    nothing = CommandTrack(np.array([5.0]), np.zeros(1), np.zeros(1))
    assert np.allclose(directed(wheels, nothing).left, wheels.left)
