"""A robot with the changes that laws make to it; every run builds its machine from one of these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.ode_robots.plant import Plant, Robot
from benchmarks.robot_sets.driving import Array, Poses, Sensing

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now

Hook = Callable[["Now"], None]
Factory = Callable[["Machine", int], Hook | None]
Clock = Callable[[Array], Array]
Smooth = Callable[[Array, Poses], Poses]
Tag = Callable[[Array], tuple[Any, Any, Any]]
Marker = Callable[[Poses], tuple[Poses, NDArray[np.bool_]]]


@dataclass
class Tyre:
    """The shape of a wheel's tread.

    tracks [m] : where it stands on the floor across its width; hub [m] : the tread's centre from the hinge, in
    the wheel's frame (x, z); shape : adds to the radius [m] by the angle [rad] of the lowest point in the wheel.
    """

    tracks: tuple[float, ...] = (0.0,)
    hub: tuple[float, float] = (0.0, 0.0)
    shape: Callable[[float], float] | None = None


@dataclass
class Play:
    """Backlash between rotor and wheel: half widths [rad] of left and right, softness of the stops."""

    half: tuple[float, float]
    erp: float
    cfm: float


@dataclass
class Setup:
    """A robot and what acts on it, in the order of a step: command, supply, motor, floor, body; then the cameras."""

    robot: Robot
    plant: Plant
    sensing: Sensing
    tyres: list[Tyre]
    play: Play | None = None
    command: list[Factory] = field(default_factory=list)
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
    return Setup(robot, robot.plant, robot.sensing, [Tyre(), Tyre()])
