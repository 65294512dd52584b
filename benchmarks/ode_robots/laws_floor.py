"""Floors: slopes, carpets, slippery and rough places."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.ode_robots.engine import GRAVITY
from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.ode_robots.machine import Machine, Now


def _places(draw: Draw, share: float, edge: float) -> Callable[[float, float], float]:
    """Return how far a point is inside one of the two places, 0 to 1, with edges of a share of their size."""
    r = share * draw.area
    spots = draw.spots

    def within(x: float, y: float) -> float:
        d = min(math.hypot(x - a, y - b) for a, b in spots)
        return min(max((r - d) / (edge * r) + 0.5, 0.0), 1.0)

    return within


def _strip(draw: Draw, share: float) -> Callable[[float, float], float]:
    """Return how far a point is inside a strip through the first place."""
    at, half = draw.between(5, 0.0, math.pi), share * draw.area
    (x0, y0), c, s = draw.spots[0], math.cos(at), math.sin(at)

    def within(x: float, y: float) -> float:
        d = abs(c * (y - y0) - s * (x - x0))
        return min(max((half - d) / (0.3 * half) + 0.5, 0.0), 1.0)

    return within


def _felt_by_wheels(
    setup: Setup, within: Callable[[float, float], float], act: Callable[[Machine, Now, int, float], None]
) -> None:
    """Let a place act on each wheel by how far it is inside (`_places`, `_strip`)."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                w = within(*now.spots[side])
                if w > 0.0:
                    act(machine, now, side, w)
                    now.touched = now.touched or w > 0.3

        return hook

    setup.floor.append(make)


