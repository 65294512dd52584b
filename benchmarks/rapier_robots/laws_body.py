"""Laws of wheels, tyres, casters and loads."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.rapier_robots.engine import GRAVITY, STEP
from benchmarks.rapier_robots.laws import Draw, law
from benchmarks.rapier_robots.laws_motor import bunches
from benchmarks.rapier_robots.plant import Plant
from benchmarks.rapier_robots.setup import FloorHook, Setup, State


@law(
    "wheel_eccentricity",
    "m",
    0.0002,
    0.012,
    "a hub bored off the centre of its rim (geometry; the engine's rim is off)",
)
def offset_hub(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One wheel's rim is `size` [m] off its axle."""
    side, radius = d.side(0), s.plant.radius[0]
    size = min(size, 0.3 * radius)
    s.plant = replace(
        s.plant, bore=(size if side == 0 else 0.0, size if side == 1 else 0.0), bore_at=(d.angle(1),) * 2
    )
    return {"offset_m": size, "wheel": float(side)}


def _bumps(s: Setup, size: float, d: Draw, shape: Callable[[float], float]) -> dict[str, float]:
    """Let one wheel's rim come nearer to its axle by `size` [m] times shape(angle that is below)."""
    side, start = d.side(0), d.angle(1)
    size = min(size, 0.25 * s.plant.radius[0])

    def hook(angle: float, k: int) -> tuple[float, float]:
        if k != side:
            return 0.0, 0.0
        up = size * shape(angle + start)
        return -math.sin(angle) * up, math.cos(angle) * up

    s.rims.append(lambda run: hook)
    return {"depth_m": size, "wheel": float(side)}


