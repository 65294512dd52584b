"""The outlines of everything in the calibration area, seen from above [m]: for plans and clearances."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, Road, SceneSpec

SHOULDER = 0.03
"""Road beyond its white lines, so that they show [m]."""


def scene_corners(scene: SceneSpec) -> list[Any]:
    """Return the corners of everything in the area, each of shape (n, 2) [m]."""
    shapes = [board_outline(board) for board in scene.boards]
    shapes += [np.array([(wall.x0, wall.y0), (wall.x1, wall.y1)]) for wall in scene.walls]
    if scene.field is not None:
        shapes += marker_squares(scene.field)
    if scene.road is not None:
        middle = scene.road.centre_offset
        shapes.append(np.array(road_band(scene.road, middle, 2.0 * (scene.road.half_width + SHOULDER))))
    return shapes


def square(x: float, y: float, side: float, heading: float) -> np.ndarray:
    """Return the corners of a square, shape (4, 2) [m]."""
    corners = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]) * 0.5 * side
    c, s = math.cos(heading), math.sin(heading)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def marker_squares(field: MarkerField) -> list[FloatArray]:
    """Return the floor markers at their places in the drawing; the printed area differs by millimetres."""
    shapes = []
    for row in range(field.rows):
        y = (0.5 * (field.rows - 1) - row) * field.pitch
        for column in range(field.columns):
            if field.first_id + row * field.columns + column in field.missing:
                continue
            shapes.append(square(field.first_x - column * field.pitch, y, field.size, field.heading))
    return shapes


def board_outline(placement: BoardPlacement) -> FloatArray:
    """Return a board's footprint: a thin line when it stands, an area when it leans or lies."""
    depth = max(placement.height * math.sin(placement.lean), 0.006)
    corners = np.array([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]) * (depth, placement.width)
    c, s = math.cos(placement.yaw), math.sin(placement.yaw)
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + (placement.x, placement.y))


def road_band(
    road: Road, offset: float, width: float, begin: float = 0.0, end: float | None = None
) -> list[tuple[float, float]]:
    """Return the corners of a band along the road, its middle `offset` to the left of the line driven [m]."""
    along = Pose2(road.start.x, road.start.y, road.start.theta)
    corners = [(begin, offset - width / 2), (end or road.length, offset - width / 2)]
    corners += [(x, y + width) for x, y in reversed(corners)]
    points = [along.then(Pose2(x, y)) for x, y in corners]
    return [(p.x, p.y) for p in points]
