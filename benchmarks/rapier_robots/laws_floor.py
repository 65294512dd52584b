"""Laws of floors: slopes, carpets, mats and slippery places."""

from __future__ import annotations

import math
from dataclasses import replace

from benchmarks.rapier_robots.engine import GRAVITY
from benchmarks.rapier_robots.laws import Draw, law
from benchmarks.rapier_robots.setup import Setup, State


@law(
    "floor_tilt",
    "rad",
    0.001,
    0.2,
    "floors are level within 2 to 10 mm/m (DIN 18202), ramps and boards less",
    needs="duty",
)
def slope(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The whole floor slopes by `size` [rad]."""
    way = d.angle(0)
    s.plant = replace(s.plant, slope=(size * math.cos(way), size * math.sin(way)))
    return {"tilt_rad": size, "down_rad": way}


@law(
    "floor_tilt",
    "rad",
    0.001,
    0.3,
    "two boards that meet in a ridge or a ditch (stage floors, table leaves)",
    needs="duty",
)
def hinged_boards(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Either side of a line the floor slopes by `size` [rad] the other way."""
    way, weight = d.angle(0), s.plant.total * GRAVITY
    c, n, off = math.cos(way), math.sin(way), d.between(1, -0.25, 0.25) * d.area

    def hook(st: State) -> None:
        pull = weight * size * math.tanh((st.x * c + st.y * n - off) / 0.04) * d.sign(2)
        st.fx += pull * c
        st.fy += pull * n

    s.floors.append(lambda run: hook)
    return {"tilt_rad": size, "across_rad": way}


@law(
    "floor_tilt",
    "rad",
    0.002,
    0.3,
    "warped boards: slope goes up and down with the way (sawn timber standards on bow)",
    needs="duty",
)
def warped_boards(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Waves across the floor, of `size` [rad] at most, on top of half as much slope."""
    way, weight = d.angle(0), s.plant.total * GRAVITY
    c, n, wave, phase = math.cos(way), math.sin(way), d.between(1, 0.9, 1.6) * d.area, d.angle(2)

    def hook(st: State) -> None:
        along = st.x * c + st.y * n
        pull = weight * size * (0.5 + math.sin(2.0 * math.pi * along / wave + phase))
        st.fx += pull * c
        st.fy += pull * n

    s.floors.append(lambda run: hook)
    return {"tilt_rad": size, "across_rad": way, "wave_m": wave}


@law(
    "carpet_nap",
    "1",
    0.002,
    0.6,
    "pile catches what rolls against its lean (carpet friction tests along and against)",
    needs="duty",
)
def fibre_ratchet(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Rolling drag of 0 with the pile to `size` of the load against it."""
    lean = d.angle(0)
    drag = [0.5 * size * s.plant.wheel_load * s.plant.radius[k] for k in (0, 1)]

    def hook(st: State) -> None:
        with_it = math.cos(st.yaw - lean)
        for k in (0, 1):
            st.hold[k] += drag[k] * (1.0 - (with_it if st.rate[k] > 0 else -with_it))

    s.floors.append(lambda run: hook)
    return {"drag": size, "lean_rad": lean}


@law(
    "carpet_nap",
    "1",
    0.001,
    0.3,
    "stripes left by a vacuum cleaner: the pile leans to and fro (carpet care guides)",
    needs="duty",
)
def mown_stripes(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Stripes of pile push each wheel along their lean by `size` of its load, every second one the other way."""
    lean, wide, phase = d.angle(0), d.between(1, 0.25, 0.5) * d.area, d[2]
    c, n, axle = math.cos(lean), math.sin(lean), s.plant.axle
    push = size * 0.5 * s.plant.total * GRAVITY

    def hook(st: State) -> None:
        if abs(st.rate[0]) + abs(st.rate[1]) < 0.05:
            return
        for k in (0, 1):
            x, y = st.wheel(k, axle)
            f = push if math.floor((y * c - x * n) / wide + phase) % 2 == 0 else -0.5 * push
            st.fx += f * c
            st.fy += f * n
            st.tz += ((x - st.x) * n - (y - st.y) * c) * f

    s.floors.append(lambda run: hook)
    return {"push": size, "lean_rad": lean, "stripe_m": wide}


@law(
    "carpet_nap",
    "1",
    0.001,
    0.4,
    "bent fibres unload along their lean as wheels pass (drift on carpet, Borenstein)",
    needs="duty",
)
def springing_pile(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A moving robot is pushed along the lean by up to `size` of its weight, more when it is fast."""
    lean, weight = d.angle(0), s.plant.total * GRAVITY
    slow = 0.25 * s.robot.full_rate * s.plant.radius[0]

    def hook(st: State) -> None:
        v = abs(st.speed)
        push = size * weight * v / (v + slow)
        st.fx += push * math.cos(lean)
        st.fy += push * math.sin(lean)

    s.floors.append(lambda run: hook)
    return {"push": size, "lean_rad": lean}


@law(
    "rough_floor_patch",
    "1",
    0.01,
    1.0,
    "ribbed rubber mat: resistance comes rib by rib (wheel over step, Wong ch. 2)",
    local=True,
    needs="duty",
)
def ribbed_mat(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """On a square mat each wheel's rolling resistance swings between 0 and `size` of its load along the ribs."""
    (px, py), half, way = d.spots[0], d.between(0, 0.25, 0.4) * d.area, d.angle(1)
    c, n, axle, rib = math.cos(way), math.sin(way), s.plant.axle, d.between(2, 0.6, 1.2) * s.plant.radius[0]
    top = [size * s.plant.wheel_load * s.plant.radius[k] for k in (0, 1)]

    def hook(st: State) -> None:
        for k in (0, 1):
            x, y = st.wheel(k, axle)
            a, b = (x - px) * c + (y - py) * n, (y - py) * c - (x - px) * n
            if abs(a) < half and abs(b) < half:
                st.hold[k] += top[k] * (0.5 + 0.5 * math.sin(6.283 * a / rib))
                st.touched = True

    s.floors.append(lambda run: hook)
    return {"drag": size, "x_m": px, "y_m": py, "half_m": half, "rib_m": rib}


@law(
    "rough_floor_patch",
    "1",
    0.005,
    0.6,
    "thick rug: a wheel sinks in by its load, drag of several per cent (caster handbooks)",
    local=True,
    needs="duty",
)
def thick_rug(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """On a round rug rolling takes `size` of the load more, less near its thin rim."""
    (px, py), radius, axle = d.spots[0], d.between(0, 0.3, 0.45) * d.area, s.plant.axle
    top = [size * s.plant.wheel_load * s.plant.radius[k] for k in (0, 1)]

    def hook(st: State) -> None:
        for k in (0, 1):
            x, y = st.wheel(k, axle)
            away = math.hypot(x - px, y - py)
            if away < radius:
                st.hold[k] += top[k] * min(5.0 * (1.0 - away / radius), 1.0)
                st.touched = True

    s.floors.append(lambda run: hook)
    return {"drag": size, "x_m": px, "y_m": py, "radius_m": radius}


@law(
    "low_friction_patch",
    "1",
    1.0,
    400.0,
    "dust under rubber: friction falls to a tenth (tribology of dusty floors)",
    local=True,
)
def dust_film(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Within a disc the tyres' friction is divided by `size`, softer at its rim."""
    (px, py), radius, axle = d.spots[0], d.between(0, 0.35, 0.55) * d.area, s.plant.axle

    def hook(st: State) -> None:
        for k in (0, 1):
            x, y = st.wheel(k, axle)
            deep = min(4.0 * (1.0 - math.hypot(x - px, y - py) / radius), 1.0)
            if deep > 0.0:
                st.grip[k] *= size**-deep
                st.touched = True

    s.floors.append(lambda run: hook)
    return {"grip": s.plant.grip[0] / size, "x_m": px, "y_m": py, "radius_m": radius}


@law(
    "low_friction_patch",
    "1",
    1.0,
    400.0,
    "a wet strip: the film carries more the faster it is crossed (Stribeck curve)",
    local=True,
)
def wet_strip(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Across a strip friction is divided by `size`, and at speed by up to twice as much."""
    (px, py), half, way = d.spots[0], d.between(0, 0.22, 0.35) * d.area, d.angle(1)
    c, n, axle, fast = math.cos(way), math.sin(way), s.plant.axle, 0.5 * s.robot.full_rate * s.plant.radius[0]

    def hook(st: State) -> None:
        for k in (0, 1):
            x, y = st.wheel(k, axle)
            if abs((x - px) * c + (y - py) * n) < half:
                st.grip[k] /= size * (1.0 + min(abs(st.speed) / fast, 1.0))
                st.touched = True

    s.floors.append(lambda run: hook)
    return {"grip": s.plant.grip[0] / size, "x_m": px, "y_m": py, "half_m": half}
