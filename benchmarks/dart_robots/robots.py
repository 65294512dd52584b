"""Robots that people own, with the nuisances of every real one, and how they are watched.

Sizes follow the makers' pages: Duckiebot DB21 (1.1 kg, wheels of 65 mm), ROBOTIS TurtleBot3 Burger (1 kg,
axle 160 mm, wheels of 66 mm, 0.22 m/s), Kobuki and iRobot Create (axle 230 mm, 0.7 and 0.5 m/s), and a
research cart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.dart_robots.truth import Body, Drive, Pair, Truth, Watch, loads, total_mass

Span = tuple[float, float]


@dataclass(frozen=True)
class Kind:
    """The ranges of one kind of robot."""

    mass: Span
    axle: Span
    radius: Span
    top_speed: Span
    size: tuple[float, float, float]  # length, width, height of the chassis [m]
    arm: Span
    behind: Span  # centre of mass from the axle towards the caster [m]
    wheel_mass: float
    caster_radius: float
    volts: float


KINDS = {
    "duckiebot": Kind(
        (1.0, 1.3), (0.095, 0.106), (0.0310, 0.0335), (0.45, 0.65), (0.16, 0.10, 0.09), (0.060, 0.085),
        (0.003, 0.010), 0.035, 0.008, 8.0,
    ),
    "burger": Kind(
        (0.9, 1.1), (0.155, 0.165), (0.0325, 0.0335), (0.20, 0.28), (0.14, 0.15, 0.16), (0.065, 0.085),
        (0.003, 0.010), 0.03, 0.008, 12.0,
    ),
    "kobuki": Kind(
        (2.5, 4.0), (0.225, 0.236), (0.0345, 0.0365), (0.45, 0.70), (0.33, 0.33, 0.10), (0.10, 0.13),
        (0.004, 0.014), 0.08, 0.011, 14.4,
    ),
    "cart": Kind(
        (10.0, 15.0), (0.38, 0.42), (0.066, 0.074), (0.50, 0.80), (0.45, 0.36, 0.20), (0.16, 0.22),
        (0.008, 0.025), 0.35, 0.025, 24.0,
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Facts:
    """What the data sheet says."""

    wheel_radius: float
    axle_length: float
    max_wheel_rate: float


@dataclass(frozen=True)
class Sensing:
    """The tracker's and encoders' quality."""

    pose_hz: float
    position_sd: float
    heading_sd: float
    heavy_tail: float  # degrees of freedom of Student's t; 0 = normal
    missing: float
    stamp_jitter: float
    command_hz: float
    log_changes: bool
    ticks_per_turn: int  # 0 = no encoders
    encoder_hz: float


def _box(mass: float, size: tuple[float, float, float]) -> tuple[float, float, float]:
    length, width, height = size
    moments = (width**2 + height**2, length**2 + height**2, length**2 + width**2)
    return tuple(mass / 12.0 * each for each in moments)  # type: ignore[return-value]


def _spread(rng: np.random.Generator, middle: float, share: float) -> Pair:
    """Return a pair about `middle` that differs by up to `share`."""
    half = float(rng.uniform(-share, share)) / 2
    return middle * (1 + half), middle * (1 - half)


def draw_robot(rng: np.random.Generator, kind: str, mode: str) -> tuple[Truth, Facts]:
    """Draw a healthy robot of a kind, and its data sheet."""
    ranges = KINDS[kind]
    mass = float(rng.uniform(*ranges.mass)) - 2 * ranges.wheel_mass
    arm = float(rng.uniform(*ranges.arm)) * (-1.0 if rng.random() < 0.8 else 1.0)
    behind = float(rng.uniform(*ranges.behind)) * np.sign(arm)
    radius = float(rng.uniform(*ranges.radius))
    caster = "ball" if rng.random() < 0.7 else "swivel"
    height = ranges.size[2] / 2 - radius
    body = Body(
        kind=kind,
        mass=mass,
        centre=(float(behind), float(rng.uniform(-0.02, 0.02)) * ranges.axle[0], max(height, 0.01)),
        inertia=_box(mass, ranges.size),
        axle=float(rng.uniform(*ranges.axle)),
        radius=_spread(rng, radius, 0.008),
        wheel_mass=ranges.wheel_mass,
        tyre_grip=float(rng.uniform(0.7, 0.95)),
        caster=caster,
        caster_arm=arm,
        caster_radius=ranges.caster_radius * (1.0 if caster == "ball" else 1.4),
        caster_grip=float(rng.uniform(0.01, 0.03)),
        swivel_torque=0.0,
        caster_axle_torque=0.0,
        rolling=float(rng.uniform(0.002, 0.005)),
    )
    top_rate = float(rng.uniform(*ranges.top_speed)) / radius
    return _finished(rng, Truth(body, _motors(rng, body, top_rate, mode, ranges.volts)), radius, top_rate)


def _finished(rng: np.random.Generator, truth: Truth, radius: float, top_rate: float) -> tuple[Truth, Facts]:
    """Finish the caster, the tag and the data sheet."""
    load = loads(truth.body)[2]
    body = replace(
        truth.body,
        swivel_torque=float(rng.uniform(0.005, 0.015)) * load * truth.body.caster_radius,
        caster_axle_torque=float(rng.uniform(0.005, 0.02)) * load * truth.body.caster_radius,
    )
    watch = Watch(
        tag=(float(rng.uniform(-0.0015, 0.0015)), float(rng.uniform(-0.0015, 0.0015))),
        tag_yaw=float(rng.uniform(-0.004, 0.004)),
    )
    facts = Facts(
        radius * float(rng.uniform(0.99, 1.01)),
        body.axle * float(rng.uniform(0.98, 1.02)),
        top_rate * float(rng.uniform(0.95, 1.05)),
    )
    return Truth(body, truth.drive, truth.place, watch), facts


def _motors(rng: np.random.Generator, body: Body, top_rate: float, mode: str, volts: float) -> Drive:
    """Draw motors that bring the robot to speed with a time constant of 0.1 to 0.25 s."""
    headroom = 1.0 if mode == "duty" else float(rng.uniform(1.3, 1.6))
    free_rate = top_rate * headroom * 1.06
    emf = _spread(rng, volts / free_rate, 0.05 if mode == "duty" else 0.08)
    radius = float(np.mean(body.radius))
    carried = 0.5 * total_mass(body) * radius**2
    rotor = carried * float(rng.uniform(0.2, 0.6))
    tau = float(rng.uniform(0.10, 0.25))
    stall = (carried + rotor) * free_rate / tau
    ohm = _spread(rng, volts / free_rate * volts / stall, 0.04)
    dry = float(rng.uniform(0.003, 0.009)) * stall
    viscous = float(rng.uniform(0.01, 0.04)) * stall / free_rate
    # tuned well or badly, but always stable: gains in duty per free rate of error
    return Drive(
        mode=mode,
        volts=volts,
        emf=emf,
        ohm=ohm,
        dry=_spread(rng, dry, 0.3),
        viscous=_spread(rng, viscous, 0.2),
        rotor=(rotor, rotor),
        top_rate=top_rate,
        gain=(1.0, 1.0) if mode == "duty" else _spread(rng, 1.0, 0.03),
        control_hz=float(rng.choice([50.0, 100.0])),
        proportional=float(rng.uniform(0.5, 2.5)),
        integral=float(rng.uniform(3.0, 12.0)),
        feed=float(rng.uniform(0.7, 1.05)),
        counts=int(rng.choice([1200, 2000, 4096])),
    )


def draw_sensing(rng: np.random.Generator, encoders: bool, fine: float) -> Sensing:
    """Draw a tracker and perhaps encoders; `fine` (0 to 1) cuts the upper part off the noise's range."""
    noise = float(rng.uniform(0.0, 1.0 - fine))
    return Sensing(
        pose_hz=float(rng.choice([10.0, 15.0, 20.0, 25.0, 30.0, 50.0])),
        position_sd=0.001 + 0.002 * noise,
        heading_sd=float(np.deg2rad(0.3 + 0.7 * float(rng.uniform(0.0, 1.0 - fine)))),
        heavy_tail=4.0 if rng.random() < 0.3 else 0.0,
        missing=float(rng.uniform(0.0, 0.03)),
        stamp_jitter=float(rng.uniform(0.0, 0.001)),
        command_hz=float(rng.choice([10.0, 12.5, 20.0, 25.0])),
        log_changes=bool(rng.random() < 0.4),
        ticks_per_turn=int(rng.choice([90, 135, 360, 512, 1024, 2048])) if encoders else 0,
        encoder_hz=float(rng.choice([20.0, 25.0, 30.0, 50.0])),
    )