@law(
    "wheel_eccentricity",
    "m",
    0.0003,
    0.015,
    "flat spot of a foam tyre that stood under load (tyre makers on flat-spotting)",
)
def flat_spot(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One wheel is flat by `size` [m] over a quarter of its turn."""
    return _bumps(s, size, d, lambda a: max(0.0, 1.0 - abs(math.remainder(a, 2.0 * math.pi)) / 0.8))


@law(
    "wheel_eccentricity",
    "m",
    0.0003,
    0.015,
    "three-spoked moulded rims shrink between the spokes (injection moulding guides)",
)
def three_spokes(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One wheel's radius swings by `size` [m] once in a turn and by half of it three times."""
    return _bumps(s, size, d, lambda a: math.cos(a) + 0.5 * math.cos(3.0 * a))


@law(
    "caster_drag",
    "1",
    0.01,
    0.6,
    "plastic ball in a dry socket slides: 0.1 to 0.5 (caster makers' notes)",
    needs="ball duty",
)
def dry_socket(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The ball's friction coefficient is larger by `size`."""
    first, *rest = s.plant.casters
    s.plant = replace(s.plant, casters=(replace(first, friction=first.friction + size), *rest))
    return {"friction": size}


@law(
    "caster_drag",
    "1",
    0.02,
    0.8,
    "hair winds up around a caster as it goes (robot vacuum maintenance pages)",
    needs="ball duty",
)
def winding_hair(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Friction grows with the way up to `size`, half of it after some metres."""
    half = d.between(0, 2.0, 5.0) * s.robot.area

    def make(run: int) -> FloorHook:
        way = [0.0]

        def hook(st: State) -> None:
            way[0] += abs(st.speed) * STEP
            st.ball += size * way[0] / (way[0] + half)

        return hook

    s.floors.append(make)
    return {"friction": size, "half_m": half}


@law(
    "caster_drag",
    "1",
    0.02,
    0.9,
    "grit catches a ball in its socket again and again (ball transfer unit guides)",
    needs="ball",
)
def catching_ball(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """For some centimetres in each quarter of a metre the ball catches: friction more by `size`."""
    period, phase = d.between(0, 0.15, 0.35) * s.robot.area, d[1]

    def make(run: int) -> FloorHook:
        way = [phase * period]

        def hook(st: State) -> None:
            way[0] += (abs(st.speed) + 0.5 * s.plant.axle * abs(st.turn)) * STEP
            if way[0] % period < 0.4 * period:
                st.ball += size

        return hook

    s.floors.append(make)
    return {"friction": size, "period_m": period}


@law(
    "caster_drag",
    "1",
    0.02,
    3.0,
    "rusted swivel: friction torque of a pivot over load times trail (caster catalogues)",
    needs="fork",
)
def stiff_pivot(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The fork's pivot holds `size` of its load times its trail."""
    fork, *rest = s.plant.casters
    torque = size * 0.15 * s.plant.total * GRAVITY * fork.trail
    s.plant = replace(s.plant, casters=(replace(fork, pivot=fork.pivot + torque), *rest))
    return {"share": size, "torque_nm": torque}


@law(
    "tyre_scrub", "m", 0.0005, 0.06, "twin tyres rub in turns on the engine's own contacts (Gillespie, ch. 8)"
)
def twin_tyres(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Each wheel stands on two lines, `size` [m] either side of its middle."""
    size = min(size, 0.3 * s.plant.axle)
    s.plant = replace(s.plant, twin=(size, size))
    return {"half_width_m": size}


@law("tyre_scrub", "m", 0.0005, 0.4, "turning resistance of a track on hard ground, mu N l / 4 (Wong, ch. 6)")
def belt_track(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Belts of length `size` [m] turn on the floor; rolling ahead takes the sideways sliding away."""
    top = 0.25 * s.plant.grip[0] * s.plant.wheel_load * size * 2.0
    soft = 0.02 * s.robot.full_rate * s.plant.radius[0]

    def hook(st: State) -> None:
        side = 0.5 * size * st.turn
        st.tz -= top * side / math.sqrt(side * side + 0.09 * st.speed * st.speed + soft * soft)

    s.floors.append(lambda run: hook)
    return {"length_m": size}


@law(
    "lateral_slip",
    "1",
    0.01,
    3.0,
    "side slip of a rolling tyre goes with its side force (Pacejka, ch. 1, relaxation length)",
)
def rolling_creep(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Slip of `size` for a side force as large as the load, built up over a third of a radius."""
    load, length = 2.0 * s.plant.wheel_load, max(0.35 * s.plant.radius[0], 0.3 * size * s.plant.radius[0])

    def make(run: int) -> Callable[[State, float], float]:
        slip = [0.0]

        def creep(st: State, force: float) -> float:
            speed = abs(st.speed)
            goal = size * force / load
            slip[0] += (goal - slip[0]) * min(speed * STEP / length, 0.02)
            slip[0] = min(max(slip[0], -0.4), 0.4)
            return slip[0] * speed

        return creep

    s.creeps.append(make)
    return {"slope": size, "relaxation_m": length}


@law(
    "lateral_slip",
    "m/s",
    0.002,
    1.0,
    "rims with side rollers or a film of oil give like a damper (tribology, Couette flow)",
)
def oiled_sideways(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A side force as large as the load lets the wheels drift sideways at `size` [m/s]."""
    load = 2.0 * s.plant.wheel_load
    settle = max(0.04, 0.3 * size)

    def make(run: int) -> Callable[[State, float], float]:
        drift = [0.0]

        def creep(st: State, force: float) -> float:
            drift[0] += (size * force / load - drift[0]) * STEP / settle
            drift[0] = min(max(drift[0], -0.3), 0.3)
            return drift[0]

        return creep

    s.creeps.append(make)
    return {"drift": size, "settle_s": settle}


def loaded(plant: Plant, mass: float, at: tuple[float, float, float]) -> Plant:
    """Return a plant with a small load [kg] fixed at a place from the axle's middle [m]."""
    old, new = np.array(plant.com), np.array(at)
    total = plant.mass + mass
    centre = (plant.mass * old + mass * new) / total
    shift = new - old
    reduced = plant.mass * mass / total
    extra = reduced * (shift @ shift - shift**2)
    inertia = np.array(plant.inertia) + extra
    com = (float(centre[0]), float(centre[1]), float(centre[2]))
    return replace(
        plant, mass=total, com=com, inertia=(float(inertia[0]), float(inertia[1]), float(inertia[2]))
    )


@law(
    "payload_offset",
    "1",
    0.01,
    0.8,
    "a spare battery strapped to one side of the deck (rigid-body mechanics)",
    needs="duty",
)
def side_battery(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A block of `size` of the robot's mass to one side and behind, at deck height."""
    back = -s.plant.casters[0].x
    at = (
        -back * d.between(0, 0.25, 0.6),
        d.sign(1) * s.plant.axle * d.between(2, 0.25, 0.5),
        1.5 * s.plant.com[2],
    )
    s.plant = loaded(s.plant, size * s.plant.mass, at)
    return {"mass_kg": size * s.robot.plant.mass, "x_m": at[0], "y_m": at[1]}


@law(
    "payload_offset",
    "1",
    0.01,
    0.6,
    "a laptop on a high shelf: its weight moves between wheels and caster (vehicle dynamics)",
    needs="duty",
)
def top_shelf(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A load of `size` of the robot's mass high up and behind, a little to one side."""
    back = -s.plant.casters[0].x
    at = (
        -back * d.between(0, 0.35, 0.7),
        d.sign(1) * s.plant.axle * d.between(2, 0.05, 0.3),
        0.7 * s.plant.axle,
    )
    s.plant = loaded(s.plant, size * s.plant.mass, at)
    return {"mass_kg": size * s.robot.plant.mass, "x_m": at[0], "y_m": at[1]}


@law(
    "external_push",
    "1",
    0.02,
    1.5,
    "several shoves by feet: half sines of 0.15 to 0.4 s (impact of soft bodies)",
    local=True,
)
def several_shoves(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Five to seven shoves a run of `size` of the weight, from any side, off the middle."""
    weight, lever = s.plant.total * GRAVITY, 0.3 * s.plant.axle

    def make(run: int) -> FloorHook:
        rng = d.rng(run + 20)
        hits = [
            (a, min(b, a + 0.4), float(rng.uniform(0, 6.283)), float(rng.uniform(-1, 1)))
            for a, b in bunches(d, run, (5, 7), (0.15, 0.4))
        ]

        def hook(st: State) -> None:
            for a, b, way, arm in hits:
                if a <= st.t < b:
                    push = size * weight * math.sin(math.pi * (st.t - a) / (b - a))
                    st.fx += push * math.cos(way)
                    st.fy += push * math.sin(way)
                    st.tz += push * arm * lever
                    st.touched = True

        return hook

    s.floors.append(make)
    return {"push": size, "weight_n": weight}


@law("external_push", "1", 0.01, 0.8, "a child that leans on the robot repeatedly and lets go", local=True)
def leaning_hand(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Three to five times somebody leans from one side for 1.2 to 2.5 s; the push swells and fades."""
    weight, way, lever = s.plant.total * GRAVITY, d.angle(0), d.between(1, -0.4, 0.4) * s.plant.axle

    def make(run: int) -> FloorHook:
        spans = bunches(d, run, (3, 5), (1.2, 2.5))

        def hook(st: State) -> None:
            for a, b in spans:
                if a <= st.t < b:
                    push = size * weight * math.sin(math.pi * (st.t - a) / (b - a)) ** 2
                    st.fx += push * math.cos(way)
                    st.fy += push * math.sin(way)
                    st.tz += push * lever
                    st.touched = True

        return hook

    s.floors.append(make)
    return {"push": size, "weight_n": weight}
