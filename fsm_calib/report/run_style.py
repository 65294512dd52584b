"""How figures drawn with matplotlib look: one palette, one type size, vector graphics in the page."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from fsm_calib.report.palette import INK, TEXT

STYLE: Any = {
    "font.size": 9.0,
    "font.family": "sans-serif",
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


def svg(fig: Figure, label: str) -> str:
    """Return the figure as an SVG element that scales with the page; `label` tells what it shows."""
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
    return text.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
