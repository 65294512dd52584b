"""Plots as SVG text: lines, marks, areas and words between two axes.

The figures of a run are few and simple; a plotting library takes 1.5 s to be loaded and to draw them, a tenth of
a whole run. Values are in the units of the axes, sizes in pixels of the figure, which scales with the page.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from fsm_calib.report.palette import INK, TEXT
from fsm_calib.report.plot_scale import Scale
from fsm_calib.types import FloatArray

Limits = tuple[float, float]

_LETTER = 6.0
"""Mean width of a letter of a legend [px]."""
_ROW = 16.0
"""Height of a row of a legend or a title [px]."""
_CROSS = 3.2
"""Half the side of a cross [px]."""
_HEAD = 4.0
"""Length of an arrow's head [px]."""


@dataclass(frozen=True)
class Box:
    """The rectangle between the axes [px], from the figure's top left."""

    left: float
    top: float
    width: float
    height: float

    def shrunk(self, xlim: Limits, ylim: Limits) -> Box:
        """Return the largest box at the top middle of this one in which both axes have one scale."""
        wide, high = abs(xlim[1] - xlim[0]), abs(ylim[1] - ylim[0])
        scale = min(self.width / wide, self.height / high)
        width = scale * wide
        return Box(self.left + 0.5 * (self.width - width), self.top, width, scale * high)


