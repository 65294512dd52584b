"""The floor plan: the area as it is drawn for the operator, the driven path, and where views were taken."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fsm_calib.report.pages import beside
from fsm_calib.report.palette import BOARD_COLOURS, BOARD_INKS, INK, PHASE_COLOURS, TEXT
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import limits
from fsm_calib.runner.record import RunRecord
from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.outlines import (
    SHOULDER,
    board_outline,
    marker_squares,
    road_band,
    scene_corners,
    square,
)
from fsm_calib.world2d.scene import BoardPlacement, Road, SceneSpec

LABEL = 0.62
"""Room for the names of boards beside them [m]."""
ARROW = 0.16
"""Length of the arrow that shows where the robot looked from [m]."""
NEAR = 0.62
"""Half the width of the close-up [m]."""
ROAD_GREY = "#8d8d8d"
"""Colour of the road, on which white lines show."""
WALL = "#7a4b2a"
"""Colour of walls."""
PATH_STEP = 0.006
"""Length of path between the points that are drawn [m]: half a pixel of the area."""
SIZE = (400.0, 420.0)
PLACE = Box(58.0, 64.0, 332.0, 300.0)
"""Size of a plan and the room of what is drawn in it [px]."""


def floor_plan(record: RunRecord) -> str:
    """Return the floor plan as two figures: the whole area, and the boards with the views of them."""
    corners = np.vstack([*scene_corners(record.scene), record.track[:, 1:3]])
    xlim, ylim = limits(corners[:, 0]), limits(corners[:, 1])
    xlim = (xlim[0], xlim[1] + LABEL)
    whole = Axes(PLACE.shrunk(xlim, ylim), xlim, ylim)
    x, y = record.track[0, 1:3]
    xlim, ylim = (x - 0.75 * NEAR, x + 1.25 * NEAR), (y - NEAR, y + NEAR)
    near = Axes(PLACE.shrunk(xlim, ylim), xlim, ylim)
    for axes in (whole, near):
        draw_scene(axes, record.scene)
        draw_track(axes, record, is_named=axes is whole)
    draw_views(near, record)
    whole.frame("x [m]", "y [m]", "the area")
    near.frame("x [m]", "y [m]", "around the start: where a board was seen from")
    plans = {"Floor plan with the driven path": whole, "Floor plan around the start": near}
    return beside(*(figure(*SIZE, label, axes) for label, axes in plans.items()))


def draw_scene(axes: Axes, scene: SceneSpec) -> None:
    """Draw boards, markers, lane and walls."""
    if scene.road is not None:
        _draw_road(axes, scene.road)
    if scene.field is not None:
        axes.areas(marker_squares(scene.field), "#c9ced6")
    for number, board in enumerate(scene.boards):
        _draw_board(axes, board, number)
    for wall in scene.walls:
        axes.line(np.array([(wall.x0, wall.y0), (wall.x1, wall.y1)]), WALL, 4.0)
        axes.words(wall.x0, wall.y0, "wall", WALL)


def _draw_board(axes: Axes, placement: BoardPlacement, number: int) -> None:
    """Draw a board's footprint with its number and kind beside it."""
    colour = BOARD_COLOURS[number % len(BOARD_COLOURS)]
    axes.areas([board_outline(placement)], colour, 0.33, edge=colour)
    axes.words(
        placement.x + 0.14,
        placement.y,
        f"board {number}\n{placement.kind}",
        BOARD_INKS[number % len(BOARD_INKS)],
    )


def _draw_road(axes: Axes, road: Road) -> None:
    """Draw the road with its lines and the markers of the refinement section."""
    middle = road.centre_offset
    axes.areas([road_band(road, middle, 2.0 * (road.half_width + SHOULDER))], ROAD_GREY)
    edge = road.half_width - 0.5 * road.white_width
    axes.areas([road_band(road, middle + side, road.white_width) for side in (-edge, edge)], "#ffffff")
    begins = np.arange(0.0, road.length - road.dash, road.dash + road.gap).tolist()
    dashes = [road_band(road, middle, road.yellow_width, begin, begin + road.dash) for begin in begins]
    axes.areas(dashes, "#e6b800")
    along = Pose2(road.start.x, road.start.y, road.start.theta)
    places = [road.first_marker + number * road.marker_pitch for number in range(road.markers)]
    spots = [along.then(Pose2(place, 0.0)) for place in places]
    axes.areas([square(spot.x, spot.y, road.marker_size, road.start.theta) for spot in spots], "#e3e6ea")


def draw_track(axes: Axes, record: RunRecord, is_named: bool, has_robot: bool = True) -> None:
    """Draw the driven path in the colours of the phases, named in the legend or not, and the robot at its end."""
    times, path = record.track[:, 0], record.track[:, 1:3]
    for phase, begin, end in _phases(record):
        inside = (times >= begin - 1e-9) & (times <= end + 1e-9)
        axes.line(
            thinned(path[inside], PATH_STEP), PHASE_COLOURS.get(phase, TEXT), label=phase if is_named else ""
        )
    if has_robot:
        _draw_robot(axes, record)
    axes.dots(np.zeros((1, 2)), INK, 6.0, label="start" if is_named else "")


def _draw_robot(axes: Axes, record: RunRecord) -> None:
    """Draw the robot at the end of its path."""
    last = Pose2(*record.track[-1, 1:4])
    body = [
        last.then(Pose2(*corner))
        for corner in ((0.10, 0.065), (0.10, -0.065), (-0.08, -0.065), (-0.08, 0.065))
    ]
    axes.areas([[(p.x, p.y) for p in body]], "none", edge=INK)
    axes.dots(np.array([(last.x, last.y)]), INK, 3.0)


def thinned(path: FloatArray, step: float) -> FloatArray:
    """Return a path, shape (n, 2) [m], with a point for every `step` [m] of its length, and its last."""
    if len(path) < 3:
        return path
    driven = np.cumsum(np.hypot(*np.diff(path, axis=0, prepend=path[:1]).T)) // step
    kept = np.diff(driven, prepend=-1.0) > 0.0
    kept[-1] = True
    return path[kept]


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
    for board in sorted({int(event["board"]) for event in seen}):
        poses = np.array([event["pose"] for event in seen if event["board"] == board])
        axes.arrows(poses[:, :2], poses[:, 2], ARROW, BOARD_COLOURS[board % len(BOARD_COLOURS)])
