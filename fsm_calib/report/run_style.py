"""How figures drawn with matplotlib look: one palette, one type size, vector graphics in the page."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fsm_calib.report.palette import INK, TEXT

STYLE: Any = {
    "font.size": 9.0,
    "font.family": "sans-serif",
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#777777",
    "axes.labelcolor": INK,
    "xtick.color": TEXT,
    "ytick.color": TEXT,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "fsm_calib",
    "figure.dpi": 100.0,
    "path.simplify": True,
}
"""Settings of matplotlib; a fixed salt and no date make the same run give the same picture."""


@dataclass(frozen=True)
class Margins:
    """Room around the axes of a figure [inch]; fixed, because finding it by drawing takes as long as drawing."""

    left: float = 0.62
    right: float = 0.12
    bottom: float = 0.46
    top: float = 0.28


@contextmanager
def figure(width: float, height: float, margins: Margins = Margins()) -> Iterator[Figure]:
    """Yield an empty figure of `width` x `height` [inch] in the report's style."""
    with matplotlib.rc_context(STYLE):
        fig = Figure(figsize=(width, height))
        fig.subplots_adjust(
            left=margins.left / width,
            right=1.0 - margins.right / width,
            bottom=margins.bottom / height,
            top=1.0 - margins.top / height,
        )
        yield fig


def svg(fig: Figure, label: str, cursor: Mapping[Axes, str] | None = None) -> str:
    """Return the figure as an SVG element that scales with the page; `label` tells what it shows.

    `cursor` says which axes share the page's cursor, and what they show: "time" along x, or the "floor".
    """
    buffer = io.StringIO()
    fig.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    # matplotlib sets how lines end for everything in the page; here for this figure alone
    text = re.sub(r"<style[^>]*>.*?</style>", "", text, flags=re.S)
    text = text.replace("<svg", '<svg style="stroke-linejoin: round; stroke-linecap: butt"', 1)
    prefix = re.sub(r"\W+", "-", label.lower())
    text = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', text)
    text = re.sub(r'(href="|url\()#([^")]+)', rf"\1#{prefix}-\2", text)
    places = [_place(axes, kind) for axes, kind in (cursor or {}).items()]
    shared = f" data-axes='{json.dumps(places)}'" if places else ""
    return text.replace("<svg", f'<svg role="img" aria-label="{label}"{shared}', 1)


def _place(axes: Axes, kind: str) -> list[str | float]:
    """Return what axes show and where: kind, left, top, width, height [pt], limits of x and of y, as drawn."""
    whole = axes.get_figure(root=True)
    if whole is None:
        raise ValueError("axes of no figure")
    width, height = 72.0 * whole.get_size_inches()
    box = axes.get_position()
    frame = (box.x0 * width, (1.0 - box.y1) * height, box.width * width, box.height * height)
    return [kind, *(round(float(value), 4) for value in (*frame, *axes.get_xlim(), *axes.get_ylim()))]
