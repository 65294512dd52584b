"""Whether a robot that is commanded along the lane stands, told by its pictures, and what holds it.

A change that is noise is new in every pixel, one that comes of moving extends over many; in the dark either is small.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.held_up import why_held_up
from fsm_calib.actions.looking import look
from fsm_calib.actions.moving import run_wheels
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.outcome import Outcome
from fsm_calib.perception.turning import turn_between
from fsm_calib.types import STOP, Frame, WheelCommand

LANE_BLOCKED = Outcome(
    "robot_blocked",
    sentence="The robot was driven along the lane, its picture stood still; it moves back: something is in its way.",
    cure="Clear the lane before the robot.",
)
WHEELS_STALLED = Outcome(
    "wheel_stalled",
    sentence="The robot does not leave its place in the lane, though both wheels were commanded up to the most.",
    cure="Check the motors' cables, the battery and the wheels.",
)
LEAST_PICTURES = 3
"""Fewer pictures of a commanded robot tell nothing."""


class Stretch:
    """The pictures of one stretch that were taken while the wheels turned, and since when they do [s]."""

    def __init__(self, settings: ActionSettings) -> None:
        self._settings = settings
        self._turning_since = float("inf")
        self._pictures: list[NDArray[np.uint8]] = []

    def see(self, frame: Frame, picture: NDArray[np.uint8] | None) -> None:
        """Remember the panorama of a frame that was taken after the wheels had answered the first command."""
        if picture is not None and frame.time >= self._turning_since:
            self._pictures.append(picture)

    def steer(self, time: float) -> None:
        """Remember when the first command of this stretch will have been answered [s]."""
        self._turning_since = min(self._turning_since, time + self._settings.lane.motor_answer)

    def stands(self) -> bool:
        """Whether every picture is the one before, but for its noise."""
        is_told = len(self._pictures) >= LEAST_PICTURES
        return is_told and all(is_same(self._settings, *pair) for pair in pairwise(self._pictures))


def is_same(settings: ActionSettings, before: NDArray[np.uint8], after: NDArray[np.uint8]) -> bool:
    """Whether two panoramas differ by their noise alone: no shift explains it, and it extends over no pixels."""
    turn = turn_between(before, after)
    is_shifted = turn.likeness >= settings.turn.clear_likeness
    return not is_shifted and turn.autocorrelation < settings.lane.still_autocorrelation


def why_standing(bench: Bench) -> Outcome:
    """Stop and drive back, harder and harder: what an obstacle holds gets away from it, a dead drive does not.

    A robot with one dead wheel turns about it, and does not get away either.
    """
    turn, command = bench.settings.turn, bench.settings.lane.command
    bench.robot.command(STOP)
    bench.robot.wait(bench.settings.drive.settle)
    first = look(bench)
    if isinstance(first, Outcome):
        return first
    while True:
        moved = _back(bench, command)
        if isinstance(moved, Outcome):
            return moved
        if moved:
            return why_held_up(bench, LANE_BLOCKED)
        if command >= turn.largest_command:
            return WHEELS_STALLED
        command = min(command * turn.raise_factor, turn.largest_command)


def _back(bench: Bench, command: float) -> bool | Outcome:
    """Drive back for a stretch with `command`; return whether the picture changed, or the loss of the frame."""
    settings, before = bench.settings.drive, bench.notebook.panorama
    wheels = WheelCommand(-command, -command * bench.notebook.wheel_ratio)
    run_wheels(bench, wheels, settings.stretch / settings.expected_speed, settings.settle)
    seen, after = look(bench), bench.notebook.panorama
    if isinstance(seen, Outcome):
        return seen
    return before is None or after is None or not is_same(bench.settings, before, after)
