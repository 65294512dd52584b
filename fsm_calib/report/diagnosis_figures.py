"""The figures of a diagnosis: errors over time under a ribbon of states, on the floor, paths, and the ranking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from fsm_calib.diagnosis.proof.windows import Windows
from fsm_calib.report.diagnosis_paths import Drive
from fsm_calib.report.palette import AFTER, BEFORE, BOARD_COLOURS, FLOOR, MEASURED, PHASE_COLOURS
from fsm_calib.report.run_style import Margins, figure, svg

HOLE = 1.0
"""Time without windows over which no line is drawn [s]."""
NAMED_STATES = 15
"""States that the ribbon's legend names."""
SPREAD = 0.98
"""Share of errors inside the colour scale: a lone jump of the tracker must not darken the rest."""


def error_over_time(drive: Drive, when: Sequence[tuple[float, float]] = ()) -> str:
    """Return position and heading errors over the horizon against time, states as a ribbon above.

    `when` are spans [s] in which the mismatch was located; they are shaded.
    """
    rows = [r for r in (0, 1) if drive.placed or r == 1]
    heights = ([0.16] if drive.states else []) + [1.0] * len(rows)
    legend = 0.2 * -(-min(len({name for *_, name in drive.states}), NAMED_STATES) // 5)
    with figure(11.0, 0.6 + legend + 1.7 * len(rows), Margins(top=0.1 + legend)) as fig:
        axes = fig.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
        fig.subplots_adjust(hspace=0.12)
        if drive.states:
            _ribbon(axes[0], drive)
        for axis, row in zip(axes[-len(rows) :], rows, strict=True):
            _errors(axis, drive, row)
            for begin, end in when:
                axis.axvspan(begin, end, color=BEFORE, alpha=0.15, linewidth=0)
        axes[-1].set(xlabel="time [s]", xlim=(float(drive.time[0]), float(drive.time[-1])))
        axes[-len(rows)].legend(loc="upper right", ncols=3, fontsize=8)
        return svg(fig, f"Error over time, {drive.title}", dict.fromkeys(axes[-len(rows) :], "time"))


def _errors(axis: Axes, drive: Drive, row: int) -> None:
    """Draw one row: 0 position [mm], 1 heading [deg]."""
    for windows, colour, name in ((drive.before, BEFORE, "before"), (drive.after, AFTER, "after")):
        axis.plot(*unjoined(windows.time, sizes(windows, row)), color=colour, linewidth=1.0, label=name)
    scale = 1e3 if row == 0 else np.degrees(1.0)
    floor = unjoined(drive.after.time, drive.after.floor[:, row] * scale)
    axis.plot(*floor, color=FLOOR, linewidth=1.0, label="noise floor")
    every = np.concatenate([sizes(drive.before, row), sizes(drive.after, row)])
    top = float(np.quantile(every, SPREAD)) if len(every) else 1.0
    axis.set(ylim=(0.0, 1.25 * max(top, 1e-6)), ylabel="position [mm]" if row == 0 else "heading [deg]")


def unjoined(time: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a line that is interrupted (NaN) where no window ended for longer than `HOLE`."""
    holes = np.flatnonzero(np.diff(time) > HOLE) + 1
    return np.insert(time, holes, np.nan), np.insert(value, holes, np.nan)


def sizes(windows: Windows, row: int) -> np.ndarray:
    """Return the size of each window's error: position [mm] (row 0) or heading [deg] (row 1)."""
    if row == 0:
        return np.asarray(1e3 * np.hypot(windows.error[:, 0], windows.error[:, 1]))
    return np.asarray(np.degrees(np.abs(windows.error[:, 2])))


def _ribbon(axis: Axes, drive: Drive) -> None:
    """Draw the machine's states as coloured bars, with a legend."""
    names = list(dict.fromkeys(name for *_, name in drive.states))
    for name in names:
        colour = state_colour(name, names)
        bars = [(start, end - start) for start, end, state in drive.states if state == name]
        label = name if names.index(name) < NAMED_STATES else None
        axis.broken_barh(bars, (0.0, 1.0), color=colour, alpha=0.8, linewidth=0, label=label)
    axis.set(yticks=[], ylim=(0.0, 1.0))
    axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, fontsize=7, borderaxespad=0.1)
    axis.spines[["left", "bottom"]].set_visible(False)


def state_colour(name: str, names: list[str]) -> str:
    """Return the colour of a state: its phase's where the state is a phase, else one of a row."""
    taken = {PHASE_COLOURS[n] for n in names if n in PHASE_COLOURS}
    palette = [c for c in dict.fromkeys([*BOARD_COLOURS, *PHASE_COLOURS.values()]) if c not in taken]
    others = [n for n in names if n not in PHASE_COLOURS]
    return PHASE_COLOURS.get(name) or palette[others.index(name) % len(palette)]


def error_on_floor(drive: Drive, where: Mapping[str, float] | None = None) -> str:
    """Return where the errors were made: heading errors beside position errors are in the time plot.

    `where` (x, y, radius [m]) is drawn as a circle: there the mismatch was located.
    """
    with figure(11.0, 4.2) as fig:
        pair = fig.subplots(1, 2, sharex=True, sharey=True)
        top = max(float(np.quantile(sizes(drive.before, 0), SPREAD)), 1.0) if len(drive.before.time) else 1.0
        for axis, windows, name in zip(pair, (drive.before, drive.after), ("before", "after"), strict=True):
            axis.plot(drive.path[:, 0], drive.path[:, 1], color="#cccccc", linewidth=0.7, zorder=0)
            place = drive.place_of(windows)
            dots = axis.scatter(
                place[:, 0], place[:, 1], c=sizes(windows, 0), s=12, cmap="inferno_r", vmin=0.0, vmax=top
            )
            axis.set(aspect="equal", title=name, xlabel="x [m]")
            if where:
                ring = Circle(
                    (where["x"], where["y"]), where["radius"], fill=False, color=BEFORE, linewidth=1.5
                )
                axis.add_patch(ring)
        pair[0].set_ylabel("y [m]")
        fig.subplots_adjust(right=0.9)
        bar = fig.add_axes((0.915, 0.12, 0.012, 0.78))
        fig.colorbar(dots, cax=bar, label="position error [mm]")
        return svg(fig, f"Error on the floor, {drive.title}", dict.fromkeys(pair, "floor"))


def paths(drive: Drive) -> str:
    """Return measured and predicted paths; a prediction starts afresh every few seconds."""
    with figure(11.0, 4.2) as fig:
        pair = fig.subplots(1, 2, sharex=True, sharey=True)
        sides = ((drive.paths_before, BEFORE, "before"), (drive.paths_after, AFTER, "after"))
        for axis, (lines, colour, name) in zip(pair, sides, strict=True):
            axis.plot(
                drive.path[:, 0], drive.path[:, 1], color=MEASURED, linewidth=0.8, alpha=0.6, label="measured"
            )
            axis.add_collection(LineCollection(lines, colors=colour, linewidths=1.1, label="predicted"))
            axis.set(aspect="equal", title=name, xlabel="x [m]")
            axis.legend(loc="upper right", fontsize=8)
        pair[0].set_ylabel("y [m]")
        return svg(fig, f"Paths, {drive.title}", dict.fromkeys(pair, "floor"))
