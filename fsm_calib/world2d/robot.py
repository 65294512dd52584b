"""The simulated robot behind the port, and the world around it.

Time runs in whole steps of a fixed length. Everything random is drawn from generators made of the seed and of
what it belongs to, a frame's number or a step's block, never from a running one: rendering fewer frames
changes nothing that comes later, and a logged list of commands, driven again without rendering, gives the
same state bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.types import STOP, Frame, Pose2, WheelCommand
from fsm_calib.world2d.body import largest_stable_step
from fsm_calib.world2d.faults import DeadWheel, Fault
from fsm_calib.world2d.fleet import RobotSpec, nominal_robot
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.scene import SceneSpec, check_range
from fsm_calib.world2d.sensor import SensorSettings
from fsm_calib.world2d.shutter import Shutter
from fsm_calib.world2d.truth import Motion, Truth

LONGEST_STEP = 0.002
"""Longest step of a world [s]: contacts of SI size need it."""
LONGEST_WAIT = 3600.0
"""Longest single wait [s]."""
_NOISE_STREAM = 1


@dataclass(frozen=True, slots=True)
class Wear:
    """A wheel ratio that drifts while driving: relative change per metre [1/m], up to `limit` [1] in either
    direction.

    Gearbox and coating wear (paper section 5.2), made fast enough to be seen in one run.
    """

    per_metre: float = 0.0
    limit: float = 0.04

    def factor(self, odometer: float) -> float:
        """Return what the true ratio is multiplied by after `odometer` [m] of driving."""
        return 1.0 + float(np.clip(self.per_metre * odometer, -self.limit, self.limit))


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """How the world is simulated.

    step [s]; command_limit : largest command that the driver lets through [1] (Duckietown's limit);
    drive_noise : relative standard deviation of each wheel's answer, drawn anew every `noise_period` [s] and
    interpolated between (assumed: small unevenness of floor and gears); trace_period : spacing of the true
    path that is kept [s].
    """

    step: float = LONGEST_STEP
    command_limit: float = 1.0
    drive_noise: float = 0.01
    noise_period: float = 0.1
    trace_period: float = 0.02

    def __post_init__(self) -> None:
        """Refuse steps that are too long for contacts and settings without meaning."""
        check_range("step", self.step, 1e-5, LONGEST_STEP)
        check_range("command_limit", self.command_limit, 0.01, 1.0)
        check_range("drive_noise", self.drive_noise, 0.0, 0.5)
        check_range("noise_period", self.noise_period, self.step, 10.0)
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


class SimulatedRobot:
    """A robot as the actions know it (`ports.Robot`): wheels, camera and clock, and no way to the truth."""

    def __init__(
        self, motion: Motion, shutter: Shutter, settings: WorldSettings, faults: tuple[Fault, ...]
    ) -> None:
        self.__motion, self.__shutter, self.__settings = motion, shutter, settings
        self.__dead = tuple(fault for fault in faults if isinstance(fault, DeadWheel))
        self.__command = STOP
        self.__log: list[tuple[float, WheelCommand]] = []

    @property
    def command_log(self) -> tuple[tuple[float, WheelCommand], ...]:
        """Every command with its time [s], in order."""
        return tuple(self.__log)

    @property
    def frames_taken(self) -> int:
        """How many frames were asked for."""
        return self.__shutter.count

    def command(self, command: WheelCommand) -> None:
        """Apply `command`, clipped to the driver's limit, until the next one.

        Raises
        ------
        InputError
            For a command that is not finite.
        """
        if not (math.isfinite(command.left) and math.isfinite(command.right)):
            raise InputError(f"wheel command ({command.left}, {command.right}) is not finite", where="robot")
        limit = self.__settings.command_limit
        self.__command = WheelCommand(
            *(max(-limit, min(limit, side)) for side in (command.left, command.right))
        )
        self.__log.append((self.now(), self.__command))

    def capture(self) -> Frame | None:
        """Expose one frame that ends now; None when the camera delivers nothing."""
        return self.__shutter.capture(self.__motion)

    def now(self) -> float:
        """Return the time since the start [s]."""
        return self.__motion.time

    def wait(self, duration: float) -> None:
        """Let `duration` [s] pass, rounded to whole steps.

        Raises
        ------
        InputError
            For a duration that is negative, not finite or longer than an hour.
        """
        check_range("wait", duration, 0.0, LONGEST_WAIT)
        self.__run(round(duration / self.__settings.step))

    def __run(self, ticks: int) -> None:
        for _ in range(ticks):
            left, right = self.__command.left, self.__command.right
            for fault in self.__dead:
                if self.__motion.time >= fault.at:
                    left, right = (0.0, right) if fault.side == "left" else (left, 0.0)
            self.__motion.step(left, right)

    def fast_forward(self, log: Iterable[tuple[float, WheelCommand]], until: float, frames: int = 0) -> None:
        """Drive a logged list of commands again without rendering, up to `until` [s].

        Parameters
        ----------
        log : iterable of (time [s], command)
            As `command_log` of the run that is taken up again; times must not decrease.
        until : float
            Where to stop [s]; not before the last command.
        frames : int
            How many frames the run had taken, so that later frames get their own noise.

        Raises
        ------
        InputError
            When the robot's time is already past a logged time.
        """
        for time, command in log:
            self.__run_to(time)
            self.command(command)
        self.__run_to(until)
        self.__shutter.count = frames

    def __run_to(self, time: float) -> None:
        check_range("time", time, 0.0, math.inf if math.isfinite(time) else 0.0)
        ticks = round(time / self.__settings.step) - self.__motion.ticks
        if ticks < 0:
            raise InputError(
                f"a logged time of {time:g} s is past", where="fast_forward", cure="Start a fresh world."
            )
        self.__run(ticks)


@dataclass(frozen=True, eq=False)
class World:
    """A simulated run: `robot` for the actions, `truth` for scoring only."""

    spec: WorldSpec
    robot: SimulatedRobot
    truth: Truth


def make_world(spec: WorldSpec) -> World:
    """Build the world of `spec`; the same specification gives the same run, bit for bit.

    Raises
    ------
    InputError
        When the step is longer than the physics allows, or a part of the specification has no meaning.
    """
    parameters = spec.robot.parameters()
    longest = largest_stable_step(parameters)
    if spec.settings.step > longest:
        raise InputError(
            f"the step of {spec.settings.step:g} s is longer than the physics allows ({longest:.2g} s)",
            where="settings.step",
            cure="Shorten the step.",
        )
    motion = Motion(spec, parameters)
    shutter = Shutter(spec)
    robot = SimulatedRobot(motion, shutter, spec.settings, spec.faults)
    return World(spec, robot, Truth(spec, motion, shutter))
