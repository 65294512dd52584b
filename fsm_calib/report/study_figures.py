"""The figures of a study: 4a, 4b and 4c of the paper, the relations, corrections and sweeps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fsm_calib.report.run_style import figure
from fsm_calib.study.columns import rounded
from fsm_calib.study.summary import PASS_DEVIATION, Summary, VariantFigures
from fsm_calib.types import FloatArray

COLOURS = {
    "by_hand": "#e08214",
    "by_hand_same_solver": "#8c6bb1",
    "automatic": "#2b7bba",
    "test_1": "#2b7bba",
    "test_2": "#2b7bba",
}
"""One colour for each way of calibrating, told apart also without seeing red and green."""
LABELS = {
    "by_hand": "by hand",
    "by_hand_same_solver": "by hand, the robot's solver",
    "automatic": "automatic",
    "test_1": "automatic, the best camera by hand",
    "test_2": "automatic, its own camera",
}
MOST_DOTS = 30
"""Up to this many robots each has its place on the axis, as in the paper; more are drawn sorted."""
_SIZE = (6.4, 3.2)
ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3, "fontsize": 8}
"""Where a legend stands: over the axes, so that it hides no point."""


@contextmanager
def _panel(width: float, height: float) -> Iterator[Figure]:
    """Yield an empty figure of `width` x `height` [inch] whose margins fit its labels."""
    with figure(width, height) as fig:
        fig.set_layout_engine("constrained")
        yield fig


def camera_figure(summary: Summary, name: str, label: str) -> Figure:
    """Return figure 4a: a figure of the camera calibrations [px], robot by robot."""
    with _panel(*_SIZE) as fig:
        axes = fig.add_subplot()
        for way in summary.cameras:
            _series(axes, summary.rows.camera(way, name), way)
        _finish(axes, summary, label)
        axes.set_yscale("log")
        axes.legend(**ABOVE)
    return fig


def deviation_figure(summary: Summary, way: str) -> Figure:
    """Return figure 4b (test 1) or 4c (test 2): deviation after 2 m [m], right positive, robot by robot."""
    with _panel(*_SIZE) as fig:
        axes = fig.add_subplot()
        axes.axhspan(-PASS_DEVIATION, PASS_DEVIATION, color="#2a9d5c", alpha=0.08, lw=0)
        axes.axhline(0.0, color="#777777", lw=0.8)
        for each in ("by_hand", way):
            if each not in summary.deviations:
                continue
            values = summary.rows.deviation(each)
            _series(axes, values, each)
            if len(values) <= MOST_DOTS:
                places = np.arange(1, len(values) + 1)
                axes.plot(places, rounded(values), "_", color=COLOURS[each], ms=11, mew=1.2)
        _finish(axes, summary, "deviation after 2 m [m], right positive")
        axes.legend(**ABOVE)
    return fig


def relation_figure(summary: Summary) -> Figure:
    """Return the size of test 2's deviation [cm] against the camera's figures [px]."""
    shown = (
        ("paper_px", "reprojection error [px]"),
        ("predicted_px", "predicted error [px]"),
        ("true_px", "true error [px]"),
    )
    with _panel(7.6, 2.9) as fig:
        panels = fig.subplots(1, len(shown), sharey=True)
        for axes, (name, label) in zip(panels, shown, strict=True):
            size = 100.0 * np.abs(summary.rows.deviation("test_2"))
            axes.plot(summary.rows.camera("automatic", name), size, "o", color="#2b7bba", ms=4, alpha=0.7)
            axes.set_xlabel(label)
        panels[0].set_ylabel("|deviation| after 2 m [cm]")
    return fig


def corrections_figure(variants: Sequence[VariantFigures]) -> Figure:
    """Return each variant's deviations [cm] as a box beside those of the same robots corrected."""
    names = ["corrected", *(item.variant.name.removeprefix("published:") for item in variants)]
    figures = [variants[0].base_deviation, *(item.deviation for item in variants)]
    with _panel(7.2, 0.6 + 0.36 * len(names)) as fig:
        axes = fig.add_subplot()
        places = np.arange(len(names))[::-1]
        middle = np.array([100.0 * item.median_size.value for item in figures])
        ends = np.array([[100.0 * item.median_size.low, 100.0 * item.median_size.high] for item in figures])
        errors = np.clip(np.abs(ends.T - middle), 0.0, None)
        axes.errorbar(middle, places, xerr=errors, fmt="o", color="#2b7bba", capsize=3, ms=5)
        axes.plot([100.0 * item.largest for item in figures], places, "|", color="#e08214", ms=9, mew=2)
        axes.axvline(100.0 * PASS_DEVIATION, color="#2a9d5c", lw=1.0, ls="--")
        axes.set_yticks(places, [name.replace("_", " ") for name in names])
        axes.set_xscale("log")
        axes.set_xlabel("|deviation| after 2 m [cm]: median with interval, largest (bar), 10 cm (dashed)")
    return fig


def sweep_figure(sweeps: Mapping[str, Sequence[VariantFigures]], units: Mapping[str, str]) -> Figure:
    """Return the median size of the deviation [cm] against the swept values, one panel a sweep.

    The dashed line is that of the same robots with no setting changed.
    """
    columns = min(3, len(sweeps))
    lines = -(-len(sweeps) // columns)
    with _panel(2.6 * columns + 0.4, 2.3 * lines + 0.2) as fig:
        panels = np.atleast_1d(fig.subplots(lines, columns, sharey=True)).ravel()
        for axes, (name, items) in zip(panels, sweeps.items()):
            _sweep_panel(axes, items)
            axes.set_xlabel(f"{name.replace('_', ' ')} [{units.get(name) or '1'}]")
        for axes in panels[len(sweeps) :]:
            axes.set_visible(False)
        for axes in panels[::columns]:
            axes.set_ylabel("|deviation| [cm]")
    return fig


def _sweep_panel(axes: Axes, items: Sequence[VariantFigures]) -> None:
    values = np.array([item.variant.value for item in items])
    medians = [item.deviation.median_size for item in items]
    middle = np.array([100.0 * item.value for item in medians])
    axes.fill_between(
        values,
        [100.0 * item.low for item in medians],
        [100.0 * item.high for item in medians],
        color="#2b7bba",
        alpha=0.18,
        lw=0,
    )
    axes.plot(values, middle, "o-", color="#2b7bba", ms=4)
    axes.axhline(100.0 * items[0].base_deviation.median_size.value, color="#777777", lw=0.8, ls="--")
    axes.set_ylim(bottom=0.0)


def _series(axes: Axes, values: FloatArray, way: str) -> None:
    """Draw one number per robot: in the robots' order, or sorted when they are many."""
    many = len(values) > MOST_DOTS
    shown = np.sort(values) if many else values
    places = np.arange(1, len(shown) + 1)
    size, width = (2.5, 0.0) if many else (5.0, 0.8)
    axes.plot(places, shown, "o-", color=COLOURS[way], alpha=0.85, label=LABELS[way], ms=size, lw=width)
    known = values[np.isfinite(values)]
    if known.size:
        axes.axhline(float(np.mean(known)), color=COLOURS[way], lw=0.8, ls=":")


def _finish(axes: Axes, summary: Summary, label: str) -> None:
    many = summary.robots > MOST_DOTS
    axes.set_xlabel("robots, sorted" if many else "robot")
    axes.set_ylabel(label)
    if not many:
        axes.set_xticks(np.arange(1, summary.robots + 1))