@law(
    "carpet_nap",
    "share of way",
    0.001,
    0.2,
    "tufted carpet: leaning pile rolls under the wheels and carries them",
)
def pile_carries(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The surface under a rolling wheel creeps along the nap, by a share of the way rolled."""
    nap = draw.between(0, -math.pi, math.pi)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            c, s = math.cos(nap - now.yaw), math.sin(nap - now.yaw)
            for side in (0, 1):
                v = size * abs(now.rate[side]) * machine.middle
                now.drift[side] = (v * c, v * s)

        return hook

    setup.floor.append(make)
    return {"share": size, "nap_rad": nap}


@law(
    "carpet_nap",
    "share of weight",
    0.002,
    0.5,
    "brushed pile: against the nap it stands up and holds, along it lies down",
)
def pile_stands_up(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Rolling resistance is high against the nap and low along it; across, pile pushes to its side."""
    nap = draw.between(0, -math.pi, math.pi)
    weight = setup.plant.mass * GRAVITY

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            way = math.tanh(now.speed / 0.02)
            along = math.cos(now.yaw - nap) * (1.0 if way >= 0.0 else -1.0)
            for side in (0, 1):
                now.dry[side] += 0.5 * weight * machine.middle * size * (0.5 - 0.5 * along) ** 2

        return hook

    def push(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            f = 0.3 * size * weight * abs(math.sin(now.yaw - nap)) * math.tanh(abs(now.speed) / 0.05)
            now.force[0] += f * math.cos(nap)
            now.force[1] += f * math.sin(nap)

        return hook

    setup.floor.append(make)
    setup.body.append(push)
    return {"against": size, "aside": 0.3 * size, "nap_rad": nap}


@law(
    "carpet_nap",
    "share of weight",
    0.001,
    0.5,
    "ribbed sisal: wheels roll into the furrows and turn along them",
)
def ribs_steer(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Rolling at an angle to the ribs, the robot is pushed to them and turned along them."""
    rib = draw.between(0, 0.0, math.pi)
    weight, axle = setup.plant.mass * GRAVITY, setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            rolls = math.tanh(abs(now.speed) / 0.03)
            f = size * weight * rolls * math.sin(2.0 * (rib - now.yaw))
            back = 0.5 * size * weight * rolls * math.sin(now.yaw - rib) ** 2 * math.tanh(now.speed / 0.03)
            now.force[0] += -f * now.s * 0.5 - back * now.c
            now.force[1] += f * now.c * 0.5 - back * now.s
            now.force[2] += 0.35 * axle * f

        return hook

    setup.body.append(make)
    return {"steer": size, "rib_rad": rib}


@law("floor_tilt", "rad", 0.001, 0.15, "crowned floors and roads fall to both sides of a ridge")
def crowned(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Gravity leans away from a ridge beside the middle, the more the further off, up to a slope."""
    way, off = draw.between(0, -math.pi, math.pi), draw.between(1, 0.1, 0.6) * draw.area
    c, s, width = math.cos(way), math.sin(way), 0.8 * draw.area

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            slope = size * math.tanh((now.x * c + now.y * s + off) / width)
            now.slope = (slope * c, slope * s)

        return hook

    setup.floor.append(make)
    return {"slope_rad": size, "way_rad": way, "ridge_m": -off}


@law("floor_tilt", "rad", 0.001, 0.15, "wet rooms and garages fall to a drain")
def falls_to_a_drain(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The floor falls to a point off the middle with one slope, level right at the drain."""
    at, far = draw.between(0, -math.pi, math.pi), draw.between(1, 0.4, 1.3) * draw.area
    px, py = far * math.cos(at), far * math.sin(at)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            dx, dy = px - now.x, py - now.y
            d = math.hypot(dx, dy) + 0.15 * draw.area
            now.slope = (size * dx / d, size * dy / d)

        return hook

    setup.floor.append(make)
    return {"slope_rad": size, "drain_x": px, "drain_y": py}


@law(
    "floor_tilt",
    "rad",
    0.001,
    0.15,
    "raised-floor panels, each level in itself by a little less than its neighbours",
)
def uneven_panels(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A common slope and panels of 0.6 area's radius, each with a slope of its own, joined within some cm."""
    way, pitch = draw.between(0, -math.pi, math.pi), 0.6 * draw.area
    common = (0.8 * size * math.cos(way), 0.8 * size * math.sin(way))
    own = np.random.default_rng(draw.seed).normal(0.0, 0.45 * size, (12, 12, 2)).tolist()

    def make(machine: Machine, run: int) -> Hook:
        state = [0.0, 0.0]

        def hook(now: Now) -> None:
            row = own[math.floor(now.x / pitch) % 12][math.floor(now.y / pitch) % 12]
            for k in (0, 1):
                state[k] += (common[k] + row[k] - state[k]) * min(now.step / 0.1, 1.0)
            now.slope = (state[0], state[1])

        return hook

    setup.floor.append(make)
    return {"common_rad": 0.8 * size, "own_rad": 0.45 * size, "way_rad": way, "panel_m": pitch}


@law("low_friction_patch", "1/share", 1.5, 600.0, "spilt oil: grip falls to a boundary film's", local=True)
def oil_puddles(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Two puddles in which the grip of each wheel falls towards a share, with soft rims."""

    def act(machine: Machine, now: Now, side: int, w: float) -> None:
        now.grip[side] = size**-w

    _felt_by_wheels(setup, _places(draw, 0.26, 0.5), act)
    return {"grip": 1.0 / size, "radius_m": 0.26 * draw.area}


@law(
    "low_friction_patch",
    "m/s per load",
    0.02,
    60.0,
    "a loose sheet or shallow water: the wheel drags a film",
    local=True,
)
def wet_strip(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A strip where the tyres slip in proportion to what they push, at half their grip."""

    def act(machine: Machine, now: Now, side: int, w: float) -> None:
        now.film[side] = size * w
        now.grip[side] = 1.0 - 0.5 * w

    _felt_by_wheels(setup, _strip(draw, 0.2), act)
    return {"film": size, "half_width_m": 0.2 * draw.area}


@law(
    "rough_floor_patch",
    "share of load",
    0.0008,
    0.8,
    "gravel, door mats: resistance grows with speed",
    local=True,
)
def gravel(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Two places where each wheel's rolling resistance is a share of its load that grows with speed."""

    def act(machine: Machine, now: Now, side: int, w: float) -> None:
        v = abs(now.rate[side]) * machine.middle / machine.setup.robot.full
        now.dry[side] += size * w * (0.5 + v) * now.load[side] * machine.middle

    _felt_by_wheels(setup, _places(draw, 0.26, 0.3), act)
    return {"share": size, "radius_m": 0.26 * draw.area}


@law(
    "rough_floor_patch",
    "share of radius",
    0.0005,
    0.8,
    "foam mats: the floor's push moves ahead of the axle",
    local=True,
)
def foam_mat(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A strip where the contact lies ahead of a rolling wheel, as in foam that springs back late."""

    def act(machine: Machine, now: Now, side: int, w: float) -> None:
        rolls = math.tanh(now.rate[side] * machine.middle / 0.03)
        now.ahead[side] = size * w * machine.middle * rolls

    _felt_by_wheels(setup, _strip(draw, 0.2), act)
    return {"ahead": size, "half_width_m": 0.2 * draw.area}
