"""Laws of the floor: nap, slopes, and places that are slippery or rough."""

from __future__ import annotations

import math
from collections.abc import Callable

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Pair, Setup
from benchmarks.robot_sets.laws import Draw

Where = Callable[[float, float], float]


@law(
    "carpet_nap",
    "leaning_pile",
    (0.0006, 0.6),
    "1",
    "the pile leans: wheels sink less along it than against it, and its fibres push along it",
)
def leaning_pile(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(0, -math.pi, math.pi)
    nap = (math.cos(at), math.sin(at))

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            nx, ny = now.to_body(*nap)
            for k in (0, 1):
                rim = float(now.rate[k] * now.radius[k])
                moving = min(abs(rim) / 0.02, 1.0)
                against = 1.0 - (nx if rim > 0.0 else -nx)
                now.roll[k] += 0.5 * size * against * moving
                push = 0.35 * size * float(now.load[k]) * moving
                now.push[0] += push * nx
                now.push[1] += push * ny
                now.push[2] -= float(now.track[k]) * push * nx

        return hook

    setup.floor.append(make)
    return {"share_of_load": size, "direction_rad": at}


@law(
    "carpet_nap",
    "creeping_fibres",
    (0.002, 0.5),
    "1",
    "fibres lay over under each wheel and carry it along the nap by a share of the way rolled (carpet "
    "drift of robot vacuums, iRobot, carpet drift estimation)",
)
def creeping_fibres(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(0, -math.pi, math.pi)
    nap = (math.cos(at), math.sin(at))

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            nx, ny = now.to_body(*nap)
            for k in (0, 1):
                drift = size * abs(float(now.rate[k] * now.radius[k]))
                now.floor_x[k] += drift * nx
                now.floor_y[k] += drift * ny

        return hook

    setup.floor.append(make)
    return {"drift_per_way": size, "direction_rad": at}


def _sloping(setup: Setup, slope: Callable[[float, float], Pair]) -> None:
    """Let gravity pull along the floor by `slope(x, y)` [m/s2]."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.slope[0], now.slope[1] = now.to_body(*slope(now.x, now.y))

        return hook

    setup.floor.append(make)


@law(
    "floor_tilt",
    "one_plane",
    (0.0005, 0.3),
    "rad",
    "a floor out of level, as measured with a long spirit level",
)
def one_plane(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(0, -math.pi, math.pi)
    pull = (9.81 * math.sin(size) * math.cos(at), 9.81 * math.sin(size) * math.sin(at))
    _sloping(setup, lambda x, y: pull)
    return {"tilt_rad": size, "downhill_rad": at}


@law(
    "floor_tilt",
    "towards_a_drain",
    (0.0005, 0.3),
    "rad",
    "a wash-room floor falls to its drain from all sides",
)
def towards_a_drain(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    far, at = draw.between(0, 0.6, 1.5) * draw.area, draw.between(1, -math.pi, math.pi)
    dx, dy, pull = far * math.cos(at), far * math.sin(at), 9.81 * math.sin(size)

    def slope(x: float, y: float) -> Pair:
        rx, ry = dx - x, dy - y
        length = math.hypot(rx, ry) + 0.1 * draw.area
        return pull * rx / length, pull * ry / length

    _sloping(setup, slope)
    return {"tilt_rad": size, "drain_x": dx, "drain_y": dy}


@law(
    "floor_tilt",
    "settled_slab",
    (0.0005, 0.3),
    "rad",
    "a slab has settled: its tilt grows from one side to the other",
)
def settled_slab(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(0, -math.pi, math.pi)
    c, s = math.cos(at), math.sin(at)

    def slope(x: float, y: float) -> Pair:
        pull = 9.81 * size * (1.0 + 0.6 * math.tanh((c * x + s * y) / draw.area))
        return pull * c, pull * s

    _sloping(setup, slope)
    return {"mean_tilt_rad": size, "downhill_rad": at}


def _disc(draw: Draw) -> tuple[Where, dict[str, float]]:
    """Return a round place with a soft edge that covers a busy spot, and its sizes."""
    (x0, y0), reach = draw.spots[0], draw.between(0, 0.3, 0.45) * draw.area

    def where(x: float, y: float) -> float:
        return min(max((reach - math.hypot(x - x0, y - y0)) / (0.1 * reach) + 0.5, 0.0), 1.0)

    return where, {"x_m": x0, "y_m": y0, "radius_m": reach}


def strip_of(draw: Draw) -> tuple[Where, dict[str, float]]:
    """Return a band across the floor through a busy spot, and its sizes."""
    (x0, y0), half = draw.spots[0], draw.between(0, 0.16, 0.28) * draw.area
    at = draw.between(1, 0.0, math.pi)
    c, s = math.cos(at), math.sin(at)

    def where(x: float, y: float) -> float:
        return min(max((half - abs(c * (y - y0) - s * (x - x0))) / (0.1 * half) + 0.5, 0.0), 1.0)

    return where, {"x_m": x0, "y_m": y0, "along_rad": at, "half_width_m": half}


def felt_by_wheels(now: Now, where: Where) -> tuple[float, float]:
    """Return how much left and right wheel stand in a place (0 to 1)."""
    s, c = math.sin(now.yaw), math.cos(now.yaw)
    left, right = (where(now.x - s * y, now.y + c * y) for y in (float(now.track[0]), float(now.track[1])))
    if left > 0.0 or right > 0.0:
        now.touched = True
    return left, right


def _slippery(setup: Setup, where: Where, size: float, dries: float = 0.0) -> None:
    """Divide the grip by 1 + size in a place; soles may carry it on and dry over a way [m]."""

    def make(machine: Machine, run: int) -> Hook:
        wet = [0.0, 0.0]

        def hook(now: Now) -> None:
            for k, there in enumerate(felt_by_wheels(now, where)):
                if dries:
                    way = abs(float(now.rate[k] * now.radius[k])) * now.step
                    wet[k] = max(wet[k] * (1.0 - way / dries), there)
                    there = wet[k]
                if there > 0.02:
                    now.touched = True
                    now.grip[k] /= 1.0 + size * there
                    now.along[k] /= 1.0 + 0.15 * size * there

        return hook

    setup.floor.append(make)


@law(
    "low_friction_patch",
    "oil_film",
    (0.3, 120.0),
    "1",
    "oil on a workshop floor: a film between tyre and floor (boundary lubrication)",
    local=True,
)
def oil_film(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = _disc(draw)
    _slippery(setup, where, size)
    return sizes | {"grip": setup.plant.grip / (1.0 + size)}


@law("low_friction_patch", "waxed_lane", (0.3, 120.0), "1", "a lane of the hall has been waxed", local=True)
def waxed_lane(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = strip_of(draw)
    _slippery(setup, where, size)
    return sizes | {"grip": setup.plant.grip / (1.0 + size)}


@law(
    "low_friction_patch",
    "puddle_and_wet_treads",
    (0.3, 120.0),
    "1",
    "a puddle: treads stay wet for a while after it and dry with the way rolled",
    local=True,
)
def puddle_and_wet_treads(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = _disc(draw)
    _slippery(setup, where, size, 0.15 * draw.area)
    return sizes | {"grip": setup.plant.grip / (1.0 + size), "dries_m": 0.15 * draw.area}


@law(
    "rough_floor_patch",
    "deep_rug",
    (0.001, 1.2),
    "1",
    "wheels sink into a rug and climb out of it all the time: rolling resistance in a place",
    local=True,
)
def deep_rug(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = _disc(draw)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k, there in enumerate(felt_by_wheels(now, where)):
                now.roll[k] += size * there

        return hook

    setup.floor.append(make)
    return sizes | {"rolling": size}


@law(
    "rough_floor_patch",
    "broken_tiles",
    (0.001, 1.2),
    "1",
    "a lane of broken tiles: each wheel meets its own steps, which brake it and lift a little load",
    local=True,
)
def broken_tiles(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = strip_of(draw)
    wave = 2.0 * math.pi / (1.1 * setup.plant.radius[0])

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            s, c = math.sin(now.yaw), math.cos(now.yaw)
            for k, there in enumerate(felt_by_wheels(now, where)):
                y = float(now.track[k])
                step = math.sin(wave * (now.x - s * y)) * math.sin(wave * (now.y + c * y) + 1.0)
                now.roll[k] += size * there * (0.7 + 1.2 * step * step)

        return hook

    setup.floor.append(make)
    return sizes | {"rolling": size}
