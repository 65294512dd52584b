"""What a robot is made of, as numbers, and a robot with the changes that laws make to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.robot_sets.driving import Array, Poses, Sensing

if TYPE_CHECKING:
    from benchmarks.box2d_robots.machine import Machine, Now

Pair = tuple[float, float]
Hook = Callable[["Now"], None]
Factory = Callable[["Machine", int], Hook]
Clock = Callable[[Array], Array]
Smooth = Callable[[Array, Poses], Poses]
Tag = Callable[[Array], tuple[Any, Any, Any]]
Marker = Callable[[Poses], tuple[Poses, NDArray[np.bool_]]]


@dataclass(frozen=True)
class Third:
    """What a robot stands on besides its wheels.

    kind : ball, skid, glides (two of them) or fork (a swivelling wheel); x, half_y [m] : where, from the
    axle's middle; ahead [m] : a glide just above the floor that takes load when the mass moves ahead; slide
    : friction of what slides; roll : rolling resistance of a fork's wheel; trail [m]; swivel [m] : torque
    of a fork's pivot over its load.
    """

    kind: str
    x: float
    half_y: float
    ahead: float
    slide: float
    roll: float
    trail: float
    swivel: float


@dataclass(frozen=True)
class Plant:
    """Body, wheels and motors; pairs are left and right; torques and rates at the wheel, behind the gear."""

    mass: float
    inertia: float  # about the axle's middle [kg m2]
    centre: tuple[float, float, float]  # of mass: ahead, to the left, above the floor [m]
    axle: float
    radius: Pair
    wheel_inertia: float
    rotor_inertia: float
    volts: float
    torque_const: Pair  # [N m / A]
    emf_const: Pair  # [V s]
    winding: Pair  # [ohm]
    electric_lag: float  # inductance over resistance [s]
    efficiency: float  # of the gear
    dry: Pair  # [N m]
    viscous: Pair  # [N m s]
    rolling: float  # moment over load and radius
    grip: float
    stiff: Pair  # slip stiffness along and across, in loads
    relax: float  # relaxation length [m]
    third: Third

    def stall(self) -> float:
        """Return the mean stall torque of a wheel [N m]."""
        each = [k * self.volts / r * self.efficiency for k, r in zip(self.torque_const, self.winding)]
        return 0.5 * sum(each)

    def free(self) -> float:
        """Return the mean free rate of a wheel [rad/s]."""
        return self.volts / (0.5 * sum(self.emf_const))


@dataclass(frozen=True)
class Control:
    """A wheel-speed controller: full rate [rad/s], feed-forward, gain, integral [1/s], ramp [1/s], period
    [s].
    """

    full: float
    feed: float
    gain: float
    integral: float
    ramp: float
    period: float


@dataclass(frozen=True)
class Robot:
    """A robot; area [m] is as far as it is driven from the middle, tick [s] the time between commands."""

    kind: str
    plant: Plant
    sensing: Sensing
    control: Control | None
    area: float
    tick: float
    sheet: dict[str, float]
    reverse: float  # by what share the motors are weaker backwards

    def changed(self, **what: Any) -> Robot:
        """Return the robot with another plant."""
        return replace(self, plant=replace(self.plant, **what))


@dataclass
class Setup:
    """A robot and what acts on it, in the order of a step: command, drive, supply, motor, floor, body; then
    cameras.
    """

    robot: Robot
    plant: Plant
    sensing: Sensing
    control: Control | None
    command: list[Factory] = field(default_factory=list)
    drive: list[Factory] = field(default_factory=list)
    supply: list[Factory] = field(default_factory=list)
    motor: list[Factory] = field(default_factory=list)
    floor: list[Factory] = field(default_factory=list)
    body: list[Factory] = field(default_factory=list)
    clocks: list[Callable[[int], Clock]] = field(default_factory=list)
    filters: list[Callable[[int], Smooth]] = field(default_factory=list)
    tags: list[Callable[[int], Tag]] = field(default_factory=list)
    markers: list[Callable[[int], Marker]] = field(default_factory=list)


def setup_of(robot: Robot) -> Setup:
    """Return a robot as it is, with nothing hidden."""
    return Setup(robot, robot.plant, robot.sensing, robot.control)
