"""Physics without a name in the catalogue; `outside` is the label, each kind is a law."""

from __future__ import annotations

import numpy as np

from foreign.catalogue import BODIES, Sizes, law
from foreign.planar import FLOOR_X, FLOOR_Y, FX, FY, MZ
from foreign.setup import Array, Setup

LABEL = "outside"


@law(LABEL, "cross_talk", most=5)
def cross_talk(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Each driver takes in a share of the other wheel's command (capacitive coupling of the lines)."""
    k = float(rng.choice([-1, 1])) * 0.10 * s
    setup.samples.append(lambda _, duty: duty + k * duty[:, ::-1])
    return {"share": k}


@law(LABEL, "fan", most=6)
def fan(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A fan stands in the arena and blows: force by a Gaussian jet around its axis."""
    way, force, wide = float(rng.uniform(-np.pi, np.pi)), 0.06 * s * setup.weight, 0.35 * setup.reach

    def act(_: float, state: Array, hook: Array) -> None:
        off = -state[0] * np.sin(way) + state[1] * np.cos(way)
        now = force * np.exp(-((off / wide) ** 2))
        hook[FX] += now * np.cos(way)
        hook[FY] += now * np.sin(way)

    setup.hooks.append(act)
    return {"force_N": force, "way_rad": way}


@law(LABEL, "conveyor", BODIES, placed=True, most=6)
def conveyor(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A belt in the floor carries the robot."""
    way, speed, place = float(rng.uniform(-np.pi, np.pi)), 0.10 * s * setup.speed, setup.place

    def act(_: float, state: Array, hook: Array) -> None:
        depth = place.inside(state[0], state[1]) if place else 0.0
        hook[FLOOR_X] += depth * speed * np.cos(way)
        hook[FLOOR_Y] += depth * speed * np.sin(way)

    setup.hooks.append(act)
    return {"speed_m_s": speed, "way_rad": way}


@law(LABEL, "missed_pulses", most=4)
def missed_pulses(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """One driver loses pulses at random moments, all the time."""
    share, column, seed = 0.12 * s, int(rng.integers(2)), int(rng.integers(2**31)) + setup.salt
    share = min(share, 0.6)
    draws = np.random.default_rng(seed)
    edges = np.cumsum(
        np.column_stack(
            [draws.exponential(0.5 * (1 - share), 2000), draws.exponential(0.5 * share, 2000)]
        ).ravel()
    )

    def act(grid: Array, duty: Array) -> Array:
        duty = duty.copy()
        duty[np.searchsorted(edges, grid) % 2 == 1, column] = 0.0
        return duty

    setup.samples.append(act)
    return {"share": share, "wheel": ["left", "right"][column]}


@law(LABEL, "resonance", most=6)
def resonance(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Between two duties the drivetrain rings and swallows power (a notch in the curve around one speed)."""
    at, depth, wide = float(rng.uniform(0.35, 0.65)), min(0.25 * s, 0.9), 0.07
    column = int(rng.integers(2))

    def act(_: Array, duty: Array) -> Array:
        duty = duty.copy()
        a = np.abs(duty[:, column])
        duty[:, column] *= 1.0 - depth * np.exp(-(((a - at) / wide) ** 2))
        return duty

    setup.samples.append(act)
    return {"at_duty": at, "depth": depth}


@law(LABEL, "tether", most=8)
def tether(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """An elastic cable to the middle of the arena pulls once it is taut."""
    slack, stiff = 0.25 * setup.reach, 0.25 * s * setup.weight / setup.reach

    def act(_: float, state: Array, hook: Array) -> None:
        far = float(np.hypot(state[0], state[1]))
        if far > slack:
            pull = min(stiff * (far - slack), 0.5 * setup.weight)
            hook[FX] -= pull * state[0] / far
            hook[FY] -= pull * state[1] / far

    setup.hooks.append(act)
    return {"stiffness_N_m": stiff, "slack_m": slack}


@law(LABEL, "gust", most=6)
def gust(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A periodic gust from one side."""
    way, period, force = float(rng.uniform(-np.pi, np.pi)), float(rng.uniform(3, 9)), 0.08 * s * setup.weight

    def act(t: float, state: Array, hook: Array) -> None:
        now = force * max(np.sin(2 * np.pi * t / period), 0.0) ** 2
        hook[FX] += now * np.cos(way)
        hook[FY] += now * np.sin(way)

    setup.hooks.append(act)
    return {"force_N": force, "period_s": period}


@law(LABEL, "echo", most=5)
def echo(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The link repeats: a share of the command of half a second ago is added."""
    share, late = 0.12 * s, float(rng.uniform(0.4, 0.9))

    def act(grid: Array, duty: Array) -> Array:
        back = round(late / 0.0005)
        old = np.zeros_like(duty)
        old[back:] = duty[:-back] if back < len(duty) else 0.0
        return (1 - share) * duty + share * old if len(duty) > back else (1 - share) * duty

    setup.samples.append(act)
    return {"share": share, "late_s": late}


@law(LABEL, "magnet", most=8)
def magnet(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Something under the floor attracts, more the nearer."""
    force, near = 0.10 * s * setup.weight, 0.3 * setup.reach

    def act(_: float, state: Array, hook: Array) -> None:
        far = float(np.hypot(state[0], state[1]))
        now = force * (far / near) / (1 + (far / near) ** 2) ** 2 * 3
        hook[FX] -= now * state[0] / max(far, 1e-6)
        hook[FY] -= now * state[1] / max(far, 1e-6)

    setup.hooks.append(act)
    return {"force_N": force}


@law(LABEL, "flywheel", most=6)
def flywheel(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A flywheel on board reacts: a moment by the robot's forward acceleration, smoothed."""
    gain = float(rng.choice([-1, 1])) * 0.10 * s * setup.body["mass"] * setup.size
    memory = [0.0, 0.0]

    def act(t: float, state: Array, hook: Array) -> None:
        if t < 0.011:
            memory[:] = [0.0, 0.0]
        along = state[3] * np.cos(state[2]) + state[4] * np.sin(state[2])
        memory[0] += 0.05 * (along - memory[0])
        memory[1] += 0.03 * (memory[0] - memory[1])
        hook[MZ] += gain * (memory[0] - memory[1]) * 8

    setup.hooks.append(act)
    return {"gain": gain}


@law(LABEL, "compass_motor", most=6)
def compass_motor(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The left motor's magnets feel the building's steel: its strength goes by the heading (three lobes)."""
    force, phase = 0.05 * s * setup.weight * setup.size, float(rng.uniform(-np.pi, np.pi))
    setup.hooks.append(
        lambda _, state, hook: hook.__setitem__(
            MZ, hook[MZ] + force * np.sin(3 * state[2] + phase) * np.tanh(np.hypot(state[3], state[4]) / 0.02)
        )
    )
    return {"moment_N_m": force}
