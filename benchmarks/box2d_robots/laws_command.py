"""Laws between command and bridge: delays, the commanded point, limits, and a controller that nobody spoke
of.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Control, Hook, Setup
from benchmarks.box2d_robots.robots import full_rate, full_speed
from benchmarks.robot_sets.laws import Draw


@law(
    "command_delay",
    "serial_fifo",
    (0.004, 0.9),
    "s",
    "commands wait in a serial buffer that is always as full: a dead time (forum reports of ROS "
    "serial bridges)",
)
def serial_fifo(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        waiting = deque([(0.0, 0.0)] * max(1, round(size / machine.step)))

        def hook(now: Now) -> None:
            waiting.append((now.command[0], now.command[1]))
            now.command[0], now.command[1] = waiting.popleft()

        return hook

    setup.command.append(make)
    return {"delay_s": size}


@law(
    "command_delay",
    "slow_poll",
    (0.01, 1.2),
    "s",
    "the motor board fetches commands at its own slow pace and acts a third of a period later (I2C "
    "motor hats)",
)
def slow_poll(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    phase = draw.between(0, 0.0, 1.0)

    def make(machine: Machine, run: int) -> Hook:
        held, coming, at = [0.0, 0.0], [0.0, 0.0], [phase * size, math.inf]

        def hook(now: Now) -> None:
            if now.t >= at[1]:
                held[:], at[1] = coming, math.inf
            if now.t >= at[0]:
                coming[:] = now.command
                at[1], at[0] = now.t + size / 3.0, at[0] + size
            now.command[0], now.command[1] = held

        return hook

    setup.command.append(make)
    return {"period_s": size, "mean_delay_s": size * (0.5 + 1.0 / 3.0)}


@law(
    "command_delay",
    "radio_queue",
    (0.004, 0.8),
    "s",
    "each message takes its own time over a busy radio, the order is kept (exponential tail of a "
    "queue, M/M/1)",
)
def radio_queue(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        rng = np.random.default_rng([draw.seed, run])
        waiting: deque[tuple[float, float, float]] = deque()
        held, last, tick = [0.0, 0.0], [0.0, 0.0], setup.robot.tick

        def hook(now: Now) -> None:
            if now.t >= last[1] - 1e-9:  # a command was sent
                last[1] += tick
                last[0] = max(last[0], now.t + size * (0.6 + 0.4 * float(rng.exponential())))
                waiting.append((last[0], now.command[0], now.command[1]))
            while waiting and waiting[0][0] <= now.t:
                held[0], held[1] = waiting.popleft()[1:]
            now.command[0], now.command[1] = held

        return hook

    setup.command.append(make)
    return {"mean_delay_s": size}


def _remapped(setup: Setup, size: float, change: Callable[[float, float, float], float]) -> None:
    """Let `change(v, turn, size)` [m/s, rad/s, m] give the axle's speed of the command."""
    axle = setup.plant.axle
    full = full_speed(setup.plant, setup.control)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            left, right = now.command
            turn = (right - left) * full / axle
            v = change(0.5 * (left + right) * full, turn, size) / full
            half = 0.5 * (right - left)
            now.command[0], now.command[1] = v - half, v + half

        return hook

    setup.command.append(make)


