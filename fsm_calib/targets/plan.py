"""The plan: where everything lies, with numbers, on one sheet that is not to scale."""

from __future__ import annotations

import math

from fsm_calib.targets.area import Content, Tiling, extent, floor_content, moved
from fsm_calib.targets.sheet import MARGIN, Line, Sheet, Words, paper_size, rectangle
from fsm_calib.targets.tags import MM, PlacedTag, placed_tags
from fsm_calib.world2d.scene import SceneSpec

TABLE = 92.0
"""Width of the column of words [mm]."""
GRID = 0.5
"""Spacing of the plan's grid [m]."""
ROW = 4.6
"""Height of a row of words [mm]."""
BLUE = "#2b7bba"
"""Colour of the sheets' borders."""


def plan_sheet(scene: SceneSpec, paper: str, name: str, cut: Tiling | None = None) -> Sheet:
    """Return the plan of an area; with `cut` also the borders and names of the sheets it is printed on."""
    sheet = Sheet(*paper_size(paper, wide=True))
    x0, y0, x1, y1 = extent(scene)
    room = sheet.width - TABLE - 3 * MARGIN - 8.0, sheet.height - 2 * MARGIN - 22.0
    scale = min(room[0] / (x1 - x0), room[1] / (y1 - y0))
    dx, dy = MARGIN + 8.0 - scale * x0, MARGIN + 9.0 - scale * y0
    sheet.content += _grid(scene, dx, dy, scale)
    drawn = [item for item in floor_content(scene) if not isinstance(item, Words)]
    sheet.content += moved(drawn, dx, dy, scale)
    sheet.content += moved(_names(scene, scale), dx, dy, scale)
    if cut is not None:
        sheet.content += moved(_borders(cut, scale), dx, dy, scale)
    _write(sheet, scene, name, 1.0 / scale, cut)
    return sheet


def _grid(scene: SceneSpec, dx: float, dy: float, scale: float) -> Content:
    """Return lines every half metre with their values along the edges."""
    x0, y0, x1, y1 = extent(scene)
    step = MM * GRID
    content: Content = []
    for number in range(math.ceil(x0 / step), math.floor(x1 / step) + 1):
        x = scale * number * step + dx
        content.append(Line(((x, scale * y0 + dy), (x, scale * y1 + dy)), 0.1, "#cccccc"))
        content.append(Words(x, scale * y0 + dy - 6.5, f"{number * GRID:g}", 2.4, "middle", "#666666"))
    for number in range(math.ceil(y0 / step), math.floor(y1 / step) + 1):
        y = scale * number * step + dy
        content.append(Line(((scale * x0 + dx, y), (scale * x1 + dx, y)), 0.1, "#cccccc"))
        content.append(Words(scale * x0 + dx - 1.5, y - 0.8, f"{number * GRID:g}", 2.4, "right", "#666666"))
    return content


def _names(scene: SceneSpec, scale: float) -> Content:
    """Return the numbers of boards and of the tags at the ends of rows."""
    content: Content = [
        Words(MM * board.x, MM * board.y - 0.9 / scale, f"board {number}", 2.4, "middle")
        for number, board in enumerate(scene.boards)
    ]
    tags = placed_tags(scene)
    for tag in _ends(tags):
        content.append(
            Words(MM * tag.pose.x, MM * tag.pose.y + 52.0, str(tag.number), 1.7, "middle", "#333333")
        )
    content.append(Words(0.0, -4.2 / scale, "start", 2.4, "middle"))
    return content


def _ends(tags: tuple[PlacedTag, ...]) -> list[PlacedTag]:
    """Return the first and the last tag of each row of the same y, and of each column that runs along y."""
    rows: dict[float, list[PlacedTag]] = {}
    for tag in tags:
        rows.setdefault(round(tag.pose.y, 3), []).append(tag)
    found = [
        end for row in rows.values() for end in ({row[0].number: row[0], row[-1].number: row[-1]}).values()
    ]
    return found


def _borders(cut: Tiling, scale: float) -> Content:
    """Return the sheets of a tiling as frames, the letters of rows to the right and the numbers of columns below."""
    content: Content = []
    right, low = max(tile.x for tile in cut.tiles) + cut.used[0], min(tile.y for tile in cut.tiles)
    rows = {tile.name.rstrip("0123456789"): tile.y for tile in cut.tiles}
    columns = {tile.name.lstrip("ABCDEFGHIJKLMNOPQRSTUVWXYZ"): tile.x for tile in cut.tiles}
    for tile in cut.tiles:
        frame = rectangle(tile.x, tile.y, *cut.used)
        content.append(Line((*frame, frame[0]), 0.3, BLUE))
    for name, y in rows.items():
        content.append(Words(right + 2.0 / scale, y + 0.5 * cut.used[1], name, 2.4, colour=BLUE))
    for name, x in columns.items():
        content.append(Words(x + 0.5 * cut.used[0], low - 3.0 / scale, name, 2.4, "middle", BLUE))
    return content


def _write(sheet: Sheet, scene: SceneSpec, name: str, one_to: float, cut: Tiling | None) -> None:
    """Write the title and the column of words."""
    sheet.content.append(Words(MARGIN, sheet.height - MARGIN - 4.0, f"Plan of the area “{name}”", 5.0))
    said = f"seen from above, 1 : {one_to:.1f}; x and y in metres from the start, where the robot faces x"
    sheet.content.append(Words(MARGIN, sheet.height - MARGIN - 10.0, said, 2.8, colour="#555555"))
    left, top = sheet.width - TABLE - MARGIN, sheet.height - MARGIN - 4.0
    for number, text in enumerate(_sentences(scene, cut)):
        sheet.content.append(Words(left, top - number * ROW, text, 2.6))


def _sentences(scene: SceneSpec, cut: Tiling | None) -> list[str]:
    lines = ["Boards: x, y [m]; faces [°]; leans back [°]; height of the middle [m]"]
    for number, board in enumerate(scene.boards):
        turn, lean = math.degrees(board.yaw) % 360, math.degrees(board.lean)
        place = f"{board.x:+.3f}   {board.y:+.3f}   {turn:.0f}°   {lean:.0f}°   {board.centre_z:.3f}"
        lines.append(f"  {number}   {place}   {board.kind}")
    if scene.field is not None:
        field = scene.field
        rows = f"{field.rows} rows along x of {field.columns}, {field.pitch:g} m apart"
        lines += [
            "",
            f"Floor tags {field.first_id} to {field.first_id + field.rows * field.columns - 1}:",
            f"  {rows}, the first at x = {field.first_x:g} m.",
            "  Numbers grow away from the start, row by row from +y.",
            "  A few millimetres and half a degree off are allowed.",
        ]
    if scene.road is not None and scene.road.markers:
        road = scene.road
        tapes = f"white lines {MM * road.white_width:.0f} mm, yellow {MM * road.yellow_width:.0f} mm (tape)"
        lines += [
            "",
            f"Lane tags {road.first_id} to {road.first_id + road.markers - 1}: in the lane's middle,",
            f"  {road.marker_pitch:g} m apart, numbers grow along the traffic.",
            f"Road: {tapes}, lane {MM * road.lane_width:.0f} mm,",
            f"  {road.length:.2f} m long, on a dark floor.",
        ]
    if cut is not None:
        lines += ["", f"Blue: the {len(cut.tiles)} sheets of area.pdf, rows by letter, columns by number."]
    return lines
