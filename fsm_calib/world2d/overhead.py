"""A tracker over the area: a camera at the ceiling that sees the robot's tag from time to time, with noise.

What it reports is what the robot's true path, the place of the tag on the robot and its own errors make of it
(effects of the sensor: `observation`). Noise belongs to the number of the frame, so that a run that is taken up again
sees the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.observation import observe, robot_time, smoothed
from fsm_calib.world2d.robot import World
from fsm_calib.world2d.scene import check_range

NOISE_STREAM = 11
"""Which random stream of the seed the tracker's noise is drawn from."""
REMEMBERED = 10.0
"""Seconds of the path before a frame that a tracker's filter may still hold: 16 of its longest time constants."""


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """An overhead tracker.

    Parameters
    ----------
    rate : float
        Frames a second [Hz].
    position_noise, heading_noise : float
        Standard deviations of one pose [m, rad]; the defaults are those of a ceiling camera over a 2 m area.
    missed : float
        Share of frames in which the tag is not found [1].
    """

    rate: float = 15.0
    position_noise: float = 0.002
    heading_noise: float = 0.006
    missed: float = 0.02

    def __post_init__(self) -> None:
        """Refuse settings without meaning."""
        check_range("rate", self.rate, 1.0, 120.0)
        check_range("position_noise", self.position_noise, 0.0, 0.5)
        check_range("heading_noise", self.heading_noise, 0.0, 0.5)
        check_range("missed", self.missed, 0.0, 0.95)


class OverheadTracker:
    """Reports where a simulated robot was seen (`ports.Tracker`)."""

    def __init__(self, world: World, settings: TrackerSettings) -> None:
        self.__world, self.__settings = world, settings
        self.__next = 0

    def poses(self) -> list[tuple[float, float, float, float]]:
        """Return what was seen since the last call: time [s], x, y [m], theta [rad, not wrapped]."""
        truth, settings = self.__world.truth, self.__settings
        trace, parameters = truth.trace, truth.parameters
        if len(trace) < 2:
            return []
        numbers = np.arange(self.__next, int((trace[-1, 0]) * settings.rate) + 1)
        stamps = numbers / settings.rate
        meant = robot_time(parameters, stamps)
        ready = (meant <= trace[-1, 0]) & (stamps <= trace[-1, 0])
        numbers, stamps, meant = numbers[ready], stamps[ready], meant[ready]
        if not len(numbers):
            return []
        self.__next = int(numbers[-1]) + 1
        known = trace[max(int(np.searchsorted(trace[:, 0], meant[0] - REMEMBERED)) - 1, 0) :]
        filtered = smoothed(parameters, known[:, 0], known[:, 1:4])
        path = np.column_stack([np.interp(meant, known[:, 0], filtered[:, i]) for i in range(3)])
        seen = observe(parameters, meant, path)
        return [
            (float(stamp), *map(float, pose))  # type: ignore[misc]
            for stamp, pose in zip(stamps, self.__blurred(numbers, seen), strict=True)
            if np.isfinite(pose[0])
        ]

    def skip(self, until: float) -> None:
        """Forget frames before `until` [s], for a run that is taken up again."""
        self.__next = int(np.ceil(until * self.__settings.rate))

    def __blurred(self, numbers: np.ndarray, poses: FloatArray) -> FloatArray:
        """Return poses (n, 3) with each frame's own noise, NaN where the tag was not found."""
        settings, blurred = self.__settings, poses.copy()
        spread = (settings.position_noise, settings.position_noise, settings.heading_noise)
        for row, number in enumerate(numbers):
            rng = np.random.default_rng([self.__world.spec.seed, NOISE_STREAM, int(number)])
            blurred[row] += rng.standard_normal(3) * spread
            if rng.random() < settings.missed:
                blurred[row] = np.nan
        return blurred
