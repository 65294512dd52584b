"""Commands that come late, or take their time."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now


@law(
    "command_delay",
    "s",
    0.01,
    0.8,
    "serial drivers with a queue: base latency, exponential waits, order kept",
)
def serial_queue(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Commands wait in a queue for 0.7 of size and at chance for a further 0.3 on average."""
    tick = setup.robot.tick

    def make(machine: Machine, run: int) -> Hook:
        rng = np.random.default_rng([draw.seed, run])
        queue: deque[tuple[float, tuple[float, float]]] = deque()
        state = {"next": 0.0, "last": 0.0}
        held = [0.0, 0.0]

        def hook(now: Now) -> None:
            if now.t >= state["next"] - 1e-6:
                state["next"] += tick
                state["last"] = max(state["last"], now.t + size * (0.7 + 0.3 * float(rng.exponential())))
                queue.append((state["last"], (now.command[0], now.command[1])))
            while queue and queue[0][0] <= now.t:
                held[:] = queue.popleft()[1]
            now.command[:] = held

        return hook

    setup.command.append(make)
    return {"base_s": 0.7 * size, "mean_wait_s": 0.3 * size}


@law("command_delay", "s", 0.02, 1.2, "IEEE 802.11 power save: frames wait at the access point for a beacon")
def beacon_wait(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Commands pass only at beacons, one every size, so they are late by up to a period."""
    phase = draw.between(0, 0.0, 1.0) * size

    def make(machine: Machine, run: int) -> Hook:
        held, state = [0.0, 0.0], {"next": phase}

        def hook(now: Now) -> None:
            if now.t >= state["next"] - 1e-6:
                state["next"] += size
                held[:] = now.command
            now.command[:] = held

        return hook

    setup.command.append(make)
    return {"period_s": size}


@law(
    "command_delay",
    "s",
    0.01,
    0.6,
    "two motor boards on one polled bus: each has its turn, and a frame to decode",
)
def bus_in_turns(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Left and right boards are polled in turns, and each acts on the frame of its turn before."""

    def make(machine: Machine, run: int) -> Hook:
        held, waiting, state = [0.0, 0.0], [0.0, 0.0], {"next": 0.0, "side": 0}

        def hook(now: Now) -> None:
            if now.t >= state["next"] - 1e-6:
                state["next"] += size
                side = int(state["side"])
                held[side], waiting[side] = waiting[side], now.command[side]
                state["side"] = 1 - side
            now.command[:] = held

        return hook

    setup.command.append(make)
    return {"slot_s": size}


@law("motor_asymmetric_lag", "s", 0.03, 4.0, "slew limits in firmware: gentle up, quick down")
def slew_unlike(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A wheel's command may rise by full scale in size seconds, and fall in a fraction of it."""
    down = size * draw.between(0, 0.1, 0.3)

    def make(machine: Machine, run: int) -> Hook:
        held = [0.0, 0.0]

        def hook(now: Now) -> None:
            for side in (0, 1):
                want, has = now.command[side], held[side]
                rises = abs(want) > abs(has) and want * has >= 0.0
                most = now.step / (size if rises else down)
                held[side] = has + min(max(want - has, -most), most)
            now.command[:] = held

        return hook

    setup.command.append(make)
    return {"up_s": size, "down_s": down}


@law(
    "motor_asymmetric_lag",
    "s",
    0.01,
    1.5,
    "S-curve profiles for starting, plain braking (motion controllers)",
)
def s_curve_start(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Speeding up follows two lags in a row, slowing down one short lag."""
    short = size * draw.between(0, 0.1, 0.25)

    def make(machine: Machine, run: int) -> Hook:
        first, second = [0.0, 0.0], [0.0, 0.0]

        def hook(now: Now) -> None:
            for side in (0, 1):
                want, has = now.command[side], second[side]
                if abs(want) > abs(has) and want * has >= 0.0:
                    first[side] += (want - first[side]) * now.step / (now.step + 0.5 * size)
                    second[side] += (first[side] - has) * now.step / (now.step + 0.5 * size)
                else:
                    second[side] += (want - has) * now.step / (now.step + short)
                    first[side] = second[side]
            now.command[:] = second

        return hook

    setup.command.append(make)
    return {"up_s": size, "down_s": short}


@law(
    "motor_asymmetric_lag",
    "share",
    0.05,
    0.995,
    "fast decay: a bridge that lets go does not brake",
    needs=("duty",),
)
def coasting_bridge(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Torque against the turning is only a share of what it would be, so slowing down takes longer."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for side in (0, 1):
                if now.torque[side] * now.rate[side] < 0.0:
                    now.torque[side] *= 1.0 - size * math.tanh(abs(now.rate[side]) / 0.5)

        return hook

    setup.motor.append(make)
    return {"braking_lost": size}
