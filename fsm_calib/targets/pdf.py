"""Writes sheets as one PDF at true scale, all of it vectors; the same sheets give the same bytes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outlines

from fsm_calib.errors import InputError
from fsm_calib.targets.sheet import Line, Shape, Sheet, Words

MM_PER_INCH = 25.4
POINTS_PER_MM = 72.0 / MM_PER_INCH


def write_pdf(path: Path, sheets: Sequence[Sheet], title: str) -> None:
    """Write a PDF of one page for each sheet.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    about = {"Title": title, "Creator": "fsm-calib targets", "Producer": "", "CreationDate": None}
    try:
        with rc_context({"pdf.fonttype": 42, "path.simplify": False}), PdfPages(path, metadata=about) as pdf:
            for sheet in sheets:
                pdf.savefig(_drawn(sheet))
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", where=str(path)) from error


def _drawn(sheet: Sheet) -> Figure:
    """Return a sheet as a figure of its size; the axes are the sheet, in millimetres."""
    figure = Figure(figsize=(sheet.width / MM_PER_INCH, sheet.height / MM_PER_INCH))
    FigureCanvasPdf(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, sheet.width), ylim=(0.0, sheet.height))
    axes.axis("off")
    for item in sheet.content:
        if isinstance(item, Shape):
            _draw_shape(axes, item)
        elif isinstance(item, Line):
            _draw_line(axes, item)
        else:
            _draw_words(axes, item)
    return figure


def _draw_shape(axes: Axes, shape: Shape) -> None:
    path = Outlines.make_compound_path(*(Outlines([*o, o[0]], closed=True) for o in shape.outlines))
    axes.add_artist(
        PathPatch(
            path,
            facecolor=shape.fill or "none",
            edgecolor=shape.edge or "none",
            linewidth=shape.width * POINTS_PER_MM,
            joinstyle="miter",
        )
    )


def _draw_line(axes: Axes, line: Line) -> None:
    x, y = zip(*line.points, strict=True)
    width = line.width * POINTS_PER_MM
    drawn = Line2D(x, y, color=line.colour, linewidth=width, solid_capstyle="butt")
    axes.add_artist(drawn)
    if line.dash:
        drawn.set_dashes([part / line.width for part in line.dash])  # in widths of the line


def _draw_words(axes: Axes, words: Words) -> None:
    anchor = {"middle": "center"}.get(words.anchor, words.anchor)
    size = words.size * POINTS_PER_MM
    axes.text(
        words.x, words.y, words.text, fontsize=size, ha=anchor, va="baseline", color=words.colour,
        rotation=words.turn, rotation_mode="anchor",
    )  # fmt: skip
