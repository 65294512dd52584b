"""The whole floor at true scale: one poster, or sheets to lay edge to edge; empty sheets are left out."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.targets.sheet import (
    MARGIN,
    Line,
    Outline,
    Point,
    Shape,
    Sheet,
    Words,
    draw_ruler,
    paper_size,
    rectangle,
)
from fsm_calib.targets.tags import MM, cut_side, dark_cells, placed_tags
from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.scene import BoardPlacement, Road, SceneSpec

Content = list[Shape | Line | Words]
BORDER = 30.0
"""Floor around what lies on it [mm]."""
LABEL = 2.6
"""Height of letters on the floor [mm]."""


@dataclass(frozen=True, slots=True)
class Tile:
    """One sheet of the floor: its name, the place of its printed part's lower left corner in `world` [mm]."""

    name: str
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Tiling:
    """How the floor is cut into sheets: their size and printed part [mm], and those that hold something."""

    page: tuple[float, float]
    used: tuple[float, float]
    tiles: tuple[Tile, ...]


def footprint(board: BoardPlacement) -> Outline:
    """Return the outline of a board's sheet seen from above [mm]: a thin line when it stands upright."""
    depth = MM * max(board.height * math.sin(board.lean), 0.002)
    return _turned(
        rectangle(-0.5 * depth, -0.5 * MM * board.width, depth, MM * board.width), board.x, board.y, board.yaw
    )


def _turned(outline: Outline, x: float, y: float, turn: float) -> Outline:
    """Return an outline [mm] turned by `turn` [rad] about its origin, which is put at (x, y) [m]."""
    c, s = math.cos(turn), math.sin(turn)
    return tuple((MM * x + c * u - s * v, MM * y + s * u + c * v) for u, v in outline)


def road_tape(road: Road) -> tuple[Shape, Shape]:
    """Return the outlines of the road's tapes, to be laid along them [mm]; the yellow one's dashes one by one."""
    half = road.half_width - 0.5 * road.white_width
    sides = tuple(_band(road, side * half, road.white_width, 0.0, road.length) for side in (-1.0, 1.0))
    begins = np.arange(0.0, road.length - road.dash, road.dash + road.gap).tolist()
    dashes = tuple(_band(road, 0.0, road.yellow_width, begin, begin + road.dash) for begin in begins)
    return Shape(sides, "", "#999999", 0.2), Shape(dashes, "", "#e6b800", 0.2)


def _band(road: Road, across: float, width: float, begin: float, end: float) -> Outline:
    """Return a band along the road, its middle `across` to the left of the road's middle [m], as an outline [mm]."""
    corners = [(begin, -0.5), (end, -0.5), (end, 0.5), (begin, 0.5)]
    placed = [road.start.then(Pose2(u, road.centre_offset + across + side * width)) for u, side in corners]
    return tuple((MM * p.x, MM * p.y) for p in placed)


def floor_content(scene: SceneSpec) -> Content:
    """Return everything on the floor in `world` [mm], seen from above: x to the right, y up."""
    content: Content = [*road_tape(scene.road)] if scene.road else []
    for tag in placed_tags(scene):
        x, y, side = MM * tag.pose.x, MM * tag.pose.y, cut_side(tag.size)
        paper = _turned(
            rectangle(-0.5 * side, -0.5 * side, side, side), tag.pose.x, tag.pose.y, tag.pose.theta
        )
        content.append(Shape((paper,), fill="white"))
        content.append(Shape(dark_cells(tag.number, x, y, MM * tag.size, tag.pose.theta)))
        content.append(Words(x, y - 0.5 * side - LABEL, f"{tag.number}", LABEL, "middle"))
    for number, board in enumerate(scene.boards):
        outline = footprint(board)
        content.append(Line((*outline, outline[0]), 0.4, "#555555", (3.0, 2.0)))
        content.append(
            Words(MM * board.x + 5.0, MM * board.y, f"board {number}, {board.kind}", 4.0, colour="#555555")
        )
    return [*content, *_start_mark()]


def _start_mark() -> Content:
    """Return the mark where the robot's axle stands at the start, and where it looks."""
    cross = [Line(((-15.0, 0.0), (25.0, 0.0)), 0.4), Line(((0.0, -15.0), (0.0, 15.0)), 0.4)]
    head = Shape((((32.0, 0.0), (24.0, 3.0), (24.0, -3.0)),))
    return [*cross, head, Words(4.0, 4.0, "start: middle of the axle, facing x", LABEL)]


def extent(scene: SceneSpec) -> tuple[float, float, float, float]:
    """Return low x, low y, high x, high y of the floor that is drawn [mm]."""
    points = np.vstack([_points(item) for item in floor_content(scene)])
    (x0, y0), (x1, y1) = points.min(axis=0) - BORDER, points.max(axis=0) + BORDER
    return float(x0), float(y0), float(x1), float(y1)


def _points(item: Shape | Line | Words) -> FloatArray:
    if isinstance(item, Shape):
        return np.array([point for outline in item.outlines for point in outline])
    return np.array([(item.x, item.y)] if isinstance(item, Words) else item.points)


