"""Batteries that fade and motors that warm."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now

IDLE = 0.12  # current of computer and cameras, as a share of one motor's stall current


def _current(machine: Machine, now: Now) -> float:
    """Return the current of both motors and the rest, in stall currents of one motor."""
    stall = machine.plant.stall
    return IDLE + abs(now.torque[0]) / stall[0] + abs(now.torque[1]) / stall[1]


@law(
    "battery_sag",
    "share",
    0.01,
    1.5,
    "lithium cells: a resistance, an RC pair and a charge curve",
    needs=("duty",),
)
def cell_with_memory(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The supply falls at once with current, more over some seconds, and with the charge drawn."""
    slow = draw.between(0, 4.0, 12.0)

    def make(machine: Machine, run: int) -> Hook:
        state = {"slow": 0.0, "drawn": 0.0}

        def hook(now: Now) -> None:
            i = _current(machine, now)
            state["slow"] += (0.5 * size * i - state["slow"]) * now.step / slow
            state["drawn"] += i * now.step
            full = 1.0 - 0.02 * size * state["drawn"]
            now.supply = max(full - 0.35 * size * i - state["slow"], 0.25)

        return hook

    setup.supply.append(make)
    return {"at_once": 0.35 * size, "slow": 0.5 * size, "slow_s": slow, "per_charge": 0.02 * size}


@law("battery_sag", "1/share", 1.0, 300.0, "a boost converter at its power limit folds back", needs=("duty",))
def converter_folds(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Above a power the converter's voltage folds back and returns within a fifth of a second."""
    limit = 0.8 / size

    def make(machine: Machine, run: int) -> Hook:
        state = {"v": 1.0}

        def hook(now: Now) -> None:
            power = sum(abs(now.torque[s] * now.duty[s]) / machine.plant.stall[s] for s in (0, 1))
            want = 1.0 if power <= limit else max(math.sqrt(limit / power), 0.3)
            state["v"] += (want - state["v"]) * now.step / (0.01 if want < state["v"] else 0.2)
            now.supply = state["v"]

        return hook

    setup.supply.append(make)
    return {"power_limit": limit}


@law(
    "battery_sag",
    "share",
    0.01,
    1.5,
    "alkaline cells: resistance grows as charge goes, and rest heals",
    needs=("duty",),
)
def tired_alkaline(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Resistance grows with charge drawn and falls back at rest, with 25 s."""

    def make(machine: Machine, run: int) -> Hook:
        state = {"tired": 0.0}

        def hook(now: Now) -> None:
            i = _current(machine, now)
            state["tired"] += (i - IDLE - state["tired"] / 25.0) * now.step
            now.supply = max(1.0 - size * i * (0.2 + 0.25 * state["tired"]), 0.25)

        return hook

    setup.supply.append(make)
    return {"fresh": 0.2 * size, "growth": 0.25 * size, "rest_s": 25.0}


@law(
    "motor_warmup",
    "share",
    0.02,
    1.2,
    "copper +0.39 %/K, ferrite magnets -0.2 %/K: two thermal nodes",
    needs=("duty",),
)
def copper_and_magnet(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Windings warm in seconds, magnets after them: less torque, and a higher free rate."""
    quick, slow = draw.between(0, 6.0, 12.0), draw.between(1, 20.0, 40.0)

    def make(machine: Machine, run: int) -> Hook:
        plant, copper, magnet = machine.plant, [0.0, 0.0], [0.0, 0.0]

        def hook(now: Now) -> None:
            for side in (0, 1):
                heat = size * min(2.0 * abs(now.duty[side]), 1.0)
                copper[side] += (heat - copper[side]) * now.step / quick
                magnet[side] += (copper[side] - magnet[side]) * now.step / slow
                flux = 1.0 - 0.5 * min(magnet[side], 1.0)
                u = now.duty[side] * now.supply - flux * now.rate[side] / plant.free[side]
                now.torque[side] = plant.stall[side] * flux / (1.0 + copper[side]) * u

        return hook

    setup.motor.append(make)
    return {"copper": size, "magnet": 0.5 * size, "copper_s": quick, "magnet_s": slow}


@law("motor_warmup", "share", 0.02, 2.5, "stiff grease in cold gears thins as it is worked", needs=("duty",))
def cold_grease(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A drag that grows less than with the rate, and falls as the gear has turned for 10 to 25 s."""
    warms = draw.between(0, 10.0, 25.0)

    def make(machine: Machine, run: int) -> Hook:
        plant, worked = machine.plant, [0.0, 0.0]

        def hook(now: Now) -> None:
            for side in (0, 1):
                share = now.rate[side] / plant.free[side]
                worked[side] += abs(share) ** 0.5 * now.step
                drag = size * math.exp(-worked[side] / (0.5 * warms)) * math.tanh(share / 0.05)
                now.torque[side] -= 0.5 * plant.stall[side] * drag * (abs(share) + 1e-9) ** 0.6

        return hook

    setup.motor.append(make)
    return {"cold": size, "warms_s": warms}
