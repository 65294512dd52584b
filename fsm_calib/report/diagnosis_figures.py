"""The figures of a diagnosis: errors over time under a ribbon of states, on the floor, paths, and the ranking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from fsm_calib.diagnosis.proof.windows import Windows
from fsm_calib.report.diagnosis_paths import Drive
from fsm_calib.report.pages import beside
from fsm_calib.report.palette import AFTER, BEFORE, BOARD_COLOURS, FLOOR, MEASURED, PHASE_COLOURS
from fsm_calib.report.run_style import Margins, figure, svg

HOLE = 1.0
"""Time without windows over which no line is drawn [s]."""
NAMED_STATES = 15
"""States that the ribbon's legend names."""
MAP_WIDTH = 5.5
"""Width of one of two maps beside each other [inch]."""
MAP_HEIGHTS = (1.9, 4.4)
"""Least and largest height of a map [inch]: as the drive needs it."""
MAP_ROOM = Margins(left=0.8)
LEGEND_ROOM = 0.25
"""Height that the names of the lines take above the axes [inch]."""
SPREAD = 0.98
"""Share of errors inside the colour scale: a lone jump of the tracker must not darken the rest."""


def error_over_time(drive: Drive, when: Sequence[tuple[float, float]] = ()) -> str:
    """Return position and heading errors over the horizon against time, states as a ribbon above.

    `when` are spans [s] in which the mismatch was located; they are shaded.
    """
    rows = [r for r in (0, 1) if drive.placed or r == 1]
    heights = ([0.16] if drive.states else []) + [1.0] * len(rows)
    legend = 0.2 * -(-min(len({name for *_, name in drive.states}), NAMED_STATES) // 5)
    top = LEGEND_ROOM + legend
    with figure(11.0, 0.5 + top + 1.7 * len(rows), Margins(top=top)) as fig:
        axes = fig.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
        fig.subplots_adjust(hspace=0.12)
        if drive.states:
            _ribbon(axes[0], drive)
        for axis, row in zip(axes[-len(rows) :], rows, strict=True):
            _errors(axis, drive, row)
            for begin, end in when:
                axis.axvspan(begin, end, color=BEFORE, alpha=0.15, linewidth=0)
        axes[-1].set(xlabel="time [s]", xlim=(float(drive.time[0]), float(drive.time[-1])))
        fig.legend(
            *axes[-1].get_legend_handles_labels(), loc="upper right", ncols=3, fontsize=8, borderaxespad=0.1
        )
        return svg(fig, f"Error over time, {drive.title}", dict.fromkeys(axes[-len(rows) :], "time"))


def sides(drive: Drive) -> list[tuple[str, str, Windows, list[np.ndarray]]]:
    """Return name, colour, errors and predicted paths of what is compared: one side alone where nothing was found."""
    if not drive.is_improved:
        return [("base robot", BEFORE, drive.before, drive.paths_before)]
    return [
        ("before", BEFORE, drive.before, drive.paths_before),
        ("after", AFTER, drive.after, drive.paths_after),
    ]


def _errors(axis: Axes, drive: Drive, row: int) -> None:
    """Draw one row: 0 position [mm], 1 heading [deg]."""
    for name, colour, windows, _ in sides(drive):
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
    """Return where the errors were made, of each side: heading errors beside position errors are in the time plot.

    `where` (x, y, radius [m]) is drawn as a circle: there the mismatch was located.
    """
    top = max(float(np.quantile(sizes(drive.before, 0), SPREAD)), 1.0) if len(drive.before.time) else 1.0
    both = []
    for name, _, windows, _ in sides(drive):
        with _map_figure(drive.path) as fig:
            axis = fig.add_subplot()
            axis.plot(drive.path[:, 0], drive.path[:, 1], color="#cccccc", linewidth=0.7, zorder=0)
            place = drive.place_of(windows)
            dots = axis.scatter(
                place[:, 0], place[:, 1], c=sizes(windows, 0), s=12, cmap="inferno_r", vmin=0.0, vmax=top
            )
            if where:
                middle = (where["x"], where["y"])
                axis.add_patch(Circle(middle, where["radius"], fill=False, color=BEFORE, linewidth=1.5))
            _map(axis, f"errors, {name}", drive.path)
            fig.colorbar(dots, ax=axis, label="position error [mm]", shrink=0.8)
            fig.canvas.draw()  # the colours take their room from the axes
            both.append(svg(fig, f"Error on the floor {name}, {drive.title}", {axis: "floor"}))
    return beside(*both)


def paths(drive: Drive) -> str:
    """Return measured and predicted paths, of each side; a prediction starts afresh every few seconds."""
    drawn = sides(drive)
    every = np.concatenate([drive.path[:, :2], *(line for *_, lines in drawn for line in lines)])
    both = []
    for name, colour, _, lines in drawn:
        with _map_figure(every) as fig:
            axis = fig.add_subplot()
            axis.plot(
                drive.path[:, 0], drive.path[:, 1], color=MEASURED, linewidth=0.8, alpha=0.6, label="measured"
            )
            axis.add_collection(LineCollection(lines, colors=colour, linewidths=1.1, label="predicted"))
            _map(axis, f"paths, {name}", every)
            fig.canvas.draw()  # one scale for both axes makes the box narrower or lower
            fig.legend(
                loc="upper right", ncols=2, fontsize=8, borderaxespad=0.1
            )  # where no narrow map's title is
            both.append(svg(fig, f"Paths {name}, {drive.title}", {axis: "floor"}))
    return beside(*both)


def _map_figure(shown: np.ndarray) -> AbstractContextManager[Figure]:
    """Return an empty figure as high as a map of points (x, y, ...) [m] needs it."""
    wide, high = np.maximum(np.nanmax(shown[:, :2], axis=0) - np.nanmin(shown[:, :2], axis=0), 1e-3)
    around = MAP_ROOM.bottom + MAP_ROOM.top
    height = around + (MAP_WIDTH - MAP_ROOM.left - MAP_ROOM.right) * high / wide
    return figure(MAP_WIDTH, float(np.clip(height, *MAP_HEIGHTS)), MAP_ROOM)


def _map(axis: Axes, title: str, shown: np.ndarray) -> None:
    """Make axes a map of the floor that holds points (x, y, ...) [m], the same before and after."""
    low, high = np.nanmin(shown[:, :2], axis=0), np.nanmax(shown[:, :2], axis=0)
    margin = 0.05 * max(float(np.max(high - low)), 0.02)
    axis.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axis.set(aspect="equal", title=title, xlabel="x [m]", ylabel="y [m]")
