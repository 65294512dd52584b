"""Checks of the simulation: python checks.py prints one line each with its figure and bound, exits 1
on a failure.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.exudyn_robots import engine
from benchmarks.exudyn_robots.driver import Commands, Driver
from benchmarks.exudyn_robots.engine import STEP, Truth
from benchmarks.exudyn_robots.physics import G
from benchmarks.exudyn_robots.robots import KINDS, Setup, draw

RESULTS: list[bool] = []


def tell(what: str, figure: float, bound: float, unit: str) -> None:
    """Prints a figure against its upper bound."""
    good = bool(figure <= bound)
    RESULTS.append(good)
    print(f"{'ok ' if good else 'BAD'} {what}: {figure:.4g} {unit} (at most {bound:g})", flush=True)


def example(kind: str, control: str = "duty", even: bool = False) -> Setup:
    """A robot of a kind; `even`: both sides alike, mass on the middle line."""
    for seed in range(1000):
        setup = draw(np.random.default_rng([4242, seed]), control)
        if setup.kind == kind:
            break
    if even:
        for name in ("radius", "stall", "free", "viscous", "dry", "rotor_inertia", "inertia_stick"):
            setup.par[name] = setup.par[name].mean()
        setup.body.centre = (setup.body.centre[0], 0.0, setup.body.centre[2])
        for c in setup.body.casters:
            c.mu, c.aside = setup.body.casters[0].mu, 0.0
    return setup.finish()


def steady(setup: Setup, left: float, right: float, time: float, step: float = STEP) -> Truth:
    """Constant commands after 1 s of rest."""
    return engine.run(
        setup.body,
        setup.par,
        np.zeros(3),
        time,
        lambda t, _: (0.0, 0.0) if t < 1.0 else (left, right),
        step,
        round(0.01 / step),
    )


def straight() -> None:
    """Equal sides drive straight: sideways deviation after 6 s."""
    for kind in ("turtle_like", "platform", "cart"):
        truth = steady(example(kind, even=True), 0.6, 0.6, 7.0)
        tell(
            f"{kind}: straight with equal sides, sideways over {truth.pose[-1, 0]:.2f} m",
            1000.0 * float(np.max(np.abs(truth.pose[:, 1]))),
            1.0,
            "mm",
        )


def torque_speed() -> None:
    """Steady wheel rate under a known drag against the motor line T = Ts (u - w/w0) with the
    frictions' torque.
    """
    worst = 0.0
    for kind in ("turtle_like", "platform"):
        for duty in (0.4, 0.8):
            for share in (0.0, 0.04, 0.08):
                s = example(kind, even=True)
                for c in s.body.casters:
                    c.mu = 0.0
                s.par["rolling"] = 0.0
                weight = s.body.mass * G
                s.par["trailer"], s.par["hitch"], s.par["trailer_l"] = share * weight, 0.0, 1.0
                truth = steady(s, duty, duty, 6.0)
                rate = (truth.angle[-1] - truth.angle[-101]) / (truth.t[-1] - truth.t[-101])
                p = s.par[0]
                load = 0.5 * share * weight * p["radius"][0] + p["dry"][0]
                want = (p["stall"][0] * duty - load) / (p["stall"][0] / p["free"][0] + p["viscous"][0])
                worst = max(worst, abs(float(rate.mean()) / float(want) - 1.0))
    tell("torque-speed line, 12 loads: worst error of the steady rate", 100.0 * worst, 1.0, "%")


def halved() -> None:
    """The step halved: change of the end of 20 s of random driving."""
    for kind in (k.name for k in KINDS):
        s = example(kind, "duty" if kind != "cart" else "rate")
        commands = Commands(s, Driver(s, np.zeros((1, 2)), np.random.default_rng(7)))
        a = engine.run(s.body, s.par, np.zeros(3), 20.0, commands)
        b = engine.run(
            s.body, s.par, np.zeros(3), 20.0, Commands(s, table=np.array(commands.log)), STEP / 2, 8
        )
        tell(
            f"{kind}: step halved, end after 20 s",
            1000.0 * float(np.hypot(*(a.pose[-1, :2] - b.pose[-1, :2]))),
            10.0,
            "mm",
        )


def rest() -> None:
    """At rest on a slope of 1 degree, gears stiff enough to hold: creep of the regularised frictions."""
    s = example("turtle_like")
    s.par["dry"] = 0.3 * s.par["stall"]
    s.par["tilt_x"] = math.radians(1.0)
    truth = steady(s, 0.0, 0.0, 4.0)
    way = truth.pose[-1, :2] - truth.pose[100, :2]
    tell("at rest on a slope of 1 degree, creep in 3 s", 1000.0 * float(np.hypot(*way)), 3.0, "mm")


def grip() -> None:
    """Full duty on a slippery floor: no more acceleration than friction gives."""
    s = example("turtle_like", even=True)
    s.par["grip"] = 0.03
    for c in s.body.casters:
        c.mu = 0.0
    truth = steady(s, 1.0, 1.0, 2.0)
    k = truth.t > 1.1
    fit = np.polyfit(truth.t[k][:40], truth.pose[k, 0][:40], 2)
    tell("slippery floor: acceleration over mu g", 2.0 * float(fit[0]) / (0.03 * G), 1.02, "")


def spin() -> None:
    """A spin without losses turns by the wheels' ways over the axle."""
    s = example("platform", even=True)
    truth = steady(s, -0.5, 0.5, 5.0)
    p = s.par[0]
    want = (truth.angle[-1, 1] - truth.angle[-1, 0]) * p["radius"][0] / p["axle"]
    tell(
        "spin: heading against the wheels' ways",
        100.0 * abs(float(truth.pose[-1, 2] / want) - 1.0),
        1.5,
        "%",
    )


def repeat() -> None:
    """The same run twice."""
    s = example("vacuum_like")
    a, b = (steady(s, 0.7, 0.5, 8.0) for _ in range(2))
    tell("the same run twice", float(np.max(np.abs(a.pose - b.pose))), 0.0, "m")


if __name__ == "__main__":
    for check in (straight, torque_speed, halved, rest, grip, spin, repeat):
        check()
    sys.exit(0 if all(RESULTS) else 1)
