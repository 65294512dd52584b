"""The specification of a simulated run: the robot, the area, the sensor, the steps, the faults, the wear and
the seed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fsm_calib.types import Pose2
from fsm_calib.world2d.faults import Fault
from fsm_calib.world2d.fleet import RobotSpec, nominal_robot
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.scene import SceneSpec, check_range
from fsm_calib.world2d.sensor import SensorSettings

LONGEST_STEP = 0.002
"""Longest step of a world [s]: contacts of SI size need it."""


@dataclass(frozen=True, slots=True)
class Wear:
    """A wheel ratio that drifts while driving: relative change per metre [1/m], up to `limit` [1] in either
    direction.

    Gearbox and coating wear (paper section 5.2), made fast enough to be seen in one run.

    Parameters
    ----------
    per_metre : float
        Relative change of the wheel ratio for each metre driven [1/m].
    limit : float
        Largest relative change in either direction [1].
    """

    per_metre: float = 0.0
    limit: float = 0.04

    def factor(self, odometer: float) -> float:
        """Return what the true ratio is multiplied by after `odometer` [m] of driving."""
        return 1.0 + float(np.clip(self.per_metre * odometer, -self.limit, self.limit))


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """How the world is simulated.

    Parameters
    ----------
    step : float
        Longest step of the simulation [s].
    command_limit : float
        Largest command that the driver lets through [1] (Duckietown's limit).
    drive_noise : float
        Relative standard deviation of each wheel's answer [1]: small unevenness of floor and gears (assumed).
    noise_period : float
        How often it is drawn anew [s]; interpolated between.
    trace_period : float
        Spacing of the true path that is kept [s].
    camera_delay : float
        From the exposure of a frame until it is at hand [s]; the wheels keep their command meanwhile.
    """

    step: float = LONGEST_STEP
    command_limit: float = 1.0
    drive_noise: float = 0.01
    noise_period: float = 0.1
    trace_period: float = 0.02
    camera_delay: float = 0.0

    def __post_init__(self) -> None:
        """Refuse steps that are too long for contacts and settings without meaning."""
        check_range("step", self.step, 1e-5, LONGEST_STEP)
        check_range("command_limit", self.command_limit, 0.01, 1.0)
        check_range("drive_noise", self.drive_noise, 0.0, 0.5)
        check_range("noise_period", self.noise_period, self.step, 10.0)
        check_range("camera_delay", self.camera_delay, 0.0, 2.0)
        check_range("trace_period", self.trace_period, self.step, 10.0)


@dataclass(frozen=True, eq=False)
class WorldSpec:
    """A robot in an area, with what may go wrong; `start` is the pose of `base` in `world` at time 0."""

    robot: RobotSpec = field(default_factory=nominal_robot)
    scene: SceneSpec = field(default_factory=calibration_area)
    start: Pose2 = field(default_factory=Pose2)
    sensor: SensorSettings | None = None
    settings: WorldSettings = field(default_factory=WorldSettings)
    faults: tuple[Fault, ...] = ()
    wear: Wear = field(default_factory=Wear)
    seed: int = 0

    @property
    def optics(self) -> SensorSettings:
        """The sensor's settings; by default with the robot's own focus."""
        return self.sensor or SensorSettings(defocus=self.robot.defocus)
