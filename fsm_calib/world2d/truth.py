"""What truly is, for scoring and reports only. Nothing here is reachable through the port."""

from __future__ import annotations

import numpy as np

from fsm_calib.types import CameraModel, CameraMount, FloatArray, Pose2
from fsm_calib.world2d.motion import Motion
from fsm_calib.world2d.shutter import Shutter
from fsm_calib.world2d.spec import WorldSpec
from fsm_calib.world2d.surfaces import Marker, Scene


class Truth:
    """What really is, for scoring and reports."""

    def __init__(self, spec: WorldSpec, motion: Motion, shutter: Shutter) -> None:
        self._spec, self._motion, self._shutter = spec, motion, shutter

    @property
    def pose(self) -> Pose2:
        """Pose of `base` in `world` now; theta is not wrapped."""
        return self._motion.body.pose

    @property
    def twist(self) -> tuple[float, float, float]:
        """Forward and leftward speed [m/s] and yaw rate [rad/s] of `base` now."""
        return self._motion.body.twist

    @property
    def wheel_angles(self) -> tuple[float, float]:
        """How far the wheels have turned since the start, left and right [rad]: more than the way where they slip."""
        return self._motion.body.wheel_angles

    @property
    def camera(self) -> CameraModel:
        """The true lens."""
        return self._spec.robot.camera

    @property
    def mount(self) -> CameraMount:
        """Where the camera truly sits."""
        return self._spec.robot.mount

    @property
    def parameters(self) -> FloatArray:
        """The physics as it is now, worn as it is, shape (p,)."""
        return self._motion.worn_parameters()

    @property
    def wheel_ratio(self) -> float:
        """The true k now, worn as it is: right command over left command for driving straight."""
        return self._spec.robot.wheel_ratio * self._spec.wear.factor(self._motion.worn_at)

    @property
    def odometer(self) -> float:
        """Path of the axle's centre since the start [m]."""
        return self._motion.odometer

    @property
    def trace(self) -> FloatArray:
        """The path so far, shape (n, 4): time [s], x, y [m], theta [rad], not wrapped."""
        return np.array(self._motion.trace)

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self._shutter.scene_at(self._motion.time)

    @property
    def markers(self) -> tuple[Marker, ...]:
        """Where the floor markers truly lie."""
        return self.scene.markers

    @property
    def is_touching(self) -> bool:
        """Tell whether the robot touches something now."""
        touching: list[bool] = []
        self._motion.body.body.each_arbiter(lambda arbiter: touching.append(True))
        return bool(touching)
