"""Laws of the tyres: slip along and across, many wheels on a side, and treads that resist turning."""

from __future__ import annotations

import math

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw


@law(
    "wheel_slip",
    "hard_plastic",
    (0.3, 120.0),
    "1",
    "hard wheels creep in proportion to their pull: a soft slope of the brush (Pacejka ch. 3), and "
    "let go sooner",
)
def hard_plastic(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.along /= 1.0 + size
            now.grip /= 1.0 + 0.02 * size

        return hook

    setup.floor.append(make)
    return {"softer": size, "slope_in_loads": setup.plant.stiff[0] / (1.0 + size)}


@law(
    "wheel_slip",
    "dusty_treads",
    (0.1, 40.0),
    "1",
    "dust on the treads: little grip, and less the faster it slips (Stribeck of tyres, Canudas de Wit 2003)",
)
def dusty_treads(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                weaker = 1.0 + 0.25 * (1.0 - math.exp(-float(now.slip[k]) / 0.08))
                now.grip[k] /= (1.0 + size) * weaker
            now.along /= 1.0 + 0.3 * size

        return hook

    setup.floor.append(make)
    return {"less_grip": size, "grip": setup.plant.grip / (1.0 + size)}


@law(
    "lateral_slip",
    "soft_sidewalls",
    (0.5, 300.0),
    "1",
    "soft sidewalls run at a slip angle in curves: a small cornering stiffness (Pacejka ch. 1)",
)
def soft_sidewalls(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.across /= 1.0 + size

        return hook

    setup.floor.append(make)
    return {"softer": size, "slope_in_loads": setup.plant.stiff[1] / (1.0 + size)}


@law(
    "lateral_slip",
    "rollers_across",
    (0.02, 0.98),
    "1",
    "wheels with rollers on their rims (omni wheels of a kit) hold sideways by their bearings' drag alone",
)
def rollers_across(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.side[:] = (1.0 - size) ** 2
            now.across *= (1.0 - size) ** 2

        return hook

    setup.floor.append(make)
    return {"less_across": size, "side": (1.0 - size) ** 2}


@law(
    "skid_steer",
    "four_wheels",
    (0.002, 0.8),
    "1",
    "two wheels on a side, one ahead and one behind: turning drags them sideways (Mandow 2007)",
)
def four_wheels(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    base = size * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.base[:] = base

        return hook

    setup.floor.append(make)
    return {"half_base_m": base}


@law(
    "skid_steer",
    "rubber_tracks",
    (0.002, 0.8),
    "1",
    "rubber tracks: long contacts with a soft tread and some rolling loss (Wong, Theory of Ground "
    "Vehicles, ch. 6)",
)
def rubber_tracks(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    base = size * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.base[:] = base
            now.across *= 0.6
            now.along *= 0.6
            now.grip *= 0.85
            now.scrub[:] = 0.3 * base

        return hook

    setup.floor.append(make)
    return {"half_base_m": base}


@law(
    "tyre_scrub",
    "balloon_tyres",
    (0.01, 8.0),
    "1",
    "wide soft contacts are twisted on the spot; the moment falls as they roll (turn slip, Pacejka ch. 9)",
)
def balloon_tyres(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    half = size * 0.25 * setup.plant.radius[0]

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.scrub[:] = half

        return hook

    setup.floor.append(make)
    return {"half_width_m": half}


@law(
    "tyre_scrub",
    "wound_up_treads",
    (0.01, 8.0),
    "1",
    "knobbly treads wind up as the robot pivots, hold there, and unwind as they roll (parking torque "
    "of tyres)",
)
def wound_up_treads(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    p = setup.plant
    most, wide, length = size * 0.25 * p.radius[0] * p.grip, draw.between(0, 0.03, 0.09), 0.4 * p.radius[0]

    def make(machine: Machine, run: int) -> Hook:
        wound = [0.0]

        def hook(now: Now) -> None:
            v, _, turn = now.motion
            rolled = (abs(float(now.rate[0])) + abs(float(now.rate[1]))) * 0.5 * p.radius[0]
            straight = min(abs(float(v)), rolled)
            a = (wound[0] + float(turn) * now.step) / (1.0 + straight * now.step / length)
            wound[0] = min(max(a, -wide), wide)
            load = float(now.load[0] + now.load[1])
            now.push[2] -= most * load * (wound[0] / wide + 0.02 * math.tanh(float(turn)))

        return hook

    setup.floor.append(make)
    return {"lever_m": most, "wind_up_rad": wide}
