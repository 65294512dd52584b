"""Is a fitted effect what its name says? A place is somewhere that the robot also leaves.

Without this an area that grows over the whole floor stands in for what acts everywhere (a rough floor for dry
friction, a turned marker for a turned sensor), with as good a likelihood as theirs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.bank import Ranked
from fsm_calib.diagnosis.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

MOST_INSIDE = 0.7  # of the driving time; by the same token a place needs a third of the drive to compare with


def is_plausible(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether a place effect leaves the robot some of the floor that it drove on; True for other effects."""
    if registry()[ranked.name].scan != "place":
        return True
    inside, total = 0.0, 0.0
    for simulator, values in zip(simulators, ranked.fit.values, strict=True):
        p = simulator.prepared
        total += float(np.sum(p.dt * p.moving))
        inside += float(np.sum((p.dt * p.moving)[in_place(ranked.name, values, p.reference)]))
    return inside <= MOST_INSIDE * total


def in_place(name: str, values: FloatArray, path: FloatArray) -> np.ndarray:
    """Return which points of `path` (n, 2 or more) [m] lie in the area of a place effect with parameters (p,)."""
    table = parameter_table()
    numbers = {p.name: float(values[table.place(f"{name}.{p.name}")]) for p in registry()[name].parameters}
    x, y = path[:, 0] - numbers["x"], path[:, 1] - numbers["y"]
    if "radius" in numbers:
        return np.asarray(np.hypot(x, y) < numbers["radius"])
    x, y = x / numbers["half_x"], y / numbers["half_y"]
    if numbers.get("roundness", 0.0) > 0.0:
        return np.asarray(np.hypot(x, y) < 1.0)
    return np.asarray((np.abs(x) < 1.0) & (np.abs(y) < 1.0))
