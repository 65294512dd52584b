"""Commands that are bent, cut or lost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Factory, Hook, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.ode_robots.machine import Machine, Now


def _each(bend: Callable[[float, int], float]) -> Factory:
    """Return a stage that bends each wheel's command by itself."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.command[0] = bend(now.command[0], 0)
            now.command[1] = bend(now.command[1], 1)

        return hook

    return make


@law(
    "command_saturation",
    "1/share",
    1.05,
    8.0,
    "mixers of flight and rover controllers keep the ratio (desaturation)",
)
def mixer_scales_both(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """When one wheel wants more than the limit, both shrink alike, with a knee of a tenth."""
    limit = 1.0 / size

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            peak = max(abs(now.command[0]), abs(now.command[1]))
            if peak > 0.9 * limit:
                soft = 0.9 * limit + 0.1 * limit * math.tanh((peak - 0.9 * limit) / (0.1 * limit))
                now.command[0] *= soft / peak
                now.command[1] *= soft / peak

        return hook

    setup.command.append(make)
    return {"limit": limit}


@law(
    "command_saturation",
    "1/share",
    1.05,
    8.0,
    "controllers that keep the turn and give up speed (priority mixing)",
)
def turn_first(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The turning part is limited first; the forward part has what is left."""
    limit = 1.0 / size

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            v, w = 0.5 * (now.command[0] + now.command[1]), 0.5 * (now.command[1] - now.command[0])
            w = min(max(w, -0.8 * limit), 0.8 * limit)
            room = limit - abs(w)
            v = min(max(v, -room), room)
            now.command[:] = (v - w, v + w)

        return hook

    setup.command.append(make)
    return {"limit": limit}


@law(
    "command_saturation",
    "1/share",
    1.02,
    8.0,
    "one dual H bridge with a budget for both channels (L298 package heat)",
)
def shared_budget(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The squares of both duties share one budget; a slow governor (0.1 s) cuts both."""
    limit = 1.0 / size

    def make(machine: Machine, run: int) -> Hook:
        state = {"cut": 1.0}

        def hook(now: Now) -> None:
            asked = math.sqrt(0.5 * (now.command[0] ** 2 + now.command[1] ** 2))
            want = min(1.0, limit / max(asked, 1e-6))
            state["cut"] += (want - state["cut"]) * now.step / 0.1
            now.command[0] *= state["cut"]
            now.command[1] *= state["cut"]

        return hook

    setup.command.append(make)
    return {"limit_rms": limit, "governor_s": 0.1}


@law("motor_deadband", "share", 0.005, 0.45, "motor drivers with an enable threshold and hysteresis")
def pull_in_and_hold(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A wheel starts at the threshold and drops out at 0.55 of it; unlike on the two sides."""
    at = (size, size * draw.between(0, 0.6, 1.3))

    def make(machine: Machine, run: int) -> Hook:
        on = [False, False]

        def hook(now: Now) -> None:
            for side in (0, 1):
                u = abs(now.command[side])
                on[side] = u > (0.55 if on[side] else 1.0) * at[side]
                if not on[side]:
                    now.command[side] = 0.0

        return hook

    setup.command.append(make)
    return {"left": at[0], "right": at[1], "drop_out": 0.55}


@law(
    "motor_deadband",
    "share",
    0.01,
    0.6,
    "coarse speed steps of cheap drivers: duty cut to whole steps towards zero",
)
def cut_to_steps(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Commands lose what exceeds whole steps; the first step is the largest that is lost."""

    def bend(u: float, side: int) -> float:
        return math.copysign(math.floor(abs(u) / size + 0.1) * size, u)

    setup.command.append(_each(bend))
    return {"step": size}


@law("motor_deadband", "share", 0.003, 0.35, "brush drop of small DC motors, 0.2 to 2 V whatever the current")
def brush_drop(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Every command loses a drop that sets in softly, unlike left and right."""
    lost = (size, size * draw.between(1, 0.5, 1.4))

    def bend(u: float, side: int) -> float:
        return u - lost[side] * math.tanh(2.0 * u / lost[side]) if abs(u) > 1e-9 else 0.0

    setup.command.append(_each(bend))
    return {"left": lost[0], "right": lost[1]}


@law(
    "motor_gain_curve",
    "share",
    0.02,
    2.0,
    "discontinuous current: at low duty PWM gives more than duty times supply",
)
def thin_current(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Small duties work more than in proportion, full duty as told."""

    def bend(u: float, side: int) -> float:
        return u * (1.0 + size * max(1.0 - abs(u), 0.0) ** 3)

    setup.command.append(_each(bend))
    return {"excess": size}


@law("motor_gain_curve", "share", 0.02, 0.95, "gate drivers' rise times and dead times: S-shaped transfer")
def s_transfer(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The curve swings below the line at low and above it at high commands, or the other way."""
    way = draw.sign(0)

    def bend(u: float, side: int) -> float:
        return u - way * size * math.sin(2.0 * math.pi * u) / (2.0 * math.pi)

    setup.command.append(_each(bend))
    return {"swing": way * size}


@law(
    "motor_gain_curve",
    "share",
    0.01,
    0.6,
    "a calibration table made for another motor, read between its knots",
)
def wrong_table(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A table of five knots, each off by chance; the last knot is right."""
    knots = np.array([0.0, 0.2, 0.45, 0.7, 1.0])
    off = np.array(
        [0.0, draw.between(0, 0.5, 1.0), draw.between(1, -0.3, 0.6), draw.between(2, -1.0, -0.4), 0.0]
    )
    values = [float(v) for v in np.maximum.accumulate(knots + 0.5 * size * draw.sign(3) * off)]
    edges = [float(k) for k in knots]

    def bend(u: float, side: int) -> float:
        a = min(abs(u), 1.0)
        k = next(i for i in range(1, 5) if a <= edges[i] or i == 4)
        share = (a - edges[k - 1]) / (edges[k] - edges[k - 1])
        return math.copysign(values[k - 1] + share * (values[k] - values[k - 1]), u)

    setup.command.append(_each(bend))
    return {f"knot_{k}": values[k] for k in range(1, 4)}
