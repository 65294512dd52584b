"""Laws between the operator and the motor: links, drivers, curves, faults.

Sources: ROS and serial-link practice (queues, fixed control periods); Borenstein & Feng, IEEE T-RA 12 (1996); Hughes &
Drury, Electric Motors and Drives ch. 4 (PWM choppers, slow and fast decay); Tao & Kokotovic, Adaptive Control of Systems
with Actuator and Sensor Nonlinearities (dead zones, their inverses, hysteresis); Isermann, Fault-Diagnosis Systems.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from foreign.catalogue import Sizes, law, which_wheels
from foreign.setup import Array, Setup


def shape(setup: Setup, which: str, curve) -> None:
    """Put duties of some wheels through a curve of (magnitude, sign) -> magnitude."""
    columns = setup.columns(which)

    def act(_: Array, duty: Array) -> Array:
        duty = duty.copy()
        part = duty[:, columns]
        duty[:, columns] = np.sign(part) * curve(np.abs(part), np.sign(part))
        return duty

    setup.samples.append(act)


@law("motor_deadband", "pwm_floor", most=4)
def pwm_floor(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Duties below the chopper's shortest pulse are lost; above it the motor gets what is left of it."""
    d, which = 0.04 * s, which_wheels(rng)
    shape(setup, which, lambda a, _: np.clip((a - d) / (1.0 - d), 0.0, None))
    return {"wheels": which, "duty_lost": d}


