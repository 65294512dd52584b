"""What one simulated drive is made of: a robot, and hooks through which effects act on it."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.rapier_robots.plant import Control, Plant, Robot, Sensing

Array = np.ndarray


class State:
    """What hooks see and change within one step.

    t [s]; x, y [m], yaw [rad] of the axle's middle, c and s its cosine and sine; speed [m/s]; turn [rad/s]; rate
    [rad/s] and angle [rad] of the wheels; load : current over stall current; duty; volts : supply, 1 when fresh; fx, fy
    [N] and tz [Nm] : forces on the body; hold [Nm] : more dry friction of the wheels; grip : factor of the tyres'
    friction; ball : more friction of a ball caster; touched : whether an effect of a place or moment acts; creep :
    sideways speed of the tyres [m/s].
    """

    __slots__ = (
        "angle",
        "ball",
        "c",
        "creep",
        "duty",
        "fx",
        "fy",
        "grip",
        "hold",
        "load",
        "rate",
        "s",
        "speed",
        "t",
        "touched",
        "turn",
        "tz",
        "volts",
        "x",
        "y",
        "yaw",
    )

    def __init__(self) -> None:
        self.t = self.x = self.y = self.yaw = self.s = self.speed = self.turn = 0.0
        self.fx = self.fy = self.tz = self.creep = self.ball = 0.0
        self.c = self.volts = 1.0
        self.rate, self.angle, self.load = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
        self.duty, self.hold, self.grip = [0.0, 0.0], [0.0, 0.0], [1.0, 1.0]
        self.touched = False

    def wheel(self, k: int, axle: float) -> tuple[float, float]:
        """Return where a wheel stands [m]."""
        side = 0.5 * axle if k == 0 else -0.5 * axle
        return self.x - self.s * side, self.y + self.c * side


CommandHook = Callable[[State, float, float], tuple[float, float]]
SupplyHook = Callable[[State, float], float]
TorqueHook = Callable[[State, int, float, float], float]
FloorHook = Callable[[State], None]
Poses = tuple[Array, Array, Array]


@dataclass
class Setup:
    """A robot with hooks. Each list holds makers, called with the run's number for a fresh hook with its own memory.

    commands : (state, left, right) -> commands that act; supplies : (state, volts) -> volts; torques : (state, wheel,
    duty, torque) -> torque; floors : set forces, grip, friction; rims : (state, wheel) -> rim's shift in the wheel's
    frame; clocks : stamp -> true time; filters : (time, poses) -> poses; tags : true time -> tag's shift;
    markers : poses -> poses and whether they were changed.
    """

    robot: Robot
    plant: Plant
    control: Control | None
    sensing: Sensing
    commands: list[Callable[[int], CommandHook]] = field(default_factory=list)
    supplies: list[Callable[[int], SupplyHook]] = field(default_factory=list)
    torques: list[Callable[[int], TorqueHook]] = field(default_factory=list)
    floors: list[Callable[[int], FloorHook]] = field(default_factory=list)
    rims: list[Callable[[int], Callable[[float, int], tuple[float, float]]]] = field(default_factory=list)
    creeps: list[Callable[[int], Callable[[State, float], float]]] = field(default_factory=list)
    clocks: list[Callable[[int], Callable[[Array], Array]]] = field(default_factory=list)
    filters: list[Callable[[int], Callable[[Array, Poses], Poses]]] = field(default_factory=list)
    tags: list[Callable[[int], Callable[[Array], Poses]]] = field(default_factory=list)
    markers: list[Callable[[int], Callable[[Poses], tuple[Poses, Array]]]] = field(default_factory=list)

    def copy(self) -> Setup:
        """Return a copy whose lists are its own."""
        other = copy.copy(self)
        for name, value in vars(self).items():
            if isinstance(value, list):
                setattr(other, name, list(value))
        return other


def setup_of(robot: Robot) -> Setup:
    """Return a robot without any effect."""
    return Setup(robot, robot.plant, robot.control, robot.sensing)
