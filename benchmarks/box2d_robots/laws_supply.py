"""Laws of the supply, and of motors that warm up."""

from __future__ import annotations

import math

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw

DUTY = ("duty",)


def _stall_current(setup: Setup) -> float:
    return 2.0 * setup.plant.volts / (0.5 * sum(setup.plant.winding))


def _drawn(now: Now) -> float:
    """Return what the bridges draw from the supply [A]; what brakes is not taken back."""
    return max(float(now.duty[0] * now.amps[0]), 0.0) + max(float(now.duty[1] * now.amps[1]), 0.0)


@law(
    "battery_sag",
    "old_cells_run_down",
    (0.01, 3.0),
    "1",
    "old cells lose voltage with the charge that was drawn, ever faster (Peukert; discharge curves of "
    "alkaline AA)",
    DUTY,
)
def old_cells_run_down(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    whole = 0.1 * _stall_current(setup) * 60.0  # A s

    def make(machine: Machine, run: int) -> Hook:
        used = [0.0]

        def hook(now: Now) -> None:
            used[0] += _drawn(now) * now.step / whole
            now.volts *= max(1.0 - size * used[0] ** 1.25, 0.25)

        return hook

    setup.supply.append(make)
    return {"loss_per_charge": size, "charge_As": whole}


@law(
    "battery_sag",
    "polarised_cells",
    (0.01, 2.5),
    "1",
    "cells with an inner resistance and a slow polarisation that recovers at rest (Thevenin model "
    "with one RC)",
    DUTY,
)
def polarised_cells(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    winding, lag = 0.5 * sum(setup.plant.winding), draw.between(0, 2.0, 7.0)

    def make(machine: Machine, run: int) -> Hook:
        amps, slow = [0.0], [0.0]

        def hook(now: Now) -> None:
            amps[0] += now.step / 0.012 * (_drawn(now) - amps[0])
            slow[0] += now.step / lag * (amps[0] - slow[0])
            drop = size * winding * (0.35 * amps[0] + 0.65 * slow[0])
            now.volts -= min(drop, 0.75 * float(now.volts[0]))

        return hook

    setup.supply.append(make)
    return {"ohm_over_winding": size, "recovery_s": lag}


@law(
    "battery_sag",
    "booster_at_its_limit",
    (0.3, 40.0),
    "1",
    "a small step-up converter gives no more than its power, beyond which its voltage falls (power banks)",
    DUTY,
)
def booster_at_its_limit(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    volts = setup.plant.volts
    most = 0.3 * _stall_current(setup) * volts / size

    def make(machine: Machine, run: int) -> Hook:
        level = [volts]

        def hook(now: Now) -> None:
            goal = min(volts, max(most / (_drawn(now) + 1e-6), 0.2 * volts))
            level[0] += now.step / (0.02 if goal < level[0] else 0.15) * (goal - level[0])
            now.volts[:] = level[0]

        return hook

    setup.supply.append(make)
    return {"power_W": most}


@law(
    "motor_warmup",
    "hot_copper",
    (0.1, 60.0),
    "1",
    "copper gains 0.39 %/K and ferrite magnets lose 0.2 %/K as I2R heats the motor (Maxon, thermal model)",
    DUTY,
)
def hot_copper(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    lag, stall = draw.between(0, 15.0, 40.0), 0.5 * _stall_current(setup)

    def make(machine: Machine, run: int) -> Hook:
        rise = [0.0, 0.0]  # of the resistance, as a share

        def hook(now: Now) -> None:
            for k in (0, 1):
                heat = size * (float(now.amps[k]) / stall) ** 2
                rise[k] = min(rise[k] + now.step / lag * (heat - rise[k]), 2.0)
                now.winding[k] *= 1.0 + rise[k]
                cold = max(1.0 - 0.5 * rise[k], 0.5)
                now.torque_const[k] *= cold
                now.emf_const[k] *= cold

        return hook

    setup.motor.append(make)
    return {"rise_at_stall": size, "lag_s": lag}


@law(
    "motor_warmup",
    "grease_thins",
    (0.02, 4.0),
    "1",
    "cold grease drags with speed and thins as it is worked (viscosity falls exponentially with temperature)",
    DUTY,
)
def grease_thins(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    free, worked = setup.plant.free(), draw.between(0, 3.0, 9.0)
    drag = setup.plant.stall() / free * size

    def make(machine: Machine, run: int) -> Hook:
        work = [0.0, 0.0]

        def hook(now: Now) -> None:
            for k in (0, 1):
                work[k] += abs(float(now.rate[k])) / free * now.step
                now.viscous[k] += drag * math.exp(-work[k] / worked)

        return hook

    setup.motor.append(make)
    return {"drag_over_line": size, "worked_s": worked}
