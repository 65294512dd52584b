"""The simulated robot behind the port, and the world around it.

Time runs in whole steps of a fixed length. Everything random is drawn from generators made of the seed and of
what it belongs to, a frame's number or a step's block, never from a running one: rendering fewer frames
changes nothing that comes later, and a logged list of commands, driven again without rendering, gives the
same state bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from fsm_calib.errors import InputError
from fsm_calib.types import STOP, Frame, WheelCommand
from fsm_calib.world2d.body import largest_stable_step
from fsm_calib.world2d.faults import DeadWheel, Fault
from fsm_calib.world2d.motion import Motion
from fsm_calib.world2d.scene import check_range
from fsm_calib.world2d.shutter import Shutter
from fsm_calib.world2d.spec import Wear, WorldSettings, WorldSpec
from fsm_calib.world2d.truth import Truth

__all__ = ["SimulatedRobot", "Wear", "World", "WorldSettings", "WorldSpec", "make_world"]

LONGEST_WAIT = 3600.0
"""Longest single wait [s]."""


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

    def run(self, command: WheelCommand, duration: float) -> None:
        """Apply `command` for `duration` [s], then zero; see `command` and `wait`."""
        self.command(command)
        self.wait(duration)
        self.command(STOP)

    def capture(self) -> Frame | None:
        """Expose one frame that ends now and return it after the camera's delay; None when it delivers nothing."""
        frame = self.__shutter.capture(self.__motion)
        if self.__settings.camera_delay > 0.0:
            self.wait(self.__settings.camera_delay)
        return frame

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
        if not self.__dead:
            self.__motion.run(self.__command.left, self.__command.right, ticks)
            return
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
