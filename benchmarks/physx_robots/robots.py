"""The robots: what one is made of, and how one is drawn. SI units; x ahead, y left, from the axle's middle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks.physx_robots.kinds import KINDS, Kind

GRAVITY = 9.81
HARDEST_START = 5.0  # m/s2: stronger motors would spin their wheels
Rng = np.random.Generator


@dataclass(frozen=True)
class Motor:
    """A brushed DC motor with its gear, seen at the wheel.

    stall [N m] at full supply; free [rad/s] without load; rotor [kg m2]; coulomb [N m]; viscous [N m s]; the
    reverse numbers multiply stall, free and coulomb where the duty (or the turning) is backwards; breakaway:
    coulomb torque at rest over that in motion; brake: share of the torque that is left where it acts against
    the motion; play [rad] and mesh [N m/rad] of the gear.
    """

    stall: float
    free: float
    rotor: float
    coulomb: float
    viscous: float = 0.0
    reverse_stall: float = 1.0
    reverse_free: float = 1.0
    reverse_coulomb: float = 1.0
    breakaway: float = 1.0
    brake: float = 1.0
    play: float = 0.0
    mesh: float = 0.0


@dataclass(frozen=True)
class Wheel:
    """A driven wheel. radius [m], mass [kg]; half_width [m] between two lines of contact (0 = one); hub_offset
    [m] from the rim's centre in the direction `phase` [rad]; oval: share by which the radius changes twice in a
    turn.
    """

    radius: float
    mass: float
    half_width: float = 0.0
    hub_offset: float = 0.0
    phase: float = 0.0
    oval: float = 0.0


@dataclass(frozen=True)
class Caster:
    """A caster: `ball` or `skid` (a low-friction ball fixed to the body) or `swivel` (a fork with a wheel).

    x, radius, trail, skew [m] (of a fork's wheel, behind and beside the swivel); friction: coefficient of ball
    or skid; swivel and axle [N m]: dry friction of a fork's two joints; lift [m]: clearance above the floor.
    """

    kind: str
    x: float
    radius: float
    friction: float = 0.05
    trail: float = 0.0
    skew: float = 0.0
    swivel: float = 0.0
    axle: float = 0.0
    lift: float = 0.0


@dataclass(frozen=True)
class Tyre:
    """The wheels' grip. grip and side_grip: friction coefficients. The rest is for brush tyres alone: stiffness
    and side_stiffness (force over load for a unit of slip), length [m] of relaxation, spin_arm [m] (moment
    against turning over load), spin_angle [rad] where that moment is full.
    """

    brush: bool
    grip: float
    side_grip: float
    stiffness: float = 15.0
    side_stiffness: float = 15.0
    length: float = 0.01
    spin_arm: float = 0.0
    spin_angle: float = 0.1


@dataclass(frozen=True)
class Controller:
    """A PI controller of wheel speed. period [s]; kp [duty per rad/s]; ki [duty per rad]; ticks per turn it sees."""

    period: float
    kp: float
    ki: float
    ticks: int


@dataclass(frozen=True)
class Sensing:
    """How the poses and encoders are taken.

    rate [Hz]; position_sd [m] an axis; heading_sd [rad]; tails and missing: shares; tag [m], tag_yaw [rad]; ticks per
    turn of the recorded encoders (0 = none).
    """

    rate: float
    position_sd: float
    heading_sd: float
    tails: float
    missing: float
    tag: tuple[float, float] = (0.0, 0.0)
    tag_yaw: float = 0.0
    ticks: int = 0


@dataclass(frozen=True)
class Robot:
    """A whole robot. mass [kg] and centre [m] (x, y, height over the axle) and inertia [kg m2] of the body
    without wheels; tilt: gravity's share along world x and y; bend: a mild curve of speed over command;
    rolling: resistance over load; nap_speed: share of the rolled way by which the floor carries a wheel along
    world (x, y).
    """

    kind: str
    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]
    axle: float
    full_rate: float
    wheels: tuple[Wheel, Wheel]
    motors: tuple[Motor, Motor]
    casters: tuple[Caster, ...]
    tyre: Tyre
    controller: Controller | None
    sensing: Sensing
    command_period: float
    reach: float
    lag: float
    rolling: float = 0.002
    bend: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    nap_speed: tuple[float, float] = (0.0, 0.0)
    facts: dict[str, float] = field(default_factory=dict)
    departures: dict[str, float] = field(default_factory=dict)

    @property
    def radius(self) -> float:
        """Mean wheel radius [m]."""
        return 0.5 * (self.wheels[0].radius + self.wheels[1].radius)

    @property
    def speed(self) -> float:
        """Speed [m/s] at command 1."""
        return self.full_rate * self.radius

    @property
    def total_mass(self) -> float:
        """Mass [kg] with the wheels."""
        return self.mass + self.wheels[0].mass + self.wheels[1].mass

    @property
    def loads(self) -> tuple[float, float]:
        """Static load [N] of the left and the right wheel; the caster that lies towards the mass carries its
        share.
        """
        weight, (x, y, _) = self.mass * GRAVITY, self.centre
        ends = [c.x for c in self.casters if c.x * x > 0]
        on_wheels = weight * (1.0 - (x / ends[0] if ends else 0.0))
        return tuple(  # type: ignore[return-value]
            max(0.5 * on_wheels + sign * weight * y / self.axle, 0.05 * weight) + wheel.mass * GRAVITY
            for sign, wheel in zip((1, -1), self.wheels)
        )


def change_motors(
    robot: Robot, change: Callable[[Motor], Motor], sides: tuple[float, float] = (1.0, 1.0)
) -> Robot:
    """Return the robot with the motors of some sides changed."""
    left, right = (change(motor) if side else motor for motor, side in zip(robot.motors, sides))
    return replace(robot, motors=(left, right))


def _casters(rng: Rng, kind: Kind, axle: float, radius: float) -> tuple[Caster, ...]:
    x = kind.caster_x * axle * rng.uniform(0.9, 1.1)
    if kind.caster == "swivel":
        small = radius * rng.uniform(0.4, 0.55)
        trail = small * float(rng.uniform(0.35, 0.7))
        skew = trail * float(rng.uniform(0.1, 0.25) * rng.choice([-1, 1]))
        return (Caster("swivel", x, small, trail=trail, skew=skew),)
    first = Caster("skid" if kind.caster == "skid" else "ball", x, 0.35 * radius)
    first = replace(
        first, friction=rng.uniform(0.08, 0.14) if kind.caster == "skid" else rng.uniform(0.015, 0.04)
    )
    return (
        (first, replace(first, x=-x, lift=rng.uniform(0.0005, 0.0015))) if kind.caster == "pair" else (first,)
    )


def _motors(rng: Rng, mass: float, radius: float, free: float, lag: float) -> tuple[Motor, Motor]:
    """Draw two alike motors such that the robot's first-order lag is `lag` [s]."""
    driven = 0.5 * mass * radius**2
    rotor = driven * rng.uniform(0.12, 0.4)
    stall = (driven + rotor) * free / lag
    motor = Motor(stall, free, rotor, stall * rng.uniform(0.002, 0.006))
    return motor, motor


def _controller(rng: Rng, motor: Motor, lag: float) -> Controller:
    period = float(rng.choice([0.01, 0.02]))
    ticks = int(rng.choice([800, 1200, 2048, 4096]))
    return Controller(
        period,
        rng.uniform(1.5, 3.0) / motor.free,
        rng.uniform(1.5, 3.0) / (motor.free * max(lag, 0.1)),
        ticks,
    )


def _sensing(rng: Rng) -> Sensing:
    return Sensing(
        rate=float(rng.choice([10.0, 15.0, 20.0, 30.0, 60.0])),
        position_sd=float(np.exp(rng.uniform(np.log(0.0005), np.log(0.003)))),
        heading_sd=float(np.exp(rng.uniform(np.log(0.003), np.log(0.015)))),
        tails=float(rng.choice([0.0, 0.01, 0.03])),
        missing=float(rng.choice([0.0, 0.02, 0.06])),
        ticks=int(rng.choice([135, 360, 1024, 2578])) if rng.random() < 0.5 else 0,
    )


def draw_robot(rng: Rng, needs: dict[str, str]) -> Robot:
    """Draw a robot without departures; `needs` may fix drive (duty or speed), tyre (brush or engine) and caster."""
    names = [n for n, k in KINDS.items() if needs.get("caster", k.caster) == k.caster]
    if needs.get("caster") == "ball":
        names += [n for n, k in KINDS.items() if k.caster == "pair"]
    name = str(rng.choice(names))
    kind = KINDS[name]
    mass, radius, axle, speed = (
        float(rng.uniform(*span)) for span in (kind.mass, kind.radius, kind.axle, kind.speed)
    )
    height, behind = float(rng.uniform(*kind.height)), float(rng.uniform(*kind.behind))
    casters = _casters(rng, kind, axle, radius)
    driven_by = needs.get("drive") or ("speed" if rng.random() < 0.36 else "duty")
    margin = rng.uniform(1.25, 1.5) if driven_by == "speed" else 1.0
    lag = max(float(rng.uniform(0.06, 0.2)), margin * speed / HARDEST_START)
    free = margin * speed / radius
    motors = _motors(rng, mass, radius, free, lag)
    wheel = Wheel(radius, 0.025 * mass)
    brush = needs.get("tyre", "brush" if rng.random() < 0.35 else "engine") == "brush"
    grip = float(rng.uniform(0.6, 0.9))
    stiff = float(rng.uniform(10.0, 20.0))
    size = 1.2 * axle
    return Robot(
        kind=name,
        mass=mass * 0.95,
        centre=(math.copysign(behind, casters[0].x) / 0.95, 0.0, height - radius),
        inertia=(mass * size**2 / 14, mass * size**2 / 13, mass * size**2 / rng.uniform(7, 9)),
        axle=axle,
        full_rate=speed / radius,
        wheels=(wheel, wheel),
        motors=motors,
        casters=casters,
        tyre=Tyre(
            brush, grip, grip, stiff, stiff * rng.uniform(0.7, 1.0), length=radius * rng.uniform(0.25, 0.45)
        ),
        controller=_controller(rng, motors[0], lag) if driven_by == "speed" else None,
        sensing=_sensing(rng),
        command_period=float(rng.choice([0.02, 0.04, 0.05, 0.1])),
        reach=float(rng.uniform(*kind.reach)),
        lag=lag,
    )
