"""What a simulated robot truly is: every physical parameter, with the effects at their neutral values.

Pairs are (left, right). A motor is written at its output shaft: `emf` [V s/rad] is the back-EMF constant
times the gear ratio, which is also torque per ampere [N m/A] (SI units make both constants one number, see
any text on permanent-magnet DC motors, for instance Spong, Hutchinson and Vidyasagar, *Robot Modeling and
Control*).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Pair = tuple[float, float]
GRAVITY = 9.81


@dataclass(frozen=True)
class Body:
    """Chassis, wheels and caster; the frame's origin is the middle of the axle, x forward, y left."""

    kind: str
    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]
    axle: float
    radius: Pair
    wheel_mass: float
    tyre_grip: float
    caster: str  # "ball" or "swivel"
    caster_arm: float  # x of the caster [m]; negative = behind
    caster_radius: float
    caster_grip: float  # friction coefficient of a ball that slides in its seat
    swivel_torque: float  # dry friction of the fork's bearing [N m]
    caster_axle_torque: float  # dry friction of the caster wheel's axle [N m]
    rolling: float  # coefficient of rolling resistance
    tyre_width: float = 0.0
    hub_offset: Pair = (0.0, 0.0)
    oval: Pair = (0.0, 0.0)
    phase: Pair = (0.0, 0.0)
    cornering: float = 0.0  # lateral force per unit of load and slip angle [1/rad]; 0 = no creep
    payload: float = 0.0
    payload_at: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Drive:
    """Battery, drivers, motors and gears, and the controller where there is one."""

    mode: str  # "duty" or "rate"
    volts: float
    emf: Pair
    ohm: Pair
    dry: Pair
    viscous: Pair
    rotor: Pair  # inertia seen at the wheel [kg m2]
    top_rate: float  # [rad/s] at command 1
    gain: Pair = (1.0, 1.0)
    # on-board controller
    control_hz: float = 100.0
    proportional: float = 1.0
    integral: float = 5.0
    feed: float = 1.0
    counts: int = 2000
    # firmware and driver
    deadzone: float = 0.0
    expo: Pair = (0.0, 0.0)
    ceiling: float = 1.0
    slew: Pair = (0.0, 0.0)  # largest change of the command [1/s]; 0 = none
    lowpass: Pair = (0.0, 0.0)
    bridge_drop: float = 0.0
    reverse_drop: Pair = (0.0, 0.0)
    coast: Pair = (0.0, 0.0)
    delay: float = 0.0
    jitter: float = 0.0
    crosstalk: float = 0.0
    # motors and battery
    reverse_emf: Pair = (1.0, 1.0)
    static_ratio: float = 1.0
    stribeck_rate: float = 1.0
    backlash: Pair = (0.0, 0.0)
    cell_ohm: float = 0.0
    discharge: float = 0.0
    grease: Pair = (0.0, 0.0)
    grease_time: float = 20.0
    heat: float = 0.0  # final rise of the windings at `heat_watt` [K]
    heat_watt: float = 1.0
    heat_time: float = 20.0


@dataclass(frozen=True)
class Patch:
    """A round patch of floor."""

    x: float
    y: float
    radius: float
    rolling: float = 0.0
    grip: float = 0.0


@dataclass(frozen=True)
class Place:
    """Floor, and what acts on the robot from outside."""

    tilt: tuple[float, float] = (0.0, 0.0)  # slope angle [rad], direction of falling ground [rad]
    nap_drag: float = 0.0
    nap_carry: float = 0.0
    nap_heading: float = 0.0
    rough: Patch | None = None
    slippery: Patch | None = None
    fault: str = ""
    fault_side: int = 0
    fault_size: float = 0.0
    push: float = 0.0  # force [N]
    push_time: float = 0.3
    push_heading: float = 0.0
    push_at: tuple[float, float] = (0.0, 0.0)
    tether: float = 0.0  # pull [N] of the cable
    tether_at: tuple[float, float] = (0.0, 0.0)
    fan: float = 0.0  # force [N] of the gusts
    fan_period: float = 7.0
    fan_heading: float = 0.0


@dataclass(frozen=True)
class Watch:
    """How the tracker sees the robot, beyond its noise."""

    tag: tuple[float, float] = (0.0, 0.0)
    tag_yaw: float = 0.0
    delay: float = 0.0
    smoothing: float = 0.0  # time constant of the tracker's filter [s]
    clock: float = 0.0  # the tracker's clock gains this many seconds a second
    seam: Patch | None = None
    seam_shift: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Truth:
    """One robot in its place."""

    body: Body
    drive: Drive
    place: Place = Place()
    watch: Watch = Watch()


@dataclass(frozen=True)
class Moments:
    """What happens at times of its own in one drive; infinite = never. `seed`: contact chatter, jitter."""

    fault_start: float = np.inf
    fault_end: float = np.inf
    push_start: float = np.inf
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A noise-free drive: true poses and wheel angles at `time`, and the commands as they were given."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    left: np.ndarray
    right: np.ndarray
    height: np.ndarray
    command_time: np.ndarray
    command_left: np.ndarray
    command_right: np.ndarray


def loads(body: Body) -> tuple[float, float, float]:
    """Return the static loads [N] of left wheel, right wheel and caster: moments about axle and midline."""
    masses = np.array([body.mass, body.wheel_mass, body.wheel_mass, body.payload])
    at_x = np.array([body.centre[0], 0.0, 0.0, body.payload_at[0]])
    at_y = np.array([body.centre[1], body.axle / 2, -body.axle / 2, body.payload_at[1]])
    weight = float(masses.sum()) * GRAVITY
    x, y = float(masses @ at_x / masses.sum()), float(masses @ at_y / masses.sum())
    caster = float(np.clip(weight * x / body.caster_arm, 0.0, 0.9 * weight))
    share = float(np.clip(0.5 + weight * y / body.axle / (weight - caster), 0.02, 0.98))
    return (weight - caster) * share, (weight - caster) * (1 - share), caster


def total_mass(body: Body) -> float:
    """Return the mass of everything [kg]."""
    return body.mass + 2 * body.wheel_mass + body.payload