@law(
    "command_point",
    "bumper_speed",
    (0.004, 0.9),
    "m",
    "the base takes the speed as that of a point ahead of the axle (hypotenuse of forward and turning speed)",
)
def bumper_speed(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def change(v: float, turn: float, d: float) -> float:
        return math.copysign(math.sqrt(max(v * v - (turn * d) ** 2, 0.0)), v)

    _remapped(setup, size, change)
    return {"ahead_m": size}


@law(
    "command_point",
    "outer_wheel_speed",
    (0.0008, 0.5),
    "m",
    "the base takes the speed as that of its outer side, as drivers do that keep below a rim speed",
)
def outer_wheel_speed(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def change(v: float, turn: float, d: float) -> float:
        return math.copysign(max(abs(v) - abs(turn) * d, 0.0), v)

    _remapped(setup, size, change)
    return {"aside_m": size}


@law(
    "command_point",
    "camera_aside",
    (0.0008, 0.5),
    "m",
    "the controlled point is a camera beside the middle line: rigid-body velocity v - turn * y",
)
def camera_aside(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    sign = draw.sign(0)
    _remapped(setup, size, lambda v, turn, d: v - sign * turn * d)
    return {"aside_m": sign * size}


def _limited(setup: Setup, change: Callable[[list[float]], None]) -> None:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            change(now.command)

        return hook

    setup.command.append(make)


@law(
    "command_saturation",
    "keeps_the_curve",
    (0.05, 0.93),
    "1",
    "firmware scales both wheels down when one passes the limit, so that the curve stays "
    "(diff_drive_controller)",
)
def keeps_the_curve(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    limit = 1.0 - size

    def change(command: list[float]) -> None:
        most = max(abs(command[0]), abs(command[1]))
        if most > limit:
            command[0], command[1] = command[0] * limit / most, command[1] * limit / most

    _limited(setup, change)
    return {"limit": limit}


@law(
    "command_saturation",
    "each_wheel_knee",
    (0.05, 0.93),
    "1",
    "each wheel's register ends early; a narrow knee comes before, as the bridge skips its last pulses",
)
def each_wheel_knee(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    limit = 1.0 - size
    knee = 0.15 * limit

    def one(u: float) -> float:
        over = abs(u) - (limit - knee)
        if over <= 0.0:
            return u
        return math.copysign(limit - knee + knee * (1.0 - math.exp(-over / knee)), u)

    def change(command: list[float]) -> None:
        command[0], command[1] = one(command[0]), one(command[1])

    _limited(setup, change)
    return {"limit": limit}


@law(
    "speed_controller",
    "encoder_pi",
    (0.005, 6.0),
    "1",
    "an incremental PI on encoder rates (Astrom and Hagglund 1995), as on maker boards with hall sensors",
    needs=("duty",),
)
def encoder_pi(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    full = full_rate(setup.plant)
    setup.control = Control(
        full, full / setup.plant.free(), size, draw.between(0, 3.0, 6.0) * size, 50.0, 0.01
    )
    return {"gain": size, "integral_1_s": setup.control.integral}


@law(
    "speed_controller",
    "back_emf_governor",
    (0.02, 8.0),
    "1",
    "the driver reads the back-EMF in the pauses of its pulses and adds a share of the error (model "
    "trains, servos)",
    needs=("duty",),
)
def back_emf_governor(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    free = full_rate(setup.plant)

    def make(machine: Machine, run: int) -> Hook:
        held, at = [0.0, 0.0], [0.0]

        def hook(now: Now) -> None:
            if now.t >= at[0] - 1e-9:
                at[0] += 0.01
                for k in (0, 1):
                    fresh = size * (now.command[k] - float(now.turned_rate[k]) / free)
                    held[k] += 0.5 * (fresh - held[k])
            for k in (0, 1):
                if now.command[k] != 0.0 or abs(held[k]) > 0.02 * size:
                    now.duty[k] = min(max(now.command[k] + held[k], -1.0), 1.0)

        return hook

    setup.drive.append(make)
    return {"gain": size}


@law(
    "speed_controller",
    "ir_compensation",
    (0.02, 0.85),
    "1",
    "the driver raises its voltage with the current to make up for the winding (IR compensation of DC "
    "drives)",
    needs=("duty",),
)
def ir_compensation(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        lagged = [0.0, 0.0]

        def hook(now: Now) -> None:
            for k in (0, 1):
                lagged[k] += 0.1 * (float(now.amps[k]) - lagged[k])
                more = size * lagged[k] * now.winding[k] / now.volts[k]
                now.duty[k] = min(max(now.duty[k] + more, -1.0), 1.0)

        return hook

    setup.drive.append(make)
    return {"share": size}
