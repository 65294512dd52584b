"""The list of laws: each label of the catalogue has several, from several sources."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from foreign.setup import Setup

Sizes = dict[str, Any]
Apply = Callable[[Setup, float, np.random.Generator], Sizes]

PLACED = {"rough_floor_patch", "low_friction_patch", "misplaced_marker"}
TIMED = {"motor_fault", "external_push"}
FITTED = {
    "trailing": {"fork": 1.0},
    "ball": {"caster_friction": 0.01},
    "drift": {"moving_floor": 1.0},
    "conveyor": {"moving_floor": 1.0},
}  # pieces that a robot in Drake has for a law, also while the law does not act


@dataclass(frozen=True)
class Law:
    """One way in which a label comes about; `apply(setup, s, rng)` changes the setup, s = 1 is a usual size.

    `engines` names those that can show it; `placed` and `timed` say whether it needs a spot or a time.
    """

    label: str
    name: str
    apply: Apply
    engines: tuple[str, ...]
    placed: bool
    timed: bool
    most: float  # largest s that still is this effect


LAWS: dict[str, list[Law]] = {}
ALL = ("planar", "mujoco", "pybullet", "drake")
FLAT = ("planar",)
BODIES = ("planar", "drake")  # a natural cause in Drake alone of the 3-D engines
PUSHED = ("planar", "mujoco", "pybullet")  # forces by a formula, whose cause Drake has itself


def law(
    label: str,
    name: str,
    engines: tuple[str, ...] = ALL,
    placed: bool = False,
    timed: bool = False,
    most: float = 6.0,
) -> Callable[[Apply], Apply]:
    """Register a function as a law of a label."""

    def add(function: Apply) -> Apply:
        item = Law(label, name, function, engines, placed or label in PLACED, timed or label in TIMED, most)
        LAWS.setdefault(label, []).append(item)
        return function

    return add


def which_wheels(rng: np.random.Generator, both: float = 0.6) -> str:
    """Draw `both`, `left` or `right`."""
    return str(rng.choice(["both", "left", "right"], p=[both, (1 - both) / 2, (1 - both) / 2]))