@law("motor_deadband", "offset_loss", most=4)
def offset_loss(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Brush drop: a fixed voltage is lost at any duty, with a soft corner (diode law)."""
    d, which = 0.035 * s, which_wheels(rng)
    soft = 0.25 * d + 1e-6
    shape(
        setup,
        which,
        lambda a, _: soft * (np.logaddexp(0.0, (a - d) / soft) - np.logaddexp(0.0, -d / soft)),
    )
    return {"wheels": which, "duty_lost": d}


@law("motor_deadband", "overcompensated", most=4)
def overcompensated(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Firmware adds more than the dead zone: any command jumps by a fixed duty (an exaggerated inverse)."""
    d, which = 0.035 * s, which_wheels(rng, 0.7)
    shape(setup, which, lambda a, _: np.where(a > 0.005, np.minimum(a + d, 1.0), a))
    return {"wheels": which, "duty_lost": -d}


@law("motor_deadband", "start_step", most=4)
def start_step(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Duties below a threshold do nothing, above it everything arrives, with a threshold of return (hysteresis)."""
    d, which = 0.11 * s, which_wheels(rng, 0.7)
    shape(setup, which, lambda a, _: np.where(a < d, 0.0, a - 0.2 * d))
    return {"wheels": which, "duty_lost": 0.2 * d, "threshold": d}


@law("command_saturation", "hard_clip", most=1.6)
def hard_clip(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The driver clips."""
    top = 1.0 - 0.45 * s
    which = which_wheels(rng, 0.8)
    shape(setup, which, lambda a, _: np.minimum(a, top))
    return {"wheels": which, "limit": top}


@law("command_saturation", "soft_knee", most=1.6)
def soft_knee(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The driver runs softly into its limit: a p-norm knee."""
    top = 1.05 - 0.45 * s
    which = which_wheels(rng, 0.8)
    shape(setup, which, lambda a, _: a / (1.0 + (a / top) ** 8) ** 0.125)
    return {"wheels": which, "limit": top}


@law("command_saturation", "desaturated", most=1.6)
def desaturated(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A mixer scales both wheels when one is beyond the limit, so that the curvature stays."""
    top = 1.0 - 0.45 * s

    def act(_: Array, duty: Array) -> Array:
        return duty * np.minimum(1.0, top / np.maximum(np.abs(duty).max(axis=1), 1e-9))[:, None]

    setup.samples.append(act)
    return {"wheels": "both", "limit": top}


@law("motor_gain_curve", "power", most=4)
def power(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Power law, as radio-control transmitters and drivers with slow decay have."""
    p, which = float(np.exp(rng.choice([-1, 1]) * 0.14 * s)), which_wheels(rng)
    shape(setup, which, lambda a, _: a**p)
    return {"wheels": which, "exponent": p}


@law("motor_gain_curve", "exponential", most=4)
def exponential(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Exponential curve through 0 and 1."""
    k, which = float(rng.choice([-1, 1]) * 0.6 * s), which_wheels(rng)
    shape(setup, which, lambda a, _: np.expm1(k * a) / np.expm1(k))
    return {"wheels": which, "exponent": k}


@law("motor_gain_curve", "s_curve", most=4)
def s_curve(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Cubic S-shape: weak in the middle or at both ends."""
    k, which = float(rng.choice([-1, 1]) * 0.7 * s), which_wheels(rng)
    shape(setup, which, lambda a, _: a + k * a * (a - 0.5) * (a - 1.0))
    return {"wheels": which, "cubic": k}


@law("motor_gain_curve", "bent", most=4)
def bent(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Discontinuous to continuous conduction: two straight pieces with a bend."""
    knee, k, which = float(rng.uniform(0.3, 0.55)), float(rng.choice([-1, 1]) * 0.28 * s), which_wheels(rng)
    shape(setup, which, lambda a, _: np.maximum(a + k * (np.minimum(a, knee) - knee * a), 0.0))
    return {"wheels": which, "bend": k, "at": knee}


@law("motor_reverse_asymmetry", "driver", most=4)
def reverse_driver(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """One half bridge drops more voltage: reverse duties are scaled."""
    k, which = float(1.0 - rng.choice([1, 1, -1]) * 0.10 * s), which_wheels(rng)
    shape(setup, which, lambda a, sign: np.where(sign < 0, k * a, a))
    return {"wheels": which, "reverse_over_forward": k}


@law("motor_reverse_asymmetry", "diode", most=4)
def reverse_diode(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Reverse runs through a diode: a fixed share of duty is missing there."""
    d, which = 0.05 * s, which_wheels(rng)
    shape(setup, which, lambda a, sign: np.where(sign < 0, np.maximum(a - d, 0.0), a))
    return {"wheels": which, "duty_lost_in_reverse": d}


@njit(cache=True)
def slew(dt: float, duty: Array, up: float, down: float) -> Array:
    """Rate limit [1/s], one for growing and one for falling magnitudes."""
    out = np.empty_like(duty)
    x = 0.0
    for k in range(len(duty)):
        gap = duty[k] - x
        limit = (up if abs(duty[k]) > abs(x) and duty[k] * x >= 0.0 else down) * dt
        x += min(max(gap, -limit), limit)
        out[k] = x
    return out


@law("motor_asymmetric_lag", "slew", most=5)
def asymmetric_slew(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The driver's ramp is slow one way: a rate limit on growing or on falling duty."""
    slow = 2.2 / s
    up, down = (slow, 1e9) if rng.random() < 0.5 else (1e9, slow)
    columns = setup.columns(which_wheels(rng, 0.8))

    def act(grid: Array, duty: Array) -> Array:
        duty = duty.copy()
        for column in columns:
            duty[:, column] = slew(0.0005, np.ascontiguousarray(duty[:, column]), up, down)
        return duty

    setup.samples.append(act)
    return {"columns": columns, "rate_up": up, "rate_down": down}


def event(setup: Setup, columns: list[int], factor) -> None:
    """Scale duties of some wheels by `factor(share of the event gone)` while the event lasts."""
    window = setup.window
    if window is None:
        return
    start, end = window

    def act(grid: Array, duty: Array) -> Array:
        duty = duty.copy()
        on = (grid >= start) & (grid < end)
        duty[np.ix_(on, columns)] *= factor((grid[on] - start) / (end - start))[:, None]
        return duty

    setup.samples.append(act)


@law("motor_fault", "step", most=6)
def fault_step(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """One motor is weaker for a time (a brush lifts)."""
    k, which = max(1.0 - 0.15 * s, 0.0), str(rng.choice(["left", "right"]))
    event(setup, setup.columns(which), lambda share: np.full(len(share), k))
    return {"wheels": which, "gain": k, "when": setup.window}


@law("motor_fault", "dropouts", most=6)
def fault_dropouts(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A loose contact: the motor loses its voltage many times for 40 to 160 ms."""
    share_off, which = min(0.15 * s, 0.9), str(rng.choice(["left", "right"]))
    on = rng.exponential(0.1 * (1 - share_off) / share_off, 400) + 0.01
    off = rng.uniform(0.04, 0.16, 400)
    edges = np.cumsum(np.column_stack([on, off]).ravel())
    span = 0.0 if setup.window is None else setup.window[1] - setup.window[0]

    def factor(share: Array) -> Array:
        return (np.searchsorted(edges, share * span) % 2 == 0).astype(float)

    event(setup, setup.columns(which), factor)
    return {"wheels": which, "gain": 1.0 - share_off, "when": setup.window}


@law("motor_fault", "fade", most=6)
def fault_fade(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A driver overheats: the voltage fades away and comes back at once."""
    depth, which = min(0.3 * s, 1.0), str(rng.choice(["left", "right"]))
    event(setup, setup.columns(which), lambda share: 1.0 - depth * share)
    return {"wheels": which, "gain": 1.0 - 0.5 * depth, "when": setup.window}


@law("motor_fault", "stuck_high", most=3)
def fault_stuck(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """One motor is stronger for a time (its current limiter is bypassed)."""
    k, which = 1.0 + 0.14 * s, str(rng.choice(["left", "right"]))
    event(setup, setup.columns(which), lambda share: np.full(len(share), k))
    return {"wheels": which, "gain": k, "when": setup.window}


@law("command_delay", "constant", most=6)
def delay_constant(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A link with a fixed delay."""
    d = 0.06 * s
    setup.rows.append(lambda t, duty: (t + d, duty))
    return {"delay_s": d}


@law("command_delay", "jittered", most=6)
def delay_jittered(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A radio link: a fixed part and a gamma-distributed part; a late row is overtaken by none (in order)."""
    fixed, random = 0.035 * s, 0.025 * s
    seed = int(rng.integers(2**31)) + setup.salt

    def act(t: Array, duty: Array) -> tuple[Array, Array]:
        draws = np.random.default_rng(seed).gamma(2.0, 0.5 * random, len(t))
        return np.maximum.accumulate(t + fixed + draws), duty

    setup.rows.append(act)
    return {"delay_s": fixed + random, "jitter_s": random / np.sqrt(2)}


@law("command_delay", "control_period", most=6)
def delay_period(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A firmware loop takes the command at its next tick and acts one tick later."""
    period, phase = 0.04 * s, float(rng.uniform(0, 1))
    setup.rows.append(lambda t, duty: ((np.ceil(t / period - phase) + phase + 1.0) * period, duty))
    return {"delay_s": 1.5 * period}


@law("command_delay", "queue", most=6)
def delay_queue(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A serial queue: each command takes its time to be handled, so bursts wait."""
    fixed, service = 0.05 * s, 0.03

    def act(t: Array, duty: Array) -> tuple[Array, Array]:
        done, out = -1.0, np.empty(len(t))
        for k, at in enumerate(t):
            done = max(done, at + fixed - service) + service
            out[k] = done
        return out, duty

    setup.rows.append(act)
    return {"delay_s": fixed}
