"""What the wheels did, from whichever channel tells it: one function of time for angles, rates and rim
speeds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from fsm_calib.errors import DataError
from fsm_calib.recording.channels import WheelPair
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import travel
from fsm_calib.types import FloatArray

TYPICAL_RADIUS = 0.03  # m, for scaling only, where the manifest names none (Duckiebot 0.0318, Khepera 0.0205)
TYPICAL_TICK = 0.0005  # m per tick, for scaling only (Duckiebot 0.0015, LEGO NXT 0.00035)
TYPICAL_AXLE = 0.15  # m, for scaling only


@dataclass(frozen=True, eq=False)
class Wheels:
    """Travel of the wheels: cumulative `left`, `right` (n,) at `time` [s], in `unit` rad, tick or m.

    `name`, `scale_unit`: what the scale of this unit is called (``wheel_radius``, ``metres_per_tick``,
    ``wheel_gain``) and its unit; `nominal`: the scale that the manifest states, `size`: a typical one.
    """

    time: FloatArray
    left: FloatArray
    right: FloatArray
    unit: str
    name: str
    scale_unit: str
    nominal: float | None
    size: float

    def between(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the travel of both wheels over each interval of `times` (n + 1,), shape (n,);
        still outside.
        """
        left = np.interp(times, self.time, self.left)
        right = np.interp(times, self.time, self.right)
        return np.diff(left), np.diff(right)

    @cached_property
    def _curve(self) -> PchipInterpolator:
        time, rows = np.unique(self.time, return_index=True)
        return PchipInterpolator(time, np.stack([self.left[rows], self.right[rows]], axis=1))

    def along(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the travel of both wheels over each interval of `times` (n + 1,) and how much faster they are
        at its end than at its start, in travel per duration of the interval; shape (n, 2), left then right.

        Between stamps the travel is a monotone cubic (Fritsch, Carlson 1980, DOI 10.1137/0717021), which never
        leaves the range of two neighbouring stamps; a straight line there would cut every change of speed short,
        and a path dead reckoned along it comes out too long by (h omega)^2 / 12 in curves. Still outside.
        """
        inside = np.clip(times, self.time[0], self.time[-1])
        travel, speed = self._curve(inside), self._curve(inside, 1)
        speed[times != inside] = 0.0
        return np.diff(travel, axis=0), np.diff(speed, axis=0) * np.diff(times)[:, None]


def wheels_of(recording: Recording) -> Wheels:
    """Return the travel of the wheels, from angles if they were recorded, else rates, else rim speeds."""
    facts = recording.robot
    if recording.wheel_angle is not None:
        track = recording.wheel_angle
        if track.unit == "tick":
            nominal = facts.metres_per_tick
            return _wheels(
                track, track.left, track.right, "tick", "metres_per_tick", "m", nominal, TYPICAL_TICK
            )
        return _wheels(
            track, track.left, track.right, "rad", "wheel_radius", "m", facts.wheel_radius, TYPICAL_RADIUS
        )
    if recording.wheel_rate is not None:
        track = recording.wheel_rate
        time, left, right = travel(track)
        return Wheels(
            time,
            left,
            right,
            "rad",
            "wheel_radius",
            "m",
            facts.wheel_radius,
            facts.wheel_radius or TYPICAL_RADIUS,
        )
    if recording.wheel_speed is not None:
        time, left, right = travel(recording.wheel_speed)
        return Wheels(time, left, right, "m", "wheel_gain", "1", 1.0, 1.0)
    raise DataError("no wheel was measured", cure="Record wheel_angle, wheel_rate or wheel_speed.")


def _wheels(
    track: WheelPair, left: FloatArray, right: FloatArray, unit: str, name: str, scale_unit: str,
    nominal: float | None, typical: float,
) -> Wheels:  # fmt: skip
    return Wheels(
        track.time, left - left[0], right - right[0], unit, name, scale_unit, nominal, nominal or typical
    )
