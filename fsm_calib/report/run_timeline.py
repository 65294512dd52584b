"""The time line: which state was active when, one row for each state, grouped by phase."""

from __future__ import annotations

from fsm_calib.report.palette import PHASE_COLOURS, TEXT
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.runner.record import RunRecord

ROW = 17.0
"""Height of a row [px]."""
LETTER = 6.6
"""Mean width of a letter of a state's name [px]."""
WIDTH = 900.0
SHORTEST = 0.5
"""Shortest stay that is drawn [px], so that none is missing."""


def time_line(record: RunRecord) -> str:
    """Return the time line of states as SVG; states in the order in which they were first entered."""
    rows = list(dict.fromkeys(path for path, _, _ in record.spans))
    names = [path.replace("/", " / ") for path in rows]
    left = 12.0 + LETTER * max(map(len, names))
    box = Box(left, 8.0, WIDTH - left - 12.0, ROW * max(len(rows), 3))
    last = max(end for _, _, end in record.spans)
    axes = Axes(box, (0.0, max(1.02 * last, 1e-3)), (max(len(rows), 3) - 0.5, -0.5))
    axes.x_axis("robot time [s]", grid=True)
    shortest = SHORTEST * axes.x.high / box.width
    for number, (path, name) in enumerate(zip(rows, names, strict=True)):
        stays = [(begin, max(end, begin + shortest)) for where, begin, end in record.spans if where == path]
        low, high = number - 0.36, number + 0.36
        shapes = [[(begin, low), (end, low), (end, high), (begin, high)] for begin, end in stays]
        axes.areas(shapes, PHASE_COLOURS.get(path.split("/")[0], TEXT))
        axes.label_row(number, name)
    return figure(WIDTH, box.top + box.height + 44.0, "Time line of states", axes)
