"""What a robot consists of: masses, wheels, motors, casters, controller, as plain numbers in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

Pair = tuple[float, float]
"""A number for the left wheel and one for the right."""


@dataclass(frozen=True)
class Caster:
    """A third point on the floor.

    x : place ahead of the axle [m]; y : to the left [m]; kind : "ball" (slides on `friction`) or "fork" (swivels);
    friction : coefficient of a ball; lift : above the floor at rest [m]; radius of ball or wheel [m]; trail of a
    fork [m]; pivot and roll : dry friction of a fork's two joints [Nm].
    """

    x: float
    y: float = 0.0
    kind: str = "ball"
    friction: float = 0.02
    lift: float = 0.0
    radius: float = 0.01
    trail: float = 0.0
    pivot: float = 0.0
    roll: float = 0.0


@dataclass(frozen=True)
class Trailer:
    """A one-wheeled cart hung behind: mass [kg], bar from hitch to its wheel [m], its side friction coefficient."""

    mass: float
    bar: float
    hitch: float
    drag: float


@dataclass(frozen=True)
class Plant:
    """Everything that rolls.

    mass [kg] of the body without wheels; com : its centre (ahead, left, above the axle) [m]; inertia [kg m2] about
    its own axes; radius, axle [m]; grip : friction coefficient of the tyres; wheel_mass [kg]; armature [kg m2] at the
    wheel; dry [Nm]; rolling : share of the load; viscous [Nms]; stall [Nm]; free [rad/s];
    play : of the gear at the wheel [rad]; bore : rim off its centre [m] towards `bore_at` [rad]; twin : distance of a
    tyre's two lines from its middle [m]; slope : of the
    floor, down along x and y of the world [rad].
    """

    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float]
    radius: Pair
    axle: float
    grip: Pair
    wheel_mass: float
    armature: Pair
    dry: Pair
    rolling: Pair
    viscous: Pair
    stall: Pair
    free: Pair
    casters: tuple[Caster, ...]
    play: Pair = (0.0, 0.0)
    bore: Pair = (0.0, 0.0)
    bore_at: Pair = (0.0, 0.0)
    twin: Pair = (0.0, 0.0)
    slope: Pair = (0.0, 0.0)
    trailer: Trailer | None = None

    @property
    def total(self) -> float:
        """Mass with both wheels [kg]."""
        return self.mass + 2.0 * self.wheel_mass

    @property
    def wheel_load(self) -> float:
        """Mean load of a wheel at rest [N]."""
        low = [c for c in self.casters if c.lift == 0.0]
        arm = -sum(c.x for c in low) / max(len(low), 1)
        share = min(max(1.0 + self.com[0] / arm, 0.3), 1.0) if arm > 0 else 1.0
        return 0.5 * 9.81 * (self.mass * share + 2.0 * self.wheel_mass)


@dataclass(frozen=True)
class Control:
    """Speed controller on counted encoders.

    period [s]; kp [duty for a unit of relative speed error]; ki [1/s]; ahead : share of feed-forward; windup : limit
    of the integral [duty]; smooth : time constant of the measured rate [s]; ticks : counts a turn of the wheel.
    """

    period: float
    kp: float
    ki: float
    ahead: float
    windup: float
    smooth: float
    ticks: int
    full: float


@dataclass(frozen=True)
class Sensing:
    """How poses are taken: rate [Hz], noise [m] and [rad], heavy tails, losses, encoders, the tag's place."""

    rate: float
    noise_xy: float
    noise_theta: float
    tail: float
    missing: float
    gaps: int
    encoder_ticks: int
    tag: tuple[float, float] = (0.0, 0.0)
    tag_yaw: float = 0.0


@dataclass(frozen=True)
class Robot:
    """One robot as built, with its data sheet and its place of work."""

    kind: str
    plant: Plant
    control: Control | None
    sensing: Sensing
    sheet: dict[str, float]
    full_rate: float
    area: float
    tick: float
    departures: dict[str, float] = field(default_factory=dict)
