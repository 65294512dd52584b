"""Floor tags to print and cut out, and where each of them lies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fsm_calib.errors import InputError
from fsm_calib.perception.tags import TAG_CELLS, tag_cells
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
from fsm_calib.types import Pose2
from fsm_calib.world2d.scene import SceneSpec

MM = 1000.0
FOOT = 14.0
"""Height of the strip with the ruler below the tags of a sheet [mm]."""
LABEL = 4.5
"""Height of a tag's label, which is cut off or not [mm]."""


@dataclass(frozen=True, slots=True)
class PlacedTag:
    """A floor tag: its number, its pose in `world` (its x axis along theta) [m, rad], its black square's side [m]."""

    number: int
    pose: Pose2
    size: float


def placed_tags(scene: SceneSpec) -> tuple[PlacedTag, ...]:
    """Return every floor tag of an area as the drawing has it: the field's, then the lane's."""
    return (*_field_tags(scene), *_lane_tags(scene))


def _field_tags(scene: SceneSpec) -> Iterator[PlacedTag]:
    field = scene.field
    if field is None:
        return
    for row in range(field.rows):
        y = (0.5 * (field.rows - 1) - row) * field.pitch
        for column in range(field.columns):
            number = field.first_id + row * field.columns + column
            if number not in field.missing:
                x = field.first_x - column * field.pitch
                yield PlacedTag(number, Pose2(x, y, field.heading), field.size)


def _lane_tags(scene: SceneSpec) -> Iterator[PlacedTag]:
    road = scene.road
    for number in range(road.markers if road else 0):
        along = road.first_marker + number * road.marker_pitch  # type: ignore[union-attr]
        yield PlacedTag(road.first_id + number, road.start.then(Pose2(along)), road.marker_size)  # type: ignore[union-attr]


def dark_cells(number: int, x: float, y: float, size: float, turn: float = 0.0) -> tuple[Outline, ...]:
    """Return a tag's dark cells, joined along rows; its middle at (x, y) [mm], side `size` [mm], `turn` [rad]."""
    cell, c, s = size / TAG_CELLS, math.cos(turn), math.sin(turn)

    def placed(corner: Point) -> Point:
        u, v = corner
        return x + c * u - s * v, y + s * u + c * v

    found = []
    for row, cells in enumerate(tag_cells(number).tolist()):
        for begin, end in _runs(cells):
            v = 0.5 * size - (row + 1) * cell
            box = rectangle(begin * cell - 0.5 * size, v, (end - begin) * cell, cell)
            found.append(tuple(placed(corner) for corner in box))
    return tuple(found)


def _runs(cells: Sequence[bool]) -> Iterator[tuple[int, int]]:
    """Yield (begin, end) of each run of dark cells."""
    begin = None
    for place, dark in enumerate([*cells, False]):
        if dark and begin is None:
            begin = place
        elif not dark and begin is not None:
            yield begin, place
            begin = None


def tag_sheets(tags: Sequence[PlacedTag], paper: str) -> list[Sheet]:
    """Return sheets with the tags in order, cutting lines around each, and a ruler on every sheet.

    Raises
    ------
    InputError
        A tag that the paper does not hold.
    """
    if not tags:
        return []
    upright, lying = (_grid(tags, paper_size(paper, wide=wide)) for wide in (False, True))
    wide = lying[0] * lying[1] > upright[0] * upright[1]
    columns, rows = lying if wide else upright
    if not columns * rows:
        raise InputError(f"the tags do not fit on {paper.upper()}", where="--paper", cure="Take a3.")
    size = paper_size(paper, wide=wide)
    count = columns * rows
    return [_tag_sheet(tags[at : at + count], size, columns, rows) for at in range(0, len(tags), count)]


def cut_side(size: float) -> float:
    """Return the side of what is cut out for a tag of `size` [m]: one cell of white on each side [mm]."""
    return MM * size * (1.0 + 2.0 / TAG_CELLS)


def _grid(tags: Sequence[PlacedTag], size: tuple[float, float]) -> tuple[int, int]:
    """Return how many columns and rows of tags a sheet holds."""
    side = max(cut_side(tag.size) for tag in tags)
    return int((size[0] - 2 * MARGIN) // side), int((size[1] - MARGIN - FOOT) // (side + LABEL))


def tag_places(tags: Sequence[PlacedTag], size: tuple[float, float], columns: int, rows: int) -> list[Point]:
    """Return the middles of the tags of one sheet [mm]."""
    side = max(cut_side(tag.size) for tag in tags)
    left = 0.5 * (size[0] - columns * side)
    top = size[1] - MARGIN
    found = []
    for place in range(len(tags)):
        row, column = divmod(place, columns)
        found.append((left + (column + 0.5) * side, top - (row + 0.5) * side - row * LABEL))
    return found


def _tag_sheet(tags: Sequence[PlacedTag], size: tuple[float, float], columns: int, rows: int) -> Sheet:
    sheet = Sheet(*size)
    for tag, (x, y) in zip(tags, tag_places(tags, size, columns, rows), strict=True):
        half = 0.5 * cut_side(tag.size)
        sheet.content.append(Shape(dark_cells(tag.number, x, y, MM * tag.size)))
        outline = rectangle(x - half, y - half, 2 * half, 2 * half)
        sheet.content.append(Line((*outline, outline[0]), 0.1, "#888888", (1.0, 1.0)))
        said = f"{tag.number}  x {tag.pose.x:+.3f}  y {tag.pose.y:+.3f} m  turned {_degrees(tag)}°"
        sheet.content.append(Words(x, y - half - 3.4, said, 2.3, "middle"))
    draw_ruler(sheet, MARGIN, 4.0, 150)
    advice = "100 %: the ruler must measure 150 mm"
    sheet.content.append(Words(MARGIN, 10.5, advice, 2.6))
    return sheet


def _degrees(tag: PlacedTag) -> int:
    """Return how far the tag is turned from upright in the plan [deg], counter-clockwise."""
    return round(math.degrees(tag.pose.theta)) % 360
