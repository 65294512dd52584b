"""Where a robot may drive: a rectangle with a margin, less what stands in it, where its own camera sees enough tags."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.design.sight import Sight
from fsm_calib.types import FloatArray, Pose2


@dataclass(frozen=True, slots=True)
class Disc:
    """Something that must not be touched: centre x, y and radius [m]."""

    x: float
    y: float
    radius: float


@dataclass(frozen=True, slots=True)
class Area:
    """A rectangle [m] in the world frame, the distance that the axle's centre keeps from its edges, and obstacles.

    margin [m] : half a robot (0.10 m) and what random forces and a wrong heading add over a drive. sight : where poses
    come from the robot's own camera; None where something beside the robot sees it everywhere.
    """

    x_low: float = -1.0
    x_high: float = 1.0
    y_low: float = -1.0
    y_high: float = 1.0
    margin: float = 0.20
    obstacles: tuple[Disc, ...] = ()
    sight: Sight | None = None

    @property
    def centre(self) -> Pose2:
        """The middle, heading along x."""
        return Pose2(0.5 * (self.x_low + self.x_high), 0.5 * (self.y_low + self.y_high), 0.0)

    @property
    def size(self) -> tuple[float, float]:
        """Width and depth [m]."""
        return self.x_high - self.x_low, self.y_high - self.y_low

    def clearance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return how far each point keeps from edges and obstacles [m], beyond the margin; negative is too near."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        free = np.minimum(
            np.minimum(x - self.x_low, self.x_high - x), np.minimum(y - self.y_low, self.y_high - y)
        )
        for disc in self.obstacles:
            free = np.minimum(free, np.hypot(x - disc.x, y - disc.y) - disc.radius)
        return np.asarray(free - self.margin)

    def holds(self, x: FloatArray, y: FloatArray) -> bool:
        """Return whether every point keeps its distance."""
        return bool(np.all(self.clearance(x, y) >= 0.0))

    def allows(self, paths: FloatArray) -> bool:
        """Return whether every pose of `paths` (k, n, 3), x, y [m], theta [rad], every 0.05 s, is within the bounds."""
        if not self.holds(paths[:, :, 0], paths[:, :, 1]):
            return False
        return self.sight is None or self.sight.keeps(paths)
