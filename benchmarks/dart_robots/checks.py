"""Check the simulated robots: straightness, top speed, time step, height, and effects of size nought.

python benchmarks/dart_robots/checks.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.dart_robots.driver import Driver, Knows
from benchmarks.dart_robots.law import with_body, with_drive, with_place
from benchmarks.dart_robots.robots import KINDS, draw_robot, draw_sensing
from benchmarks.dart_robots.simulate import Replay, simulate
from benchmarks.dart_robots.truth import Moments, Pair, Truth, loads
from benchmarks.dart_robots.visible import Drives, ratio

TICK = 0.05


class Steady:
    """The same command for ever."""

    tick = TICK

    def __init__(self, left: float, right: float):
        self.both = (left, right)

    def command(self, time: float, x: float, y: float, theta: float) -> Pair:
        """Return the command."""
        return self.both


def equal(truth: Truth) -> Truth:
    """Return the robot with equal sides."""
    body, drive = truth.body, truth.drive

    def both(pair: Pair) -> Pair:
        return (sum(pair) / 2, sum(pair) / 2)

    names = ("emf", "ohm", "dry", "viscous", "gain")
    return replace(
        truth,
        body=replace(body, centre=(body.centre[0], 0.0, body.centre[2]), radius=both(body.radius)),
        drive=replace(drive, **{name: both(getattr(drive, name)) for name in names}),
    )


def expected_rate(truth: Truth) -> float:
    """Return the wheel rate at command 1: the torque-speed line under friction and rolling resistance."""
    body, drive = truth.body, truth.drive
    load = loads(body)
    dry = drive.dry[0] + body.rolling * load[0] * body.radius[0]
    dry += body.caster_grip * load[2] * body.radius[0] / 2 if body.caster == "ball" else 0.0
    emf, ohm = drive.emf[0], drive.ohm[0]
    return (emf * drive.volts / ohm - dry) / (emf**2 / ohm + drive.viscous[0])


def lines() -> Iterator[str]:
    """Check a robot of every kind, driven by duty and by rate."""
    for number, kind in enumerate(KINDS):
        for mode in ("duty", "rate"):
            rng = np.random.default_rng([31, number])
            truth, _ = draw_robot(rng, kind, mode)
            while truth.body.caster != "ball":
                truth, _ = draw_robot(rng, kind, mode)
            same = equal(truth)
            straight = simulate(same, Steady(0.5, 0.5), 6.0, 0.001, Moments())
            turn = (straight.theta[-1] - straight.theta[-501]) / 2.0
            full = simulate(same, Steady(1.0, 1.0), 4.0, 0.001, Moments())
            rate = (full.left[-1] - full.left[-251]) / 1.0
            wanted = expected_rate(same) if mode == "duty" else same.drive.top_rate
            knows = Knows(truth.drive.top_rate * truth.body.radius[0], truth.body.axle)
            began = time.perf_counter()
            drive = simulate(
                truth, Driver(rng, knows, TICK, 20.0, (0.4, 0.2)), 20.0, 0.001, Moments(), (0, 0, 0.3)
            )
            took = time.perf_counter() - began
            half = simulate(truth, Replay(drive, TICK), 20.0, 0.0005, Moments(), (0, 0, 0.3))
            twice = simulate(truth, Replay(drive, TICK), 20.0, 0.002, Moments(), (0, 0, 0.3))
            apart = [
                1e3 * float(np.hypot(each.x[-1] - drive.x[-1], each.y[-1] - drive.y[-1]))
                for each in (half, twice)
            ]
            angle = [1e3 * float(abs(each.theta[-1] - drive.theta[-1])) for each in (half, twice)]
            rise = 1e3 * (drive.height - np.mean(truth.body.radius))
            finite = all(
                bool(np.isfinite(each).all()) for each in (drive.x, drive.y, drive.theta, drive.left)
            )
            yield (
                f"| {kind} | {mode} | {1e3 * turn:.4f} | {rate:.2f} / {wanted:.2f} | "
                f"{apart[0]:.2f} mm, {angle[0]:.2f} mrad | {apart[1]:.2f} mm, {angle[1]:.2f} mrad | "
                f"{rise.min():+.3f} to {rise.max():+.3f} | {'no' if finite else 'YES'} | {took / 20:.3f} |"
            )


def neutral() -> Iterator[str]:
    """Check that an effect of size nought that needs other joints or shapes changes nothing."""
    truth, _ = draw_robot(np.random.default_rng(8), "kobuki", "duty")
    while truth.body.caster != "ball":
        truth, _ = draw_robot(np.random.default_rng(9), "kobuki", "duty")
    sensing = draw_sensing(np.random.default_rng(4), False, 1.0)
    knows = Knows(truth.drive.top_rate * truth.body.radius[0], truth.body.axle)
    driver = Driver(np.random.default_rng(2), knows, TICK, 40.0, (0.4, 0.2))
    clean = simulate(truth, driver, 40.0, 0.001, Moments())
    cases = {
        "play of 0.0001 rad": with_drive(truth, backlash=(1e-4, 1e-4)),
        "side stiffness of 200 loads a radian": with_body(truth, cornering=200.0),
        "tyres 0.1 mm wide": with_body(truth, tyre_width=1e-4),
        "tyres oval by 1e-6": with_body(truth, oval=(1e-6, 1e-6)),
        "hubs off centre by 1 um": with_body(truth, hub_offset=(1e-6, 1e-6)),
        "carpet that carries 1e-6 m/m": with_place(truth, nap_carry=1e-6),
        "payload of 1 mg": with_body(truth, payload=1e-6, payload_at=(0.0, 0.1, 0.03)),
    }
    for name, other in cases.items():
        drive = simulate(other, Replay(clean, TICK), 40.0, 0.001, Moments())
        value = ratio(other, truth, [Drives(drive, clean, Moments())], sensing)
        yield f"| {name} | {value.position:.3f} | {value.heading:.3f} |"


def main() -> None:
    """Print the tables."""
    print(
        "| kind | control | turning on a straight, mrad/s | wheel rate at command 1, got / expected, rad/s |",
        end="",
    )
    print(" end after 20 s, step halved | step doubled | height, mm | NaN | s of one core per s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for line in lines():
        print(line, flush=True)
    print("\n| effect of size nought | position ratio | heading ratio |\n|---|---|---|")
    for line in neutral():
        print(line, flush=True)


if __name__ == "__main__":
    main()
