"""Laws of the floor and of what pushes: slope, nap, patches, shoves.

Sources: Wong, Theory of Ground Vehicles ch. 2 and 4 (rolling resistance, shear, soft ground); Bekker (sinkage); Ojeda &
Borenstein (2004) and robot vacuum makers' application notes (carpet grain pulls a moving robot along the nap); Spiesberger
(friction of wet and dusty floors); Karayiannidis et al. (pushes as half sines).
"""

from __future__ import annotations

import numpy as np

from foreign.catalogue import BODIES, FLAT, PUSHED, Sizes, law
from foreign.planar import DRAG_C, DRAG_L, DRAG_R, FLOOR_X, FLOOR_Y, FX, FY, MU_L, MU_R, MZ, SLACK_L, SLACK_R
from foreign.setup import Array, Setup


def moving(state: Array) -> float:
    """Return how much a robot moves, 0 at rest to 1, by its wheels' speed."""
    return float(np.tanh(np.hypot(state[3], state[4]) / 0.02))


def running(setup: Setup, state: Array) -> float:
    """Return how much either wheel runs, 0 to 1: a robot that spins runs too."""
    return float(np.tanh((np.hypot(state[3], state[4]) + abs(state[5]) * 0.5 * setup.size) / 0.02))


@law("floor_tilt", "slope", most=4)
def slope(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A plane floor, tilted."""
    angle, way = 0.022 * s, float(rng.uniform(-np.pi, np.pi))
    pull = 9.81 * np.sin(angle)
    gx, gy = pull * np.cos(way), pull * np.sin(way)
    setup.gravity = (gx, gy)
    if setup.engine == "planar":
        mass = setup.body

        def act(_: float, state: Array, hook: Array) -> None:
            hook[FX] += mass["mass"] * gx
            hook[FY] += mass["mass"] * gy

        setup.hooks.append(act)
    return {"tilt_rad": angle, "downhill_rad": way}


@law("floor_tilt", "warped", FLAT, most=4)
def warped(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A tilted floor that also sags: the slope grows to one side by two fifths."""
    angle, way, turn = 0.022 * s, float(rng.uniform(-np.pi, np.pi)), float(rng.uniform(-np.pi, np.pi))
    mass, reach = setup.body, setup.reach

    def act(_: float, state: Array, hook: Array) -> None:
        here = 1.0 + 0.4 * np.clip((state[0] * np.cos(turn) + state[1] * np.sin(turn)) / reach, -1, 1)
        hook[FX] += mass["mass"] * 9.81 * angle * here * np.cos(way)
        hook[FY] += mass["mass"] * 9.81 * angle * here * np.sin(way)

    setup.hooks.append(act)
    return {"tilt_rad": angle, "downhill_rad": way}


@law("carpet_nap", "drift", BODIES, most=5)
def nap_drift(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Tips of the pile bend under a turning wheel: the robot is carried along the nap at a share of its speed."""
    share, way = 0.03 * s, float(rng.uniform(-np.pi, np.pi))

    def act(_: float, state: Array, hook: Array) -> None:
        speed = np.hypot(state[3], state[4])
        hook[FLOOR_X] += share * speed * np.cos(way)
        hook[FLOOR_Y] += share * speed * np.sin(way)

    setup.hooks.append(act)
    return {"drift_share": share, "nap_rad": way}


@law("carpet_nap", "pull", most=5)
def nap_pull(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The pile pulls a moving robot along the nap with a force that is a share of its weight."""
    share, way = 0.025 * s, float(rng.uniform(-np.pi, np.pi))
    force = share * setup.weight

    def act(_: float, state: Array, hook: Array) -> None:
        on = moving(state)
        hook[FX] += force * np.cos(way) * on
        hook[FY] += force * np.sin(way) * on

    setup.hooks.append(act)
    return {"pull_share": share, "nap_rad": way}


@law("carpet_nap", "directional_drag", most=5)
def nap_drag(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Rolling resistance by direction: low along the nap, high against it, between across (elliptic)."""
    share, way = 0.05 * s, float(rng.uniform(-np.pi, np.pi))
    force = share * setup.weight

    def act(_: float, state: Array, hook: Array) -> None:
        speed = np.hypot(state[3], state[4])
        if speed < 1e-6:
            return
        against = 0.5 * (1.0 - (state[3] * np.cos(way) + state[4] * np.sin(way)) / speed)
        drag = force * against**1.5 * np.tanh(speed / 0.02)
        hook[FX] -= drag * state[3] / speed
        hook[FY] -= drag * state[4] / speed

    setup.hooks.append(act)
    return {"drag_share": share, "nap_rad": way}


def at_wheels(setup: Setup, state: Array) -> tuple[float, float, float]:
    """Return how deep the left wheel, the right wheel and the caster stand in the place."""
    place = setup.place
    if place is None:
        return 0.0, 0.0, 0.0
    x, y, c, s = state[0], state[1], np.cos(state[2]), np.sin(state[2])
    half, arm = 0.5 * setup.body["axle"], setup.body["caster_x"]
    return (
        place.inside(x - s * half, y + c * half),
        place.inside(x + s * half, y - c * half),
        place.inside(x + c * arm, y + s * arm),
    )


@law("rough_floor_patch", "rolling", BODIES, most=5)
def rough_rolling(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Carpet or sand: a larger coefficient of rolling resistance under each wheel that stands in it."""
    c = 0.10 * s

    def act(_: float, state: Array, hook: Array) -> None:
        left, right, caster = at_wheels(setup, state)
        hook[DRAG_L] += c * left
        hook[DRAG_R] += c * right
        hook[DRAG_C] += c * caster

    setup.hooks.append(act)
    return {"rolling": c}


def drag_at(setup: Setup, state: Array, hook: Array, force: float, law_of_speed) -> None:
    """Add a force against the velocity of each wheel's contact in the place; `law_of_speed(v)` in [0, 1]."""
    half = 0.5 * setup.body["axle"]
    along = state[3] * np.cos(state[2]) + state[4] * np.sin(state[2])
    for depth, y in zip(at_wheels(setup, state)[:2], (half, -half)):
        v = along - state[5] * y
        push = -0.5 * force * depth * law_of_speed(v)
        hook[FX] += push * np.cos(state[2])
        hook[FY] += push * np.sin(state[2])
        hook[MZ] -= y * push


@law("rough_floor_patch", "grass", PUSHED, most=5)
def rough_grass(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Tall pile: drag grows with speed."""
    c = 0.16 * s
    setup.hooks.append(
        lambda _, state, hook: drag_at(
            setup, state, hook, c * setup.weight, lambda v: np.clip(v / setup.speed, -1, 1)
        )
    )
    return {"rolling": c}


@law("rough_floor_patch", "bumps", PUSHED, most=5)
def rough_bumps(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Gravel: a mean drag with a random part over every few centimetres of way."""
    c = 0.10 * s
    bumps = rng.normal(1.0, 0.8, (64, 64))

    def act(_: float, state: Array, hook: Array) -> None:
        cell = bumps[int(state[0] / (0.2 * setup.size)) % 64, int(state[1] / (0.2 * setup.size)) % 64]
        drag_at(setup, state, hook, c * setup.weight * cell, lambda v: np.tanh(v / 0.02))

    setup.hooks.append(act)
    return {"rolling": c}


def grip(setup: Setup, act_left) -> None:
    """Let each wheel's grip fall by `act_left(depth, speed)`."""

    def act(_: float, state: Array, hook: Array) -> None:
        left, right, _c = at_wheels(setup, state)
        speed = np.hypot(state[3], state[4])
        hook[MU_L] *= act_left(left, speed)
        hook[MU_R] *= act_left(right, speed)

    setup.hooks.append(act)


@law("low_friction_patch", "slippery", most=3.5)
def slippery(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Wet or polished: the coefficient of friction is a fraction."""
    k = max(0.6 * float(np.exp(-s)), 0.015)
    grip(setup, lambda depth, _: 1.0 - (1.0 - k) * depth)
    return {"friction_factor": k, "friction": k * setup.body["friction"]}


@law("low_friction_patch", "film", most=3.5)
def film(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """An oil film: friction falls with speed as the film builds up (Stribeck's mixed regime)."""
    k, v0 = max(0.6 * float(np.exp(-s)), 0.015), 0.25 * setup.speed
    grip(setup, lambda depth, v: 1.0 - (1.0 - k - 0.10 * np.exp(-v / v0)) * depth)
    return {"friction_factor": k + 0.05, "friction": (k + 0.05) * setup.body["friction"]}


@law("low_friction_patch", "dust", FLAT, most=3.5)
def dust(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Loose dust: it shears far before it holds, and holds less."""
    k = max(0.6 * float(np.exp(-s)), 0.015)

    def act(_: float, state: Array, hook: Array) -> None:
        left, right, _c = at_wheels(setup, state)
        hook[MU_L] *= 1.0 - (1.0 - k) * left
        hook[MU_R] *= 1.0 - (1.0 - k) * right
        hook[SLACK_L] *= 1.0 - 0.6 * left
        hook[SLACK_R] *= 1.0 - 0.6 * right

    setup.hooks.append(act)
    return {"friction_factor": k, "friction": k * setup.body["friction"]}


def shove(setup: Setup, start: float, span: float, shape, force: float, way: float, arm: float) -> None:
    """Push with `force * shape(share gone)` [N] towards `way` [rad, world], `arm` [m] off the centre."""

    def act(t: float, state: Array, hook: Array) -> None:
        if start <= t < start + span:
            now = force * shape((t - start) / span)
            hook[FX] += now * np.cos(way)
            hook[FY] += now * np.sin(way)
            hook[MZ] += now * arm

    setup.hooks.append(act)


@law("external_push", "bump", timed=True, most=8)
def bump(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Somebody's foot: a half sine of a quarter second."""
    force, way = 0.9 * s * setup.weight, float(rng.uniform(-np.pi, np.pi))
    arm, span = float(rng.uniform(-0.4, 0.4)) * setup.size, float(rng.uniform(0.15, 0.35))
    if setup.window:
        shove(setup, setup.window[0], span, lambda share: np.sin(np.pi * share), force, way, arm)
    return {"force_N": force, "seconds": span, "way_rad": way, "arm_m": arm, "when": setup.window}


@law("external_push", "hand", timed=True, most=8)
def hand(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A hand leans on it for one to three seconds: ramp, hold, ramp."""
    force, way = 0.5 * s * setup.weight, float(rng.uniform(-np.pi, np.pi))
    arm, span = float(rng.uniform(-0.4, 0.4)) * setup.size, float(rng.uniform(1.0, 3.0))
    if setup.window:
        shove(
            setup, setup.window[0], span, lambda share: min(1.0, 5 * share, 5 * (1 - share)), force, way, arm
        )
    return {"force_N": force, "seconds": span, "way_rad": way, "arm_m": arm, "when": setup.window}


@law("external_push", "twist", timed=True, most=8)
def twist(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Somebody turns it: a moment of half a second."""
    moment, span = (
        float(rng.choice([-1, 1])) * 0.35 * s * setup.weight * setup.size,
        float(rng.uniform(0.3, 0.8)),
    )
    window = setup.window

    def act(t: float, state: Array, hook: Array) -> None:
        if window and window[0] <= t < window[0] + span:
            hook[MZ] += moment * np.sin(np.pi * (t - window[0]) / span)

    setup.hooks.append(act)
    return {"moment_N_m": moment, "seconds": span, "when": window}
