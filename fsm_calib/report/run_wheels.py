"""The wheels: k against the iteration, and the 2 m test drive before and after."""

from __future__ import annotations

import numpy as np

from fsm_calib.report.palette import ALLOWED, INK, PHASE_COLOURS
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import limits
from fsm_calib.runner.record import RunRecord

TOLERANCE = 0.005
"""Error of k that bends a 2 m drive by 0.10 m: deviation = e s^2 / (2 L) with L = 0.1 m."""
PASS_LIMIT = 0.10
"""The manual's limit of the deviation after 2 m [m]."""
SIZE = (460.0, 320.0)
BOX = Box(62.0, 44.0, 386.0, 230.0)
"""Size of a figure and place of its axes [px]."""


def ratio_history(record: RunRecord) -> str:
    """Return k against the iteration as SVG, with the true value and what a 0.10 m deviation allows."""
    history = np.array(record.notebook.ratio_history)
    found = np.array([run.wheel_ratio + run.k_i - 1.0 for run in record.notebook.runs])
    true = (record.result.get("wheels") or {}).get("true_wheel_ratio")
    allowed = [] if true is None else [true - TOLERANCE, true + TOLERANCE]
    last = max(len(history) - 1, len(found) - 1, 1)
    axes = Axes(BOX, (-0.3, last + 0.3), limits(np.concatenate([history, found, allowed])))
    if true is not None:
        axes.band(true - TOLERANCE, true + TOLERANCE, ALLOWED, "0.10 m after 2 m")
        axes.line(np.array([(-0.3, true), (last + 0.3, true)]), ALLOWED, 1.2, "5 4", "true")
    used = np.column_stack([np.arange(len(history)), history])
    axes.line(used, INK, 1.4)
    axes.dots(used, INK, 5.0, label="k in use")
    if len(found):
        axes.crosses(np.column_stack([np.arange(len(found)), found]), "#e08214", "k + (kᵢ − 1) of a drive")
    axes.frame("iteration", "wheel ratio k", least_step=1.0)
    return figure(*SIZE, "Wheel ratio against iteration", axes)


def test_drives(record: RunRecord) -> str:
    """Return the paths of the 2 m test drive before and after as SVG; axes equal would hide the deviation."""
    driven = np.vstack([*record.paths.values(), [(0.0, -PASS_LIMIT), (0.0, PASS_LIMIT)]])
    axes = Axes(BOX, limits(driven[:, 0], 0.03), limits(driven[:, 1]))
    axes.band(-PASS_LIMIT, PASS_LIMIT, ALLOWED, "pass limit 0.10 m")
    colours = {"before": "#d73027", "after": PHASE_COLOURS["wheels"], "after lane": PHASE_COLOURS["lane"]}
    for name, path in record.paths.items():
        axes.line(path, colours.get(name, INK), label=name)
    axes.frame("along [m]", "to the left [m]")
    return figure(*SIZE, "Drive over 2 m before and after", axes)
