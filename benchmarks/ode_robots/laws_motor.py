"""Motors and gears: faults, play, friction, backwards."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Play, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now

IDLE = 0.12  # current of computer and cameras, as a share of one motor's stall current


@law(
    "coulomb_friction",
    "share of stall",
    0.005,
    0.5,
    "Stribeck's curve of a greased gear (Armstrong-Helouvry 1991)",
)
def stribeck_gear(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Dry friction that is 1.5 times larger at rest and falls within a few per cent of full rate."""
    falls = 0.04 * sum(setup.plant.free) / 2

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                more = 0.5 * math.exp(-((now.rate[side] / falls) ** 2))
                now.dry[side] += size * machine.plant.stall[side] * (1.0 + more)

        return hook

    setup.motor.append(make)
    return {"sliding": size, "rest": 1.5 * size}


@law(
    "coulomb_friction",
    "share",
    0.01,
    0.9,
    "worm gears: friction with the load on the thread",
    needs=("duty",),
)
def worm_thread(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Friction is a share of the torque that passes, and a preload."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                now.dry[side] += size * (0.4 * abs(now.torque[side]) + 0.15 * machine.plant.stall[side])

        return hook

    setup.motor.append(make)
    return {"of_torque": 0.4 * size, "preload": 0.15 * size}


@law(
    "coulomb_friction",
    "share of stall",
    0.005,
    0.5,
    "a lip seal rubs on one hub and runs in",
    needs=("duty",),
)
def tight_seal(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Dry friction mostly on one side that wears to 0.7 of itself within some dozen turns."""
    side = int(draw.numbers[0] < 0.5)
    shares = (1.5, 0.5) if side == 0 else (0.5, 1.5)

    def make(machine: Machine, run: int) -> Hook:
        turned = [0.0, 0.0]

        def hook(now: Now) -> None:
            for s in (0, 1):
                turned[s] += abs(now.rate[s]) * now.step
                run_in = 0.7 + 0.3 * math.exp(-turned[s] / 150.0)
                now.dry[s] += size * shares[s] * run_in * machine.plant.stall[s]

        return hook

    setup.motor.append(make)
    return {"left": size * shares[0], "right": size * shares[1]}


def _play(setup: Setup, size: float, draw: Draw, bend: float) -> dict[str, float]:
    """Give both gears play; stops as springs that bend by `bend` rad under stall torque."""
    half = (size, size * draw.between(0, 0.3, 1.2))
    erp = 0.3
    stiff = 0.5 * sum(setup.plant.stall) / bend
    setup.play = Play(half, erp, erp / (0.002 * stiff))
    return {"half_left_rad": half[0], "half_right_rad": half[1], "bend_rad": bend}


@law(
    "gear_backlash", "rad", 0.003, 1.2, "worn pinions: the rotor is a body that turns free between two stops"
)
def worn_pinion(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Rotor and wheel are bodies on one hinge with hard stops; the two sides are worn unlike."""
    return _play(setup, size, draw, 0.01)


@law("gear_backlash", "rad", 0.003, 1.2, "jaw couplings with a worn rubber spider: play, then a soft stop")
def rubber_spider(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """As a worn pinion, but the stops give by a share of the play under torque."""
    return _play(setup, size, draw, 0.02 + 0.5 * size)


@law(
    "motor_fault",
    "share of a turn",
    0.01,
    0.7,
    "an open commutator segment or a lost Hall phase on the output shaft",
)
def dead_segment(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """One motor has no torque while its shaft is in one sector of the turn, with soft edges."""
    side, phase = int(draw.numbers[0] < 0.5), draw.between(1, 0.0, 2 * math.pi)
    edge = math.cos(math.pi * min(size, 0.95))

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            inside = math.cos(now.angle[side] - phase) - edge
            if inside > 0.0:
                now.torque[side] *= 1.0 - min(inside / 0.05, 1.0)

        return hook

    setup.motor.append(make)
    return {"side": float(side), "sector": size, "phase_rad": phase}


@law("motor_fault", "1/s", 0.02, 6.0, "a loose crimp: contact breaks with shaking, and comes back by itself")
def loose_crimp(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """One motor drops out for 0.05 to 0.4 s, more often the faster it turns."""
    side = int(draw.numbers[0] < 0.5)

    def make(machine: Machine, run: int) -> Hook:
        rng = np.random.default_rng([draw.seed, run])
        state = {"back": -1.0}
        free = machine.plant.free[side]

        def hook(now: Now) -> None:
            chance = size * (0.3 + abs(now.rate[side]) / free) * now.step
            if float(rng.random()) < chance and now.t > state["back"]:
                state["back"] = now.t + float(rng.uniform(0.05, 0.4))
            if now.t < state["back"]:
                now.torque[side] = 0.0

        return hook

    setup.motor.append(make)
    return {"side": float(side), "breaks_per_s": size}


@law(
    "motor_fault", "1/s", 0.02, 8.0, "driver chips trip when hot and come back when cooler (thermal shutdown)"
)
def thermal_trip(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """One driver warms with the square of its duty, shuts down at a limit and returns at 0.6 of it."""
    side = int(draw.numbers[0] < 0.5)

    def make(machine: Machine, run: int) -> Hook:
        state = {"hot": 0.0, "off": 0.0}

        def hook(now: Now) -> None:
            duty = 0.0 if state["off"] else now.duty[side]
            state["hot"] += (size * duty**2 - 0.25 * state["hot"]) * now.step
            if state["hot"] > 0.5:
                state["off"] = 1.0
            elif state["hot"] < 0.42:
                state["off"] = 0.0
            if state["off"]:
                now.torque[side] = 0.0

        return hook

    setup.motor.append(make)
    return {"side": float(side), "heating_per_s": size}


@law(
    "motor_reverse_asymmetry",
    "share",
    0.01,
    0.7,
    "advanced brushes: tuned for one way of turning",
    needs=("duty",),
)
def advanced_brushes(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Backwards the free rate is lower and the stall torque somewhat higher."""

    def make(machine: Machine, run: int) -> Hook:
        plant = machine.plant

        def hook(now: Now) -> None:
            for side in (0, 1):
                if now.duty[side] < 0.0:
                    u = now.duty[side] * now.supply
                    back = now.rate[side] / (plant.free[side] * (1.0 - size))
                    now.torque[side] = plant.stall[side] * (1.0 + 0.3 * size) * (u - back)

        return hook

    setup.motor.append(make)
    return {"free": -size, "stall": 0.3 * size}


@law(
    "motor_reverse_asymmetry",
    "share of stall",
    0.005,
    0.5,
    "helical gears thrust on a plain washer one way only",
)
def thrust_washer(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Turning backwards rubs more: a constant and a share of the torque."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                if now.rate[side] < 0.0 or now.torque[side] < 0.0:
                    now.dry[side] += size * (machine.plant.stall[side] + 0.8 * abs(now.torque[side]))

        return hook

    setup.motor.append(make)
    return {"rubs": size}


@law(
    "motor_reverse_asymmetry",
    "share",
    0.02,
    0.9,
    "a worn half bridge: one switch has more resistance",
    needs=("duty",),
)
def worn_switch(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Commanded backwards, one motor has a lower voltage and both a little."""
    shares = (1.0, 0.25) if draw.numbers[0] < 0.5 else (0.25, 1.0)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                if now.duty[side] < 0.0:
                    lost = size * shares[side] * now.duty[side] * now.supply
                    now.torque[side] -= machine.plant.stall[side] * lost

        return hook

    setup.motor.append(make)
    return {"left": size * shares[0], "right": size * shares[1]}
