"""What stands and lies in the calibration area, as frozen specifications; nothing here draws or moves.

The robot starts at the origin of `world`, facing +x. Chessboards stand in a semicircle ahead; behind the
robot lies the field of floor markers, along which it drives towards -x; beyond the field's end a lane crosses
at a right angle and runs towards +y, with a row of markers in its middle for refinement (paper sections
3.2-3.4, 5.1, 5.2, figures 5 and 6). Lengths are metres, angles radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal

from fsm_calib.errors import InputError
from fsm_calib.types import BoardSpec, Pose2

BoardKind = Literal["upright", "leaned", "flat"]

MARKER_SIZE = 0.065
"""Black square of a floor marker [m]: Duckietown appearance specification."""
MARKER_PITCH = 0.15
"""Distance of neighbouring markers [m]: paper section 3.3, "about 15 cm"."""
FIELD_FIRST_ID = 300
"""First number of the markers printed for the floor, 300 to 399 (Duckietown's tag list, localization range).
"""
LANE_FIRST_ID = 280
"""Reserved number of the first marker of a marked lane section, from 265 to 299, which Duckietown leaves
unassigned.
"""
TILE = 0.585
"""Side of a road tile [m]: Duckietown maps."""
FLAT_CLEARANCE = 0.0005
"""Thickness of what lies on the floor [m]; it only orders what covers what."""


@dataclass(frozen=True, slots=True)
class BoardPlacement:
    """A chessboard in the area.

    Parameters
    ----------
    board : BoardSpec
        Form of the printed chessboard.
    x, y : float
        Centre of the squares in `world` [m].
    z : float or None
        Height of the centre [m]; by default such that the board stands or lies on the floor.
    yaw : float
        Heading of the horizontal part of the printed face's normal [rad]; of a flat board, whose normal is up, the
        side from which the print reads upright.
    lean : float
        How far the face is turned up [rad]: 0 stands upright, pi/2 lies flat.
    margin : float
        White border around the squares [m].
    """

    board: BoardSpec = field(default_factory=BoardSpec)
    x: float = 0.6
    y: float = 0.0
    z: float | None = None
    yaw: float = math.pi
    lean: float = 0.0
    margin: float = 0.020

    @property
    def kind(self) -> BoardKind:
        """Say `flat` (on the floor), `leaned` (more than 5 deg) or `upright`."""
        if self.lean > math.radians(85.0):
            return "flat"
        return "leaned" if self.lean > math.radians(5.0) else "upright"

    @property
    def width(self) -> float:
        """Width of the sheet [m]: the squares and the margin."""
        return (self.board.columns + 1) * self.board.square + 2.0 * self.margin

    @property
    def height(self) -> float:
        """Height of the sheet [m]: the squares and the margin."""
        return (self.board.rows + 1) * self.board.square + 2.0 * self.margin

    @property
    def centre_z(self) -> float:
        """Height of the centre [m]: as given, or such that the sheet's lower edge is on the floor."""
        return self.z if self.z is not None else 0.5 * self.height * math.cos(self.lean) + FLAT_CLEARANCE


@dataclass(frozen=True, slots=True)
class MarkerField:
    """Rows and columns of tag36h11 on the floor; rows run along the driving direction (towards -x).

    Parameters
    ----------
    rows : int
        Rows along the driving direction [1].
    columns : int
        Markers in a row [1].
    first_x : float
        Where the column nearest to the start lies along x [m].
    pitch : float
        Distance of neighbouring markers [m].
    size : float
        Side of a marker's black square [m].
    first_id : int
        Number of the first marker [1]; numbers grow along a row, row by row from the robot's right hand (+y) as it
        drives.
    heading : float
        Heading of every marker's x axis [rad], so that a robot that drives towards -x sees 0.
    spacing_sd : float
        Irregular placement, standard deviation along x and y [m].
    heading_sd : float
        Orientation error, standard deviation [rad].
    missing : tuple of int
        Numbers of markers that are not there [1].
    """

    rows: int = 9
    columns: int = 11
    first_x: float = -0.15
    pitch: float = MARKER_PITCH
    size: float = MARKER_SIZE
    first_id: int = FIELD_FIRST_ID
    heading: float = math.pi
    spacing_sd: float = 0.003
    heading_sd: float = math.radians(0.3)
    missing: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a field that no print provides."""
        check_range("rows", self.rows, 1, 40)
        check_range("columns", self.columns, 1, 40)
        check_range("pitch", self.pitch, 1.25 * self.size, 1.0)
        check_range("last marker number", self.first_id + self.rows * self.columns - 1, 0, 586)

    @property
    def last_x(self) -> float:
        """Where the last column lies along x [m]."""
        return self.first_x - (self.columns - 1) * self.pitch


@dataclass(frozen=True, slots=True)
class Road:
    """A straight road of one lane each way (Duckietown appearance specification; right-hand traffic).

    Parameters
    ----------
    start : Pose2
        Pose of the right lane's centre line where the road begins, heading along the traffic.
    length : float
        Length of the road [m].
    lane_width : float
        Width of a lane between its lines [m].
    white_width : float
        Width of the white lines [m].
    yellow_width : float
        Width of the yellow line [m].
    dash : float
        Length of a dash of the yellow line [m].
    gap : float
        Gap between the dashes of the yellow line [m].
    markers : int
        Refinement markers in the lane's middle [1].
    first_marker : float
        Where the first of them lies along the lane [m].
    marker_pitch : float
        Distance of neighbouring ones [m].
    marker_size : float
        Side of a marker's black square [m].
    first_id : int
        Reserved number of the first of them [1].
    marker_spacing_sd : float
        Irregular placement, standard deviation along x and y [m].
    marker_heading_sd : float
        Orientation error, standard deviation [rad].
    """

    start: Pose2 = field(default_factory=lambda: Pose2(-1.9, -TILE, math.pi / 2.0))
    length: float = 6.0 * TILE
    lane_width: float = 0.219
    white_width: float = 0.048
    yellow_width: float = 0.024
    dash: float = 0.050
    gap: float = 0.025
    markers: int = 8
    first_marker: float = 2.4 * TILE
    marker_pitch: float = MARKER_PITCH
    marker_size: float = MARKER_SIZE
    first_id: int = LANE_FIRST_ID
    marker_spacing_sd: float = 0.005
    marker_heading_sd: float = math.radians(0.3)

    def __post_init__(self) -> None:
        """Refuse lines without width and markers beyond the road's end."""
        for name in ("length", "lane_width", "white_width", "yellow_width", "dash", "gap"):
            check_range(name, getattr(self, name), 1e-3, 50.0)
        if self.markers and self.first_marker + (self.markers - 1) * self.marker_pitch > self.length:
            raise InputError(
                "the lane's markers reach beyond its end",
                where="road",
                cure="Lengthen the road or take fewer markers.",
            )

    @property
    def half_width(self) -> float:
        """From the road's middle to the outer edge of a white line [m]."""
        return 0.5 * self.yellow_width + self.lane_width + self.white_width

    @property
    def centre_offset(self) -> float:
        """From the right lane's centre line to the road's middle, to the left [m]."""
        return 0.5 * (self.lane_width + self.yellow_width)


@dataclass(frozen=True, slots=True)
class Wall:
    """An upright wall from (x0, y0) to (x1, y1) [m], both faces visible, solid.

    Parameters
    ----------
    x0, y0 : float
        Where it begins in `world` [m].
    x1, y1 : float
        Where it ends in `world` [m].
    height : float
        Its height [m].
    shade : str
        What it looks like: `wood`, or another texture's name.
    """

    x0: float
    y0: float
    x1: float
    y1: float
    height: float = 0.30
    shade: str = "wood"


@dataclass(frozen=True, slots=True)
class SceneSpec:
    """Everything that can be seen or hit.

    boards : counted counter-clockwise, from the robot's right to its left; room : half width and half length
    of the hall around the centre `room_centre` [m], whose walls are the background.
    """

    boards: tuple[BoardPlacement, ...] = ()
    field: MarkerField | None = None
    road: Road | None = None
    walls: tuple[Wall, ...] = ()
    room: tuple[float, float] = (3.2, 3.0)
    room_centre: tuple[float, float] = (-0.5, 0.3)
    room_height: float = 2.4

    @property
    def exit_advance(self) -> float:
        """From the last column of the field to the lane's centre line, along -x [m]; 0 when either is
        missing.
        """
        if self.field is None or self.road is None:
            return 0.0
        return self.field.last_x - self.road.start.x

    def without_board(self, index: int) -> SceneSpec:
        """Return the scene with one board taken away."""
        if not 0 <= index < len(self.boards):
            raise InputError(
                f"there is no board {index}", where="scene", cure=f"Boards: 0 to {len(self.boards) - 1}."
            )
        return replace(self, boards=self.boards[:index] + self.boards[index + 1 :])

    def without_markers(self, numbers: tuple[int, ...] | None = None) -> SceneSpec:
        """Return the scene without those markers of the field, or without the whole field."""
        if self.field is None or numbers is None:
            return replace(self, field=None)
        return replace(self, field=replace(self.field, missing=(*self.field.missing, *numbers)))

    def with_wall(self, wall: Wall) -> SceneSpec:
        """Return the scene with one more wall."""
        return replace(self, walls=(*self.walls, wall))


def check_range(name: str, value: float, low: float, high: float) -> None:
    """Raise `InputError` unless `value` is finite and within [low, high]."""
    if not (math.isfinite(value) and low <= value <= high):
        raise InputError(f"{name} is {value:g}", where="world", cure=f"Use a value from {low:g} to {high:g}.")