def moved(content: Iterable[Shape | Line | Words], dx: float, dy: float, scale: float = 1.0) -> Content:
    """Return content moved after it was scaled: (x, y) goes to (scale x + dx, scale y + dy) [mm]."""

    def place(points: tuple[Point, ...]) -> tuple[Point, ...]:
        return tuple((scale * x + dx, scale * y + dy) for x, y in points)

    found: Content = []
    for item in content:
        if isinstance(item, Shape):
            found.append(
                replace(item, outlines=tuple(place(o) for o in item.outlines), width=scale * item.width)
            )
        elif isinstance(item, Line):
            dash = tuple(scale * part for part in item.dash)
            found.append(
                replace(item, points=place(item.points), width=max(scale * item.width, 0.2), dash=dash)
            )
        else:
            ((x, y),) = place(((item.x, item.y),))
            found.append(replace(item, x=x, y=y))
    return found


def poster(scene: SceneSpec) -> Sheet:
    """Return the floor as one sheet at true scale, for a print shop."""
    x0, y0, x1, y1 = extent(scene)
    sheet = Sheet(x1 - x0, y1 - y0)
    sheet.content += moved(floor_content(scene), -x0, -y0)
    draw_ruler(sheet, 10.0, 6.0, 500)
    sheet.content.append(Words(520.0, 7.0, "must measure 500 mm", 4.0))
    return sheet


def tiling(scene: SceneSpec, paper: str) -> Tiling:
    """Return how the floor is cut into the fewest sheets."""
    return min(
        (_tiling(scene, paper_size(paper, wide=wide)) for wide in (False, True)), key=lambda t: len(t.tiles)
    )


def _tiling(scene: SceneSpec, page: tuple[float, float]) -> Tiling:
    used = page[0] - 2.0 * MARGIN, page[1] - 2.0 * MARGIN
    x0, y0, x1, y1 = extent(scene)
    boxes = _needed(scene)
    columns, rows = math.ceil((x1 - x0) / used[0]), math.ceil((y1 - y0) / used[1])
    tiles = []
    for row in reversed(range(rows)):
        for column in range(columns):
            x, y = x0 + column * used[0], y0 + row * used[1]
            inside = (boxes[:, :2] < (x + used[0], y + used[1])).all(axis=1) & (boxes[:, 2:] > (x, y)).all(
                axis=1
            )
            if inside.any():
                tiles.append(Tile(f"{_letters(rows - 1 - row)}{column + 1}", x, y))
    return Tiling(page, used, tuple(tiles))


def _letters(number: int) -> str:
    """Return A to Z, then AA and on."""
    return chr(65 + number) if number < 26 else _letters(number // 26 - 1) + chr(65 + number % 26)


def _needed(scene: SceneSpec) -> FloatArray:
    """Return the boxes that must be printed, shape (n, 4): tags, footprints and the start [mm]."""
    boxes = [(-15.0, -15.0, 32.0, 15.0)]
    for tag in placed_tags(scene):
        half = 0.5 * cut_side(tag.size)
        x, y = MM * tag.pose.x, MM * tag.pose.y
        boxes.append((x - half, y - half, x + half, y + half))
    for board in scene.boards:
        points = np.array(footprint(board))
        boxes.append((*points.min(axis=0).tolist(), *points.max(axis=0).tolist()))
    return np.array(boxes)


def area_sheets(scene: SceneSpec, paper: str) -> list[Sheet]:
    """Return the floor as sheets at true scale, each with its border to cut or overlap at, its name and a ruler."""
    cut = tiling(scene, paper)
    content = floor_content(scene)
    return [_tile_sheet(tile, cut, content) for tile in cut.tiles]


def _tile_sheet(tile: Tile, cut: Tiling, content: Content) -> Sheet:
    sheet = Sheet(*cut.page)
    dx, dy = MARGIN - tile.x, MARGIN - tile.y
    near = [item for item in content if _touches(_points(item), tile, cut.used)]
    sheet.content += moved(near, dx, dy)
    frame = rectangle(MARGIN, MARGIN, *cut.used)
    sheet.content.append(Line((*frame, frame[0]), 0.15, "#888888", (2.0, 2.0)))
    said = (
        f"{tile.name} · lower left corner x {tile.x / MM:+.4f} m, y {tile.y / MM:+.4f} m · lay edge to edge"
    )
    sheet.content.append(Words(MARGIN + 2.0, cut.page[1] - 6.0, said, 2.6))
    draw_ruler(sheet, MARGIN, 2.0, 150)
    sheet.content.append(Words(MARGIN + 156.0, 3.0, "150 mm", 2.6))
    return sheet


def _touches(points: FloatArray, tile: Tile, used: tuple[float, float]) -> bool:
    """Tell whether the box around points reaches into a tile or its margin."""
    low, high = points.min(axis=0) - 60.0, points.max(axis=0) + 60.0
    return bool((low < (tile.x + used[0], tile.y + used[1])).all() and (high > (tile.x, tile.y)).all())
