"""What identified wheels mean for driving straight: where the robot pulls, and Duckietown's numbers that cure it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.identify.result import Identification
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.types import WheelCalibration

PATH = 1.0
"""Path after which a pull is told [m]."""
SURE = 2.0
"""A pull below this many standard deviations has no side."""
NEEDS = (
    "Record the wheels' own commands (after gain and trim, as wheels_cmd) and poses, on arcs to both sides."
)


@dataclass(frozen=True, slots=True)
class Pull:
    """Where a robot ends after `PATH` of both wheels at one command: `sideways` [m], left positive, and its `sd`;
    `turned` [rad], which goes on growing where a tight arc leads back to the line.
    """

    sideways: float
    sd: float | None
    turned: float = 0.0

    @property
    def side(self) -> str:
        """``left`` or ``right``; empty where the deviation does not tell it."""
        if self.sideways == 0.0 or (self.sd is not None and abs(self.sideways) < SURE * self.sd):
            return ""
        return "left" if self.sideways > 0 else "right"

    @property
    def sentence(self) -> str:
        """The pull in words [cm]."""
        size = f"{100 * abs(self.sideways):.1f}" + ("" if self.sd is None else f" +- {100 * self.sd:.1f}")
        if not self.side:
            return f"drives straight as far as the recording tells ({size} cm after {PATH:g} m)"
        return f"pulls {size} cm to the {self.side} after {PATH:g} m"


def pull_of(found: Identification, recordings: Sequence[Recording] = ()) -> Pull | None:
    """Return where the robot pulls; None where the wheel ratio was not told.

    The path of constant wheel speeds is an arc of curvature c = 2 (1 - k) / (b (1 + k)) [1/m], which is
    (1 - cos(c s)) / c [m] to the left after s [m]; k is the wheel ratio (speed of the left wheel over the right one
    at one command [1]), b the axle length [m]: fitted, else stated by a recording, else Duckietown's. The deviation
    is that of k alone.
    """
    estimate = found.estimates.get("wheel_ratio")
    if estimate is None or estimate.value is None or estimate.value <= 0.0:
        return None
    axle, ratio = _axle(found, recordings), estimate.value
    turned, sideways = _turned(ratio, axle), _sideways(ratio, axle)
    if estimate.sd is None or not math.isfinite(estimate.sd):
        return Pull(sideways, None, turned)
    low, high = max(ratio - estimate.sd, 1e-6), ratio + estimate.sd
    farthest = max(abs(_sideways(k, axle) - sideways) for k in (low, high))
    return Pull(sideways, farthest, turned)


def _sideways(ratio: float, axle: float) -> float:
    angle = _turned(ratio, axle)
    return PATH * (angle / 2.0 if abs(angle) < 1e-6 else (1.0 - math.cos(angle)) / angle)


def _turned(ratio: float, axle: float) -> float:
    return PATH * 2.0 * (1.0 - ratio) / (axle * (1.0 + ratio))


def _axle(found: Identification, recordings: Sequence[Recording]) -> float:
    stated = (recording.robot.axle_length for recording in recordings)
    return next((a for a in (found.value("axle_length"), *stated) if a), WheelCalibration().axle_length)


def wheel_calibration(found: Identification, recordings: Sequence[Recording]) -> WheelCalibration:
    """Return gain, trim, baseline, k and radius with which Duckietown's driver makes this robot do as it is asked.

    The driver computes u_right = omega_right (gain + trim) / k and u_left = omega_left (gain - trim) / k. Rims that
    move at S u [m/s] do as asked, R omega, where gain + trim = k R / S_right and gain - trim = k R / S_left. R is the
    mean fitted radius, else the stated one, else Duckietown's; k the stated rate at command 1 [rad/s], else
    Duckietown's; for commands in rad/s k is 1.

    Raises
    ------
    DataError
        The recordings do not tell both gains (no wheel commands), or a wheel turns against its command.
    """
    usual = WheelCalibration()
    robot = recordings[0].robot
    radius = _radius(found, robot.wheel_radius) or usual.wheel_radius
    command = recordings[0].command
    rates = command is not None and command.unit == "rad/s"
    constant = 1.0 if rates else robot.max_wheel_rate or usual.motor_constant
    left, right = (_speed(found, side, rates, robot.wheel_radius) for side in ("left", "right"))
    if command is None or left is None or right is None:
        raise DataError("the recordings do not tell gain and trim of the wheels", cure=NEEDS)
    if left <= 0.0 or right <= 0.0:
        cure = "Correct the wiring or the columns' signs first: trim cannot turn a wheel round."
        raise DataError("a wheel turns against its command", cure=cure)
    return WheelCalibration(
        wheel_ratio=left / right,
        gain=constant * radius * (1.0 / right + 1.0 / left) / 2.0,
        axle_length=_axle(found, recordings),
        wheel_radius=radius,
        motor_constant=constant,
        limit=max(usual.limit, robot.max_wheel_rate or 0.0) if rates else usual.limit,
    )


def _speed(found: Identification, side: str, rates: bool, stated_radius: float | None) -> float | None:
    """Return the rim's speed for command 1 [m/s], or for 1 rad/s of command [m/rad]; None where it is not told."""
    if not rates:
        return found.value(f"speed_at_full_{side}")
    gain = found.estimates.get(f"wheel_gain_{side}")
    if gain is None or gain.value is None:
        return None
    if gain.unit == "m":
        return gain.value
    radius = _radius(found, stated_radius)
    return None if radius is None else gain.value * radius


def _radius(found: Identification, stated: float | None) -> float | None:
    """Return the mean of the fitted wheel radii [m], else the stated one."""
    left, right = found.value("wheel_radius_left"), found.value("wheel_radius_right")
    return stated if left is None or right is None else (abs(left) + abs(right)) / 2.0


def straight_sentence(found: Identification, recordings: Sequence[Recording]) -> str:
    """Return where the robot pulls and the trim that cures it; empty where the recordings do not tell it."""
    pull = pull_of(found, recordings)
    if pull is None:
        return ""
    try:
        wheels = wheel_calibration(found, recordings)
    except DataError:
        return pull.sentence
    if not pull.side:
        return pull.sentence
    return f"{pull.sentence}; set trim to {wheels.trim:.3f} (at gain {wheels.gain:.3f})"