class Axes:
    """What is drawn between two axes, in the order of the calls.

    Parameters
    ----------
    box : Box
        Where in the figure.
    xlim, ylim : (low, high)
        Values at the left and right, and at the bottom and top end.
    """

    def __init__(self, box: Box, xlim: Limits, ylim: Limits) -> None:
        self.box = box
        self.x = Scale(*xlim, box.left, box.left + box.width)
        self.y = Scale(*ylim, box.top + box.height, box.top)
        self._inside: list[str] = []
        self._around: list[str] = []
        self._legend: list[tuple[str, str]] = []

    def line(
        self, points: FloatArray, colour: str, width: float = 1.8, dash: str = "", label: str = ""
    ) -> None:
        """Draw a line through points, shape (n, 2); `dash` as SVG writes it, such as "4 3"."""
        path = "M" + "L".join(self._places(points))
        drawn = f'<path d="{path}" {_stroke(colour, width)} stroke-dasharray="{dash or "none"}"/>'
        self._add(drawn, _swatch_line(colour, width, dash), label)

    def dots(
        self, points: FloatArray, colour: str, size: float = 3.0, opacity: float = 1.0, label: str = ""
    ) -> None:
        """Draw a dot of `size` [px] at each point, shape (n, 2)."""
        path = "".join(f"M{place}h0" for place in self._places(points))
        drawn = f'<path d="{path}" {_stroke(colour, size)} stroke-opacity="{opacity}"/>'
        self._add(drawn, f'<path d="M8-4h0" {_stroke(colour, max(size, 5.0))}/>', label)

    def crosses(self, points: FloatArray, colour: str, label: str = "") -> None:
        """Draw a cross at each point, shape (n, 2)."""
        one = f"m{-_CROSS} {-_CROSS}l{2 * _CROSS} {2 * _CROSS}m0 {-2 * _CROSS}l{-2 * _CROSS} {2 * _CROSS}"
        path = "".join(f"M{place}{one}" for place in self._places(points))
        self._add(
            f'<path d="{path}" {_stroke(colour, 1.4)}/>',
            f'<path d="M8-4{one}" {_stroke(colour, 1.4)}/>',
            label,
        )

    def arrows(self, points: FloatArray, angles: FloatArray, length: float, colour: str) -> None:
        """Draw an arrow from each point, shape (n, 2), `length` long at `angles`, shape (n,) [rad]."""
        ends = points + length * np.column_stack([np.cos(angles), np.sin(angles)])
        heads = []
        for start, end, angle in zip(
            self._places(points), self._places(ends), np.asarray(angles), strict=True
        ):
            barbs = [angle + np.pi + side for side in (-0.4, 0.4)]
            tips = [f"M{end}l{_HEAD * np.cos(barb):.1f} {-_HEAD * np.sin(barb):.1f}" for barb in barbs]
            heads.append(f"M{start}L{end}{tips[0]}{tips[1]}")
        self._inside.append(f'<path d="{"".join(heads)}" {_stroke(colour, 0.9)}/>')

    def areas(
        self, shapes: Iterable[Any], fill: str, opacity: float = 1.0, edge: str = "none", label: str = ""
    ) -> None:
        """Fill polygons, each of shape (n, 2)."""
        path = "".join("M" + "L".join(self._places(np.asarray(shape))) + "Z" for shape in shapes)
        look = f'fill="{fill}" fill-opacity="{opacity}" stroke="{edge}" stroke-width="1.2"'
        self._add(f'<path d="{path}" {look}/>', f'<rect y="-9" width="16" height="9" {look}/>', label)

    def band(self, low: float, high: float, fill: str, label: str = "") -> None:
        """Fill the whole width between two heights, lightly."""
        left, right = self.x.low, self.x.high
        self.areas([[(left, low), (right, low), (right, high), (left, high)]], fill, 0.13, label=label)

    def image(self, href: str) -> None:
        """Show a picture over the whole box, its pixels blended."""
        box = self.box
        where = f'x="{box.left}" y="{box.top}" width="{box.width}" height="{box.height}"'
        self._inside.append(f'<image {where} preserveAspectRatio="none" href="{href}"/>')

    def words(self, x: float, y: float, text: str, colour: str = TEXT) -> None:
        """Write text beginning at a point; a line break begins a new line below."""
        (place,) = self._places(np.array([(x, y)]))
        left, top = place.split(" ")
        for row, part in enumerate(text.split("\n")):
            self._inside.append(_text(float(left), float(top) + 13.0 * row, part, colour, size=11))

    def frame(self, xlabel: str, ylabel: str, title: str = "", least_step: float = 0.0) -> None:
        """Draw the axes with ticks, their labels, the legend and a title; ticks of x are `least_step` apart."""
        self.x_axis(xlabel, least_step)
        box = self.box
        for value, label in self.y.ticks():
            place = float(self.y(value))
            self._around.append(_line(box.left - 4, place, box.left, place))
            self._around.append(_text(box.left - 7, place + 4, label, anchor="end"))
        self._around.append(_line(box.left, box.top, box.left, box.top + box.height))
        turned = f'transform="translate({box.left - 44:.1f} {box.top + 0.5 * box.height:.1f}) rotate(-90)"'
        self._around.append(f"<g {turned}>{_text(0, 0, ylabel, INK, 'middle')}</g>")
        rows = self._draw_legend()
        if title:
            above = box.top - 8 - _ROW * rows
            self._around.append(f'<g font-weight="bold">{_text(box.left, above, title, INK)}</g>')

    def x_axis(self, label: str, least_step: float = 0.0, grid: bool = False) -> None:
        """Draw the axis below the box, with a grid behind what is drawn later where it is asked for."""
        box = self.box
        bottom = box.top + box.height
        for value, text in self.x.ticks(least_step=least_step):
            place = float(self.x(value))
            if grid:
                self._around.append(_line(place, box.top, place, bottom, "#e3e3e3"))
            self._around.append(_line(place, bottom, place, bottom + 4))
            self._around.append(_text(place, bottom + 16, text, anchor="middle"))
        self._around.append(_line(box.left, bottom, box.left + box.width, bottom))
        self._around.append(_text(box.left + 0.5 * box.width, bottom + 34, label, INK, "middle"))

    def label_row(self, y: float, text: str) -> None:
        """Write text to the left of the box at a height."""
        self._around.append(_text(self.box.left - 7, float(self.y(y)) + 4, text, anchor="end"))

    def svg(self, name: str) -> str:
        """Return all of it as SVG; `name` is its own in the page."""
        box = self.box
        clip = f'<clipPath id="{name}"><rect x="{box.left - 2:.1f}" y="{box.top - 2:.1f}" '
        clip += f'width="{box.width + 4:.1f}" height="{box.height + 4:.1f}"/></clipPath>'
        inside = "\n".join(self._inside)
        return f'{clip}{"".join(self._around)}\n<g clip-path="url(#{name})">{inside}</g>'

    def _add(self, drawn: str, swatch: str, label: str) -> None:
        """Keep what was drawn, and its entry of the legend."""
        self._inside.append(drawn)
        if label:
            self._legend.append((swatch, label))

    def _places(self, points: FloatArray) -> list[str]:
        """Return points as text, a tenth of a pixel fine."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        x, y = self.x(points[:, 0]).tolist(), self.y(points[:, 1]).tolist()
        return [f"{u:.1f} {v:.1f}" for u, v in zip(x, y, strict=True)]

    def _draw_legend(self) -> int:
        """Write the legend in rows above the box; return how many."""
        rows: list[list[str]] = []
        at = self.box.width
        for swatch, label in self._legend:
            width = 20.0 + _LETTER * len(label) + 12.0
            if not rows or at + width > self.box.width + 12.0:
                rows.append([])
                at = 0.0
            entry = f'<g transform="translate({at:.1f} 0)">{swatch}{_text(20, 0, label, size=11)}</g>'
            rows[-1].append(entry)
            at += width
        for number, row in enumerate(rows):
            height = self.box.top - 10.0 - _ROW * (len(rows) - 1 - number)
            self._around.append(
                f'<g transform="translate({self.box.left:.1f} {height:.1f})">{"".join(row)}</g>'
            )
        return len(rows)


def figure(width: float, height: float, label: str, *axes: Axes, extra: Sequence[str] = ()) -> str:
    """Return a figure as an SVG element that scales with the page; `label` tells what it shows."""
    prefix = re.sub(r"\W+", "-", label.lower())
    parts = [part.svg(f"{prefix}-{number}") for number, part in enumerate(axes)]
    head = f'<svg role="img" aria-label="{escape(label)}" viewBox="0 0 {width:g} {height:g}" font-size="12"'
    return "\n".join([f'{head} xmlns="http://www.w3.org/2000/svg">', *parts, *extra, "</svg>"])


def _stroke(colour: str, width: float) -> str:
    return f'fill="none" stroke="{colour}" stroke-width="{width:g}" stroke-linecap="round" stroke-linejoin="round"'


def _swatch_line(colour: str, width: float, dash: str) -> str:
    return f'<path d="M0-4h16" {_stroke(colour, width)} stroke-dasharray="{dash or "none"}"/>'


def _line(x0: float, y0: float, x1: float, y1: float, colour: str = "#777777") -> str:
    return f'<path d="M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}" stroke="{colour}" stroke-width="0.8"/>'


def _text(
    x: float, y: float, text: str, colour: str = TEXT, anchor: str = "start", size: float | None = None
) -> str:
    look = f' font-size="{size:g}"' if size else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}"{look}>{escape(text)}</text>'
