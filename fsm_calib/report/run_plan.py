"""The floor plan: the area as it is drawn for the operator, the driven path, and where views were taken."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon, Rectangle

from fsm_calib.report.run_record import RunRecord
from fsm_calib.report.run_style import BOARD_COLOURS, PHASE_COLOURS, figure, svg
from fsm_calib.types import Pose2
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, Road, SceneSpec

ARROW = 0.16
"""Length of the arrow that shows where the robot looked from [m]."""
NEAR = 0.62
"""Half the width of the close-up [m]."""
SHOULDER = 0.03
"""Road drawn beyond its white lines, so that they show [m]."""
ROAD_GREY = "#8d8d8d"
"""Colour of the road, on which white lines show."""


def floor_plan(record: RunRecord) -> str:
    """Return the floor plan as SVG."""
    with figure(11.0, 5.6) as fig:
        whole, near = fig.subplots(1, 2, width_ratios=(1.25, 1.0))
        for axes in (whole, near):
            draw_scene(axes, record.scene)
            draw_track(axes, record)
            axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
        whole.margins(x=0.2)
        whole.legend(loc="upper right", fontsize=8)
        whole.set_title("the area")
        draw_views(near, record)
        near.set_title("around the start: where a board was seen from")
        x, y = record.track[0, 1:3]
        near.set(xlim=(x - 0.75 * NEAR, x + 1.25 * NEAR), ylim=(y - NEAR, y + NEAR))
        return svg(fig, "Floor plan with the driven path")


def draw_scene(axes: Axes, scene: SceneSpec) -> None:
    """Draw boards, markers, lane and walls."""
    if scene.road is not None:
        _draw_road(axes, scene.road)
    if scene.field is not None:
        _draw_field(axes, scene.field)
    for number, board in enumerate(scene.boards):
        _draw_board(axes, board, number)
    for wall in scene.walls:
        axes.plot([wall.x0, wall.x1], [wall.y0, wall.y1], color="#7a4b2a", linewidth=4, solid_capstyle="butt")
        axes.annotate("wall", (wall.x0, wall.y0), fontsize=8, color="#7a4b2a")


def _square(x: float, y: float, side: float, heading: float) -> np.ndarray:
    """Return the corners of a square, shape (4, 2) [m]."""
    corners = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]) * 0.5 * side
    c, s = math.cos(heading), math.sin(heading)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def _fill(axes: Axes, shapes: Sequence[Any], colour: str) -> None:
    """Fill polygons, each of shape (n, 2) [m], as one object: each by itself takes ten times as long."""
    axes.add_collection(PolyCollection(shapes, facecolors=colour, edgecolors="none"))


def _draw_field(axes: Axes, field: MarkerField) -> None:
    """Draw the floor markers at their places in the drawing; the printed area differs by millimetres."""
    shapes = []
    for row in range(field.rows):
        y = (0.5 * (field.rows - 1) - row) * field.pitch
        for column in range(field.columns):
            if field.first_id + row * field.columns + column in field.missing:
                continue
            shapes.append(_square(field.first_x - column * field.pitch, y, field.size, field.heading))
    _fill(axes, shapes, "#c9ced6")


def _draw_board(axes: Axes, placement: BoardPlacement, number: int) -> None:
    """Draw a board's footprint: a line when it stands, an area when it leans or lies."""
    colour = BOARD_COLOURS[number % len(BOARD_COLOURS)]
    depth = max(placement.height * math.sin(placement.lean), 0.006)
    width = placement.width
    corners = np.array([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]) * (depth, width)
    c, s = math.cos(placement.yaw), math.sin(placement.yaw)
    corners = corners @ np.array([[c, s], [-s, c]]) + (placement.x, placement.y)
    axes.add_patch(Polygon(corners, facecolor=colour + "55", edgecolor=colour, linewidth=1.2))
    label = f"board {number}\n{placement.kind}"
    spot = (placement.x + 0.14, placement.y)
    axes.annotate(label, spot, fontsize=8, color=colour, va="center", annotation_clip=True, clip_on=True)


def _draw_road(axes: Axes, road: Road) -> None:
    """Draw the road with its lines and the markers of the refinement section."""
    along = Pose2(road.start.x, road.start.y, road.start.theta)

    def band(offset: float, width: float, begin: float = 0.0, end: float | None = None) -> list[Any]:
        corners = [(begin, offset - width / 2), (end or road.length, offset - width / 2)]
        corners += [(x, y + width) for x, y in reversed(corners)]
        points = [along.then(Pose2(x, y)) for x, y in corners]
        return [(p.x, p.y) for p in points]

    middle = road.centre_offset
    _fill(axes, [band(middle, 2.0 * (road.half_width + SHOULDER))], ROAD_GREY)
    edge = road.half_width - 0.5 * road.white_width
    _fill(axes, [band(middle + side, road.white_width) for side in (-edge, edge)], "#ffffff")
    begins = np.arange(0.0, road.length - road.dash, road.dash + road.gap).tolist()
    _fill(axes, [band(middle, road.yellow_width, begin, begin + road.dash) for begin in begins], "#e6b800")
    places = [road.first_marker + number * road.marker_pitch for number in range(road.markers)]
    spots = [along.then(Pose2(place, 0.0)) for place in places]
    squares = [_square(spot.x, spot.y, road.marker_size, road.start.theta) for spot in spots]
    _fill(axes, squares, "#e3e6ea")


def draw_track(axes: Axes, record: RunRecord) -> None:
    """Draw the driven path in the colours of the phases, and the robot where it ended."""
    times, x, y = record.track[:, 0], record.track[:, 1], record.track[:, 2]
    for phase, begin, end in _phases(record):
        inside = (times >= begin - 1e-9) & (times <= end + 1e-9)
        axes.plot(x[inside], y[inside], color=PHASE_COLOURS.get(phase, "#555555"), linewidth=1.6, label=phase)
    last = Pose2(*record.track[-1, 1:4])
    corners = ((0.10, 0.065), (0.10, -0.065), (-0.08, -0.065), (-0.08, 0.065))
    body = [last.then(Pose2(*corner)) for corner in corners]
    outline: dict[str, Any] = {"facecolor": "none", "edgecolor": "#222222", "linewidth": 1.2}
    axes.add_patch(Polygon([(p.x, p.y) for p in body], **outline))
    axes.add_patch(Rectangle((last.x - 0.008, last.y - 0.008), 0.016, 0.016, color="#222222"))
    axes.plot(0.0, 0.0, marker="o", markersize=5, color="#222222", linestyle="none", label="start")


def _phases(record: RunRecord) -> Iterable[tuple[str, float, float]]:
    """Yield (phase, begin, end) [s], each phase once."""
    found: dict[str, tuple[float, float]] = {}
    for path, begin, end in record.spans:
        phase = path.split("/")[0]
        if phase != "between":
            found[phase] = (found.get(phase, (begin, end))[0], end)
    yield from ((phase, begin, end) for phase, (begin, end) in found.items())


def draw_views(axes: Axes, record: RunRecord) -> None:
    """Draw an arrow for every view of a board, from where and in which direction the robot looked."""
    seen = [event for event in record.events if event["trigger"] in ("board_seen", "next_board_seen")]
    poses = np.array([event["pose"] for event in seen]).reshape(-1, 3)
    colours = [BOARD_COLOURS[int(event["board"]) % len(BOARD_COLOURS)] for event in seen]
    if len(poses):
        u, v = ARROW * np.cos(poses[:, 2]), ARROW * np.sin(poses[:, 2])
        form: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.0018}
        axes.quiver(poses[:, 0], poses[:, 1], u, v, color=colours, **form)
