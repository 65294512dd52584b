"""Laws of the body: third points that drag, loads, wheels that are not round."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw


@law(
    "caster_drag",
    "hair_in_the_fork",
    (0.02, 5.0),
    "1",
    "hair around pivot and axle of a swivelling wheel: it drags, and kicks as it turns over (owners' forums)",
    needs=("fork",),
)
def hair_in_the_fork(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    lever = size * 0.6 * setup.plant.third.trail

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.third[1] += 0.35 * size
            now.third[2] += lever

        return hook

    setup.body.append(make)
    return {"rolling": 0.35 * size, "pivot_m": lever}


@law(
    "caster_drag",
    "shopping_cart_wheel",
    (0.02, 6.0),
    "1",
    "a worn swivel: the wheel runs easily along and scrubs while its fork stands across, as a "
    "shopping cart's does",
    needs=("fork",),
)
def shopping_cart_wheel(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    trail = setup.plant.third.trail

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            across = math.sin(float(now.swing[0])) ** 2
            now.third[1] += size * (0.15 + 0.85 * across)
            now.third[2] += 0.3 * size * trail

        return hook

    setup.body.append(make)
    return {"across": size}


@law(
    "caster_drag",
    "lint_in_the_socket",
    (0.05, 4.0),
    "1",
    "lint jams a ball in its socket, or a glide's felt is gone: it slides, and sticks more before it moves",
    needs=("slider",),
)
def lint_in_the_socket(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    x = setup.plant.third.x

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            v, aside, turn = now.motion
            speed = math.hypot(float(v), float(aside + turn * x))
            now.third[0] += size * (1.0 + 0.5 * math.exp(-speed / 0.03))

        return hook

    setup.body.append(make)
    return {"friction": size}


@law(
    "caster_drag",
    "dented_ball",
    (0.02, 8.0),
    "1",
    "a dented ball catches on the floor: its friction comes and goes with the way it slides",
    needs=("slider",),
)
def dented_ball(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    length = draw.between(0, 0.03, 0.09)

    def make(machine: Machine, run: int) -> Hook:
        way = [0.0]

        def hook(now: Now) -> None:
            v, aside, turn = now.motion
            way[0] += math.hypot(float(v), float(aside + turn * setup.plant.third.x)) * now.step
            now.third[0] += size * (0.5 + 0.5 * math.sin(2.0 * math.pi * way[0] / length)) ** 2

        return hook

    setup.body.append(make)
    return {"most_friction": size, "length_m": length}


def _direction(draw: Draw) -> tuple[float, float]:
    """Return ahead, behind, or aside, and a little askew."""
    base = (0.0, math.pi, 0.5 * math.pi, -0.5 * math.pi)[int(4 * draw.numbers[0]) % 4]
    angle = base + draw.between(1, -0.4, 0.4)
    return math.cos(angle), math.sin(angle)


@law(
    "payload_offset",
    "crate_on_deck",
    (0.004, 0.42),
    "1",
    "a crate is strapped on away from the axle: mass, centre of mass and inertia of two bodies "
    "(parallel axes)",
)
def crate_on_deck(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    p = setup.plant
    crate = draw.between(2, 0.35, 0.8) * p.mass
    cx, cy = _direction(draw)
    shift = size * p.axle
    far = shift * (p.mass + crate) / crate
    at = (p.centre[0] + cx * far, p.centre[1] + cy * far)
    whole = p.mass + crate
    centre = tuple((p.mass * a + crate * b) / whole for a, b in zip(p.centre[:2], at))
    own = crate * 0.02 * p.axle**2
    inertia = p.inertia + own + crate * (at[0] ** 2 + at[1] ** 2)
    height = (p.mass * p.centre[2] + crate * 1.4 * p.centre[2]) / whole
    setup.plant = replace(p, mass=whole, inertia=inertia, centre=(centre[0], centre[1], height))
    return {"mass_kg": crate, "x_m": at[0], "y_m": at[1], "centre_x": centre[0], "centre_y": centre[1]}


@law(
    "payload_offset",
    "shifted_battery",
    (0.004, 0.42),
    "1",
    "the heavy battery sits at one end of its bay: the centre of mass moves, the mass stays",
)
def shifted_battery(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    p = setup.plant
    cx, cy = _direction(draw)
    x, y = p.centre[0] + cx * size * p.axle, p.centre[1] + cy * size * p.axle
    about = p.inertia - p.mass * (p.centre[0] ** 2 + p.centre[1] ** 2)
    setup.plant = replace(p, inertia=about + p.mass * (x * x + y * y), centre=(x, y, p.centre[2]))
    return {"centre_x": x, "centre_y": y}


def _unround(
    setup: Setup, draw: Draw, size: float, shape: Callable[[float], tuple[float, float]]
) -> dict[str, float]:
    """Let `shape(angle)` (radius, its slope) of one or both wheels follow the angle; the load leans on the
    slope.
    """
    both = draw.numbers[0] < 0.4
    which = (0, 1) if both else ((0,) if draw.numbers[0] < 0.7 else (1,))
    phases = (draw.between(1, 0.0, 2.0 * math.pi), draw.between(2, 0.0, 2.0 * math.pi))

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in which:
                more, slope = shape(float(now.angle[k]) + phases[k])
                now.torque[k] -= now.load[k] * slope * float(now.radius[k])
                now.radius[k] *= 1.0 + more

        return hook

    setup.body.append(make)
    return {"share": size, "left": float(0 in which), "right": float(1 in which)}


@law(
    "wheel_eccentricity",
    "bore_off_centre",
    (0.001, 0.4),
    "1",
    "the bore is off the rim's centre: the rolling radius and the climb of the hub follow the wheel's angle",
)
def bore_off_centre(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    told = _unround(setup, draw, size, lambda a: (size * math.cos(a), -size * math.sin(a)))
    return told | {"offset_m": size * setup.plant.radius[0]}


@law(
    "wheel_eccentricity",
    "oval_rim",
    (0.001, 0.4),
    "1",
    "a printed or bent rim is oval: two crests in a turn",
)
def oval_rim(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    told = _unround(setup, draw, size, lambda a: (size * math.cos(2 * a), -2.0 * size * math.sin(2 * a)))
    return told | {"half_difference_m": size * setup.plant.radius[0]}
