"""Encoders that cannot tell which way a wheel turns: their counts signed by what moved the wheel.

Duckietown's driver counts edges and signs each by the last command alone: backward below zero, forward else. So a wheel
that rolls out backwards after a stop counts forward. Here a wheel goes the way of its own last command until the next
one; from when only the other wheel is driven until its own next command it is taken as standing: what it is dragged
along by, it springs back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fsm_calib.recording.channels import CommandTrack, WheelPair
from fsm_calib.types import FloatArray

STANDING = 0
"""Direction of a wheel that is not driven while the other one is."""


def next_direction(before: int, own: float, other: float) -> int:
    """Return which way a wheel goes (1, -1 or `STANDING`) once these commands [1] act; `before`: until then."""
    if own != 0.0:
        return 1 if own > 0.0 else -1
    return STANDING if other != 0.0 else before


def directed(wheels: WheelPair, command: CommandTrack) -> WheelPair:
    """Return the wheels with counts signed by what moved them; a wheel that never counts forward while it rolls out
    backwards stays as it is.
    """
    left = _Counts(wheels.time, wheels.left, command.time, command.left, command.right)
    right = _Counts(wheels.time, wheels.right, command.time, command.right, command.left)
    return replace(wheels, left=left.directed(), right=right.directed())


@dataclass(frozen=True, eq=False)
class _Counts:
    """One wheel's angle [rad] at `time` [s], with its own and the other wheel's commands [1] at `sent` [s]."""

    time: FloatArray
    angle: FloatArray
    sent: FloatArray
    own: FloatArray
    other: FloatArray

    @property
    def ends(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """How many commands had been sent at the begin and at the end of each interval."""
        counted = np.searchsorted(self.sent, self.time, side="right")
        return counted[:-1], counted[1:]

    @property
    def signs(self) -> NDArray[np.int_]:
        """The driver's sign before the first command and after each one."""
        return np.concatenate([[1], np.where(self.own < 0.0, -1, 1)])

    @property
    def mixed(self) -> NDArray[np.bool_]:
        """The intervals in which the driver's sign changed: counts of both signs have cancelled."""
        changes = np.concatenate([[0], np.cumsum(np.diff(self.signs) != 0)])
        first, last = self.ends
        return np.asarray(changes[first] != changes[last])

    @property
    def directions(self) -> NDArray[np.int_]:
        """Which way the wheel goes before the first command and after each one."""
        found = [1]
        for own, other in zip(self.own.tolist(), self.other.tolist(), strict=True):
            found.append(next_direction(found[-1], own, other))
        return np.array(found)

    def directed(self) -> FloatArray:
        """Return the angle, signed anew; mixed intervals go on with the speed of those beside them."""
        first, last = self.ends
        directions, steps, mixed = self.directions, np.diff(self.angle), self.mixed
        rolls_out = ~mixed & (directions[first] < 0) & (self.signs[first] > 0)
        if steps[rolls_out].sum() <= 0.0:
            return self.angle
        size = np.abs(steps)
        lasts, rows, known = np.diff(self.time), np.flatnonzero(mixed), np.flatnonzero(~mixed)
        size[rows] = lasts[rows] * np.interp(rows, known, size[known] / lasts[known])
        way = np.where(directions[first] != STANDING, directions[first], directions[last])
        return np.asarray(self.angle[0] + np.concatenate([[0.0], np.cumsum(size * way)]))
