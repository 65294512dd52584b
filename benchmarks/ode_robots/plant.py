"""What a robot is made of: numbers only."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.robot_sets.driving import Sensing

Pair = tuple[float, float]


@dataclass(frozen=True)
class Foot:
    """A third point of support: a skid, a trailing fork or a ball, at x, y from the axle's middle [m].

    friction : of a skid, of a fork's wheel (share of load) or of a ball in its socket; gap [m] above a level
    floor; trail [m] of a fork; swivel : friction of a fork's upright bearing as a share of load times trail.
    """

    x: float
    y: float
    friction: float
    gap: float = 0.0
    kind: str = "skid"
    trail: float = 0.0
    swivel: float = 0.0


@dataclass(frozen=True)
class Plant:
    """The robot itself, in SI units; pairs are left and right.

    centre : place of the mass's centre from the middle of the axle (x ahead, y left, z up); gyration [m] about
    the vertical; stall [N m] and free [rad/s] of the line T = stall (V u - w / free) at the wheel; rotor
    [kg m2] at the wheel; dry [N m]; rolling : share of load; creep : tyre force per load and slip, along and
    across; backwards : share by which a reversed motor is weaker.
    """

    mass: float
    centre: tuple[float, float, float]
    gyration: float
    axle: float
    radius: Pair
    wheel_mass: float
    stall: Pair
    free: Pair
    rotor: float
    dry: Pair
    rolling: float
    friction: float
    creep: Pair
    backwards: float
    feet: tuple[Foot, ...]


@dataclass(frozen=True)
class Control:
    """A controller of wheel speed: duty = ahead + proportional + integral, each in shares of full speed."""

    full: float
    gain: float
    integral: float
    most_integral: float


@dataclass(frozen=True)
class Robot:
    """A robot with its controller, cameras and data sheet; full [m/s], area [m], tick [s] of its commands."""

    kind: str
    plant: Plant
    control: Control | None
    sensing: Sensing
    full: float
    area: float
    tick: float
    sheet: dict[str, float]
