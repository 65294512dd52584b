"""The wheels: k against the iteration, and the 2 m test drive before and after."""

from __future__ import annotations

from fsm_calib.report.run_record import RunRecord
from fsm_calib.report.run_style import PHASE_COLOURS, figure, svg

TOLERANCE = 0.005
"""Error of k that bends a 2 m drive by 0.10 m: deviation = e s^2 / (2 L) with L = 0.1 m."""
PASS_LIMIT = 0.10
"""The manual's limit of the deviation after 2 m [m]."""


def ratio_history(record: RunRecord) -> str:
    """Return k against the iteration as SVG, with the true value and what a 0.10 m deviation allows."""
    history = record.notebook.ratio_history
    with figure(4.6, 3.0) as fig:
        axes = fig.add_subplot()
        true = (record.result.get("wheels") or {}).get("true_wheel_ratio")
        if true is not None:
            axes.axhspan(true - TOLERANCE, true + TOLERANCE, color="#2a9d5c22", label="0.10 m after 2 m")
            axes.axhline(true, color="#2a9d5c", linewidth=1.0, linestyle="--", label="true")
        axes.plot(range(len(history)), history, marker="o", markersize=4, color="#333333", label="k in use")
        runs = [run.wheel_ratio + run.k_i - 1.0 for run in record.notebook.runs]
        if runs:
            axes.plot(
                range(len(runs)),
                runs,
                marker="x",
                linestyle="none",
                color="#e08214",
                label="k + (kᵢ − 1) of a drive",
            )
        axes.set_xlabel("iteration")
        axes.set_ylabel("wheel ratio k")
        axes.legend(fontsize=8)
        return svg(fig, "Wheel ratio against iteration")


def test_drives(record: RunRecord) -> str:
    """Return the paths of the 2 m test drive before and after as SVG; axes equal would hide the deviation."""
    with figure(4.6, 3.0) as fig:
        axes = fig.add_subplot()
        axes.axhspan(-PASS_LIMIT, PASS_LIMIT, color="#2a9d5c22", label="pass limit 0.10 m")
        colours = {"before": "#d73027", "after": PHASE_COLOURS["wheels"], "after lane": PHASE_COLOURS["lane"]}
        for name, path in record.paths.items():
            axes.plot(path[:, 0], path[:, 1], color=colours.get(name, "#333333"), linewidth=1.8, label=name)
        axes.set_xlabel("along [m]")
        axes.set_ylabel("to the left [m]")
        axes.legend(fontsize=8)
        return svg(fig, "Drive over 2 m before and after")
