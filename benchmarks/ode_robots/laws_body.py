"""Casters, tyres, wheels and loads: as bodies and contacts of the engine."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.plant import Foot
from benchmarks.ode_robots.setup import Hook, Setup, Tyre
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now


def _lean(setup: Setup, draw: Draw) -> Foot:
    """Return the foot that the robot leans on."""
    return setup.plant.feet[0]


@law(
    "caster_drag",
    "share of load",
    0.02,
    8.0,
    "hair and dust in a ball caster's socket: the ball rubs as it turns",
)
def hairy_ball(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A ball in a socket: rolls with friction in it, and slides on the floor when that is too much."""
    foot = replace(_lean(setup, draw), kind="ball", friction=size)
    setup.plant = replace(setup.plant, feet=(foot, *setup.plant.feet[1:]))
    return {"socket": size}


@law(
    "caster_drag",
    "share of load",
    0.02,
    20.0,
    "a swivel with a dry bearing and a wheel with thread around its axle",
)
def tight_swivel(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A trailing fork whose pin and wheel rub; it turns over after each reversal."""
    trail = draw.between(0, 0.3, 0.6) * sum(setup.plant.radius) / 2
    foot = Foot(_lean(setup, draw).x, 0.0, 0.25 * size, kind="fork", trail=trail, swivel=size)
    setup.plant = replace(setup.plant, feet=(foot, *setup.plant.feet[1:]))
    return {"swivel": size, "wheel": 0.25 * size, "trail_m": trail}


@law("caster_drag", "share of load", 0.03, 2.5, "felt glides under the tail instead of a caster")
def felt_glides(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Two glides side by side, one of them rougher, that slide on the floor."""
    foot, aside = _lean(setup, draw), draw.between(0, 0.15, 0.35) * setup.plant.axle
    rough = draw.between(1, 0.6, 1.4)
    left = Foot(foot.x, aside, size * rough)
    right = Foot(foot.x, -aside, size * (2.0 - rough))
    setup.plant = replace(setup.plant, feet=(left, right, *setup.plant.feet[1:]))
    return {"left": left.friction, "right": right.friction, "aside_m": aside}


def _across(setup: Setup, size: float, law_of: str) -> None:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                v = abs(now.rate[side]) * machine.middle
                if law_of == "sidewall":
                    now.yielding_across[side] = size * (1.0 + v / machine.setup.robot.full)
                elif law_of == "viscous":
                    now.yielding_across[side] = size * 0.5 * machine.setup.robot.full / (0.02 + v)
                else:
                    now.grip_across[side] = 1.0 / size

        return hook

    setup.floor.append(make)


@law(
    "lateral_slip",
    "times",
    1.3,
    20000.0,
    "soft sidewalls: cornering stiffness falls with speed (Pacejka 2006)",
)
def soft_sidewalls(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Slip angles are many times those of the hard tyre, more at speed."""
    _across(setup, size, "sidewall")
    return {"creep": size}


@law(
    "lateral_slip",
    "times",
    1.3,
    800.0,
    "greasy tyres on vinyl: a viscous film sideways, whether rolling or not",
)
def film_sideways(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A speed sideways in proportion to the force, at any rolling speed."""
    _across(setup, size, "viscous")
    return {"creep_at_half_speed": size}


@law("lateral_slip", "1/share", 2.0, 400.0, "grooved hard wheels hold along and slide across")
def slides_across(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Friction across the wheels is a small share of that along."""
    _across(setup, size, "grip")
    return {"grip_across": 1.0 / size}


def _box(machine: Machine, mass: float, place: tuple[float, float, float], edge: float) -> Any:
    inertia = mass * edge**2 / 6.0
    return machine.world.body(machine.at(*place), machine.start[2], mass, (inertia, inertia, inertia))


@law("payload_offset", "share of mass", 0.02, 1.2, "a crate strapped on off the middle: a body of its own")
def strapped_crate(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A crate fixed off the middle, on the robot's deck."""
    axle, r = setup.plant.axle, sum(setup.plant.radius) / 2
    place = (-draw.between(0, 0.1, 0.35) * axle, draw.between(1, 0.12, 0.35) * axle * draw.sign(2), 0.6 * r)

    def make(machine: Machine, run: int) -> Hook | None:
        crate = _box(machine, size * setup.plant.mass, place, 0.3 * axle)
        machine.world.fix(crate, machine.chassis)
        return None

    setup.body.append(make)
    return {"mass_kg": size * setup.plant.mass, "x": place[0], "y": place[1], "z": place[2]}


@law(
    "payload_offset",
    "share of mass",
    0.02,
    1.0,
    "a bag hung from a hook at the side, which swings and is damped",
)
def hanging_bag(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A bag on a ball joint below a hook off the middle; cloth damps its swing."""
    axle, r = setup.plant.axle, sum(setup.plant.radius) / 2
    hook_at = (-draw.between(0, 0.1, 0.4) * axle, draw.between(1, 0.2, 0.4) * axle * draw.sign(2), 1.5 * r)
    low = draw.between(3, 0.6, 1.4) * r

    def make(machine: Machine, run: int) -> Hook:
        mass = size * setup.plant.mass
        place = (hook_at[0], hook_at[1], hook_at[2] - low)
        bag = _box(machine, mass, place, low)
        machine.world.ball(bag, machine.chassis, machine.at(*hook_at))
        damp = 0.4 * mass * low**2 * math.sqrt(9.81 / low)

        def swing(now: Now) -> None:
            moment = (bag.getAngularVel() - machine.spin) * -damp
            bag.addTorque(moment)
            machine.chassis.addTorque(-moment)

        return swing

    setup.body.append(make)
    return {"mass_kg": size * setup.plant.mass, "x": hook_at[0], "y": hook_at[1], "length_m": low}


@law(
    "payload_offset",
    "share of mass",
    0.01,
    0.6,
    "an arm or a boom stretched out to the back, with a gripper at its end",
)
def long_arm(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A small mass far behind and aside: little weight, much inertia."""
    axle, r = setup.plant.axle, sum(setup.plant.radius) / 2
    place = (-draw.between(0, 0.5, 0.9) * axle, draw.between(1, -0.5, 0.5) * axle, 1.2 * r)

    def make(machine: Machine, run: int) -> Hook | None:
        machine.world.fix(_box(machine, size * setup.plant.mass, place, 0.1 * axle), machine.chassis)
        return None

    setup.body.append(make)
    return {"mass_kg": size * setup.plant.mass, "x": place[0], "y": place[1], "z": place[2]}


@law("tyre_scrub", "share of axle", 0.001, 0.9, "twin tyres on one hub: each wants its own speed in a turn")
def twin_tyres(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Each wheel stands on two treads side by side, with the engine's own friction at both."""
    b = size * setup.plant.axle
    setup.tyres = [replace(t, tracks=(-0.5 * b, 0.5 * b)) for t in setup.tyres]
    return {"apart_m": b}


@law(
    "tyre_scrub",
    "share of axle",
    0.02,
    0.9,
    "low-pressure tyres: the whole patch drills on the floor as it turns",
)
def drilling_patch(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Three treads across a wide, soft tyre, and the drilling of the patch's length."""
    b = size * setup.plant.axle
    setup.tyres = [replace(t, tracks=(-0.5 * b, 0.0, 0.5 * b)) for t in setup.tyres]

    def make(machine: Machine, run: int) -> Hook:
        most = 2.0 * machine.load * machine.plant.friction * 0.1 * b

        def hook(now: Now) -> None:
            reach = 0.2 * abs(now.speed) / machine.middle + 0.1  # rolling on renews the patch
            now.force[2] -= most * math.tanh(now.turn / reach)

        return hook

    setup.body.append(make)
    return {"width_m": b, "patch_m": 0.1 * b}


def _sides(draw: Draw) -> tuple[float, float]:
    """Return the shares of an effect on left and right: mostly one of them."""
    return (1.0, 0.4) if draw.numbers[0] < 0.5 else (0.4, 1.0)


@law(
    "wheel_eccentricity",
    "share of radius",
    0.004,
    0.4,
    "hubs bored off the middle: the real geometry, unlike phases",
)
def bored_off_centre(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Each tread is a circle about a point beside its hinge."""
    hubs: list[tuple[float, float]] = []
    told: dict[str, float] = {}
    for side, share in enumerate(_sides(draw)):
        off, at = size * share * setup.plant.radius[side], draw.between(1 + side, 0.0, 2 * math.pi)
        hubs.append((off * math.cos(at), off * math.sin(at)))
        told |= {f"off_{'lr'[side]}_m": off, f"at_{'lr'[side]}_rad": at}
    setup.tyres = [replace(t, hub=hub) for t, hub in zip(setup.tyres, hubs)]
    return told


def _shaped(tyre: Tyre, off: float, at: float, lobes: int) -> Tyre:
    def oval(angle: float) -> float:
        return off * math.cos(lobes * (angle - at))

    def flat(angle: float) -> float:
        d = math.remainder(angle - at, 2.0 * math.pi)
        return -off * math.exp(-((d / 0.5) ** 2))

    return replace(tyre, shape=oval if lobes else flat)


@law("wheel_eccentricity", "share of radius", 0.004, 0.4, "tyres stretched on by hand stand oval")
def oval_tread(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The radius has two lobes, or three; most on one wheel."""
    lobes = 2 if draw.numbers[3] < 0.7 else 3
    offs = [size * share * r for share, r in zip(_sides(draw), setup.plant.radius)]
    at = [draw.between(1, 0.0, 3.0), draw.between(2, 0.0, 3.0)]
    setup.tyres = [_shaped(t, o, a, lobes) for t, o, a in zip(setup.tyres, offs, at)]
    return {"left_m": offs[0], "right_m": offs[1], "lobes": float(lobes)}


@law("wheel_eccentricity", "share of radius", 0.01, 0.5, "foam tyres that stood for long have a flat spot")
def flat_spot(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The radius falls in about a sixth of the turn."""
    offs = [size * share * r for share, r in zip(_sides(draw), setup.plant.radius)]
    at = [draw.between(1, -3.0, 3.0), draw.between(2, -3.0, 3.0)]
    setup.tyres = [_shaped(t, o, a, 0) for t, o, a in zip(setup.tyres, offs, at)]
    return {"left_m": offs[0], "right_m": offs[1]}
