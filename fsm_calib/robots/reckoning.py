"""Dead reckoning of a differential drive, from commands or from wheel encoders.

Per step with ways s_l, s_r [m] of the wheels: the robot moves by (s_l + s_r) / 2 along its mean heading and turns by
(s_r - s_l) / L. From commands, a wheel's rate is the motor constant times the command (Duckietown's model): good to
some 10 %, and blind to a push or a stalled wheel; from encoders, to some 2 %. Duckietown's encoders do not know which
way a wheel turns: see `recording.undirected`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from fsm_calib.recording.undirected import next_direction
from fsm_calib.types import FloatArray, Pose2, WheelCalibration, WheelCommand

LONGEST_STEP = 0.5
"""A command counts for at most this long without another [s]: the guard repeats them."""


@dataclass
class Reckoning:
    """The path of `base`, counted from `start`.

    Parameters
    ----------
    start : Pose2
        Where the robot begins.
    wheels : WheelCalibration
        Axle length, wheel radius and motor constant.
    """

    start: Pose2 = field(default_factory=Pose2)
    wheels: WheelCalibration = field(default_factory=WheelCalibration)
    pose: Pose2 = field(init=False)
    _rows: list[tuple[float, float, float, float]] = field(init=False, default_factory=list)
    _time: float | None = field(init=False, default=None)
    _command: WheelCommand = field(init=False, default=WheelCommand())
    _angles: dict[str, float] = field(init=False, default_factory=dict)
    _ways: tuple[int, int] | None = field(init=False, default=None)
    has_encoders: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        """Begin at the start."""
        self.pose = self.start

    def command(self, command: WheelCommand, now: float) -> None:
        """Note the command applied at `now` [s], and move by the one before."""
        if self._time is not None and not self.has_encoders:
            seconds = min(now - self._time, LONGEST_STEP)
            metres = self.wheels.motor_constant * self.wheels.wheel_radius * seconds
            self._move(self._command.left * metres, self._command.right * metres, now)
        self._time, self._command = now, command
        left, right = self._ways or (1, 1)
        self._ways = (
            next_direction(left, command.left, command.right),
            next_direction(right, command.right, command.left),
        )

    def encoder(self, side: str, angle: float, now: float) -> None:
        """Note a wheel's angle [rad] at `now` [s]; `side` is "left" or "right"."""
        self.has_encoders = True
        before = self._angles.get(side, angle)
        self._angles[side] = angle
        turned = angle - before
        if self._ways is not None:
            turned = abs(turned) * self._ways[0 if side == "left" else 1]
        way = turned * self.wheels.wheel_radius
        if way != 0.0:
            self._move(way if side == "left" else 0.0, way if side == "right" else 0.0, now)

    def _move(self, left: float, right: float, now: float) -> None:
        """Move by the wheels' ways [m]."""
        turn = (right - left) / self.wheels.axle_length
        heading = self.pose.theta + 0.5 * turn
        way = 0.5 * (left + right)
        self.pose = Pose2(
            self.pose.x + way * math.cos(heading),
            self.pose.y + way * math.sin(heading),
            self.pose.theta + turn,
        )
        self._rows.append((now, self.pose.x, self.pose.y, self.pose.theta))

    def track(self) -> FloatArray:
        """Return the path, shape (n, 4): time [s], x, y [m], theta [rad]."""
        first = (0.0, self.start.x, self.start.y, self.start.theta)
        return np.array([first, *self._rows])
