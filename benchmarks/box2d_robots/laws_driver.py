"""Laws of the bridge that drives the motors: dead zones, curves, coarse steps, lags up and down."""

from __future__ import annotations

import math
from collections.abc import Callable

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw

DUTY = ("duty",)


def _bent(setup: Setup, curve: Callable[[float], float]) -> None:
    """Let the bridge give another duty than asked for."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            duty = now.duty
            duty[0] = min(max(curve(float(duty[0])), -1.0), 1.0)
            duty[1] = min(max(curve(float(duty[1])), -1.0), 1.0)

        return hook

    setup.drive.append(make)


@law(
    "motor_deadband",
    "transistor_drop",
    (0.0008, 0.5),
    "1",
    "a bridge of bipolar transistors keeps 2 to 5 V, more with current (ST, L298 data sheet)",
    DUTY,
)
def transistor_drop(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    stall = setup.plant.volts / setup.plant.winding[0]

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                u = float(now.duty[k])
                drop = size * (0.75 + 0.6 * min(abs(float(now.amps[k])) / stall, 1.0))
                now.duty[k] = math.copysign(max(abs(u) - drop, 0.0), u)

        return hook

    setup.drive.append(make)
    return {"dead": size}


@law(
    "motor_deadband",
    "dead_time",
    (0.0008, 0.5),
    "1",
    "the pause between the bridge's switches eats a part of each pulse; ripple current rounds the "
    "corner at zero",
    DUTY,
)
def dead_time(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    _bent(setup, lambda u: u - size * math.tanh(1.5 * u / size))
    return {"dead": size}


@law(
    "motor_deadband",
    "overcompensated",
    (0.0008, 0.5),
    "1",
    "firmware lifts every command over a dead zone that these motors do not have (minimum PWM in sketches)",
    DUTY,
)
def overcompensated(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def curve(u: float) -> float:
        return u + math.copysign(size, u) * (1.0 - size) if abs(u) > 0.004 else 0.0

    _bent(setup, curve)
    return {"lift": size}


@law(
    "motor_gain_curve",
    "stick_expo",
    (0.004, 0.95),
    "1",
    "a speed controller made for model cars bends its throttle for a soft middle (expo of radio sets)",
    DUTY,
)
def stick_expo(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    _bent(setup, lambda u: u * (1.0 - size + size * u * u))
    return {"expo": size}


@law(
    "motor_gain_curve",
    "broken_current",
    (0.004, 2.5),
    "1",
    "slow pulses with fast decay: the current breaks off and small duties drive more than their share"
    " (discontinuous conduction, Mohan, Undeland and Robbins, Power Electronics)",
    DUTY,
)
def broken_current(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    _bent(setup, lambda u: u * (1.0 + size) / (1.0 + size * abs(u)))
    return {"bend": size}


@law(
    "pwm_steps",
    "nearest_step",
    (0.003, 0.7),
    "1",
    "a timer with few counts (software PWM of a port expander) rounds duties to its steps",
    DUTY,
)
def nearest_step(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    _bent(setup, lambda u: size * round(u / size))
    return {"step": size}


@law(
    "pwm_steps",
    "integer_cast",
    (0.003, 0.6),
    "1",
    "the duty is cast to a small integer and what is left is thrown away, towards zero",
    DUTY,
)
def integer_cast(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    _bent(setup, lambda u: size * math.trunc(u / size))
    return {"step": size}


@law(
    "motor_asymmetric_lag",
    "freewheel",
    (0.03, 1.0),
    "1",
    "the bridge drives but lets the motor run on in its pauses (fast decay, no brake), so it slows by "
    "friction alone",
    DUTY,
)
def freewheel(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.block[:] = size

        return hook

    setup.motor.append(make)
    return {"share": size}


@law(
    "motor_asymmetric_lag",
    "soft_start",
    (0.03, 4.0),
    "s",
    "the speed controller ramps its duty up to spare its transistors and cuts it at once",
    DUTY,
)
def soft_start(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        held, step = [0.0, 0.0], machine.step / size

        def hook(now: Now) -> None:
            for k in (0, 1):
                u, h = float(now.duty[k]), held[k]
                if u * h < 0.0:
                    h = 0.0
                h = u if abs(u) <= abs(h) else math.copysign(min(abs(h) + step, abs(u)), u)
                held[k] = h
                now.duty[k] = h

        return hook

    setup.drive.append(make)
    return {"ramp_s": size}


@law(
    "motor_asymmetric_lag",
    "slow_release",
    (0.003, 1.5),
    "s",
    "the gate filter fills fast and empties slowly: a first-order lag on the way down only (RC with a diode)",
    DUTY,
)
def slow_release(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        held, down = [0.0, 0.0], machine.step / size

        def hook(now: Now) -> None:
            for k in (0, 1):
                u, h = float(now.duty[k]), held[k]
                up = u * h >= 0.0 and abs(u) >= abs(h)
                held[k] = u if up else h + min(down, 1.0) * (u - h)
                now.duty[k] = held[k]

        return hook

    setup.drive.append(make)
    return {"lag_down_s": size}
