"""The calibration areas that come with the project: where boards, markers and the lane are by default.

Which layout calibrates a camera well was computed from the Fisher information of the corners a turning robot
sees: boards that face the robot upright leave focal length and centre weak, whatever their number; leaned and
yawed ones are far better, and only a board on the floor fills the lower half of the image (docs/world.md,
"Layout").
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fsm_calib.errors import InputError
from fsm_calib.types import BoardSpec, Pose2
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, Road, SceneSpec


@dataclass(frozen=True, slots=True)
class _Spot:
    """A place for a board as seen from the start: azimuth [deg], distance [m], turn from facing [deg], lean
    [deg].
    """

    azimuth: float
    distance: float
    turn: float
    lean: float


#: mixed boards: leaned and turned ones at three distances, and one flat on the floor straight ahead
_MIXED = {
    1: (_Spot(0.0, 0.37, 0.0, 90.0),),
    2: (_Spot(-35.0, 0.55, 28.0, 20.0), _Spot(20.0, 0.37, 0.0, 90.0)),
    3: (_Spot(-52.0, 0.62, 28.0, 15.0), _Spot(0.0, 0.37, 0.0, 90.0), _Spot(52.0, 0.50, -28.0, 30.0)),
    4: (
        _Spot(-72.0, 0.57, -30.0, 10.0),
        _Spot(-42.0, 0.78, -27.0, 24.0),
        _Spot(-4.0, 0.60, -42.0, 25.0),
        _Spot(58.0, 0.38, 20.0, 90.0),
    ),
}
_UPRIGHT_DISTANCES = (0.62, 0.70, 0.60, 0.72)


def _place(spot: _Spot, board: BoardSpec) -> BoardPlacement:
    azimuth = math.radians(spot.azimuth)
    return BoardPlacement(
        board,
        x=spot.distance * math.cos(azimuth),
        y=spot.distance * math.sin(azimuth),
        yaw=azimuth + math.pi + math.radians(spot.turn),
        lean=math.radians(spot.lean),
    )


def mixed_boards(count: int = 3, board: BoardSpec | None = None) -> tuple[BoardPlacement, ...]:
    """Return `count` boards of mixed lean and yaw in a semicircle ahead, one of them flat on the floor.

    Beyond four, upright turned boards fill the semicircle.

    Raises
    ------
    InputError
        For fewer than 1 or more than 6 boards.
    """
    board = board or BoardSpec()
    if not 1 <= count <= 6:
        raise InputError(f"{count} boards asked for", where="boards", cure="Ask for 1 to 6.")
    if count in _MIXED:
        return tuple(_place(spot, board) for spot in _MIXED[count])
    extra = tuple(_Spot(azimuth, 0.75, 25.0, 10.0) for azimuth in (-120.0, 115.0)[: count - 4])
    spots = sorted(_MIXED[4] + extra, key=lambda spot: spot.azimuth)
    return tuple(_place(spot, board) for spot in spots)


def upright_boards(count: int = 2, board: BoardSpec | None = None) -> tuple[BoardPlacement, ...]:
    """Return `count` upright boards that face the robot, as in the paper's section 3.2 (two of them)."""
    board = board or BoardSpec()
    if not 1 <= count <= 6:
        raise InputError(f"{count} boards asked for", where="boards", cure="Ask for 1 to 6.")
    step = min(55.0, 230.0 / max(count - 1, 1))
    spots = [
        _Spot(step * (index - 0.5 * (count - 1)), _UPRIGHT_DISTANCES[index % 4], 0.0, 0.0)
        for index in range(count)
    ]
    return tuple(_place(spot, board) for spot in spots)


def lane_beyond(field: MarkerField, **changes: object) -> Road:
    """Return the road that crosses beyond the end of `field`: its white line lies just after the last
    markers.

    The right lane's centre is then about 0.23 m beyond the last column; traffic runs towards +y.
    """
    road = Road(**changes)  # type: ignore[arg-type]
    clearance = 0.03  # m, floor between the last marker and the white line
    x = field.last_x - 0.5 * field.size - clearance - road.white_width - 0.5 * road.lane_width
    return replace(road, start=Pose2(x, road.start.y, road.start.theta))


def calibration_area(
    boards: tuple[BoardPlacement, ...] | None = None,
    field: MarkerField | None = None,
    road: Road | None = None,
) -> SceneSpec:
    """Return the default area: 3 mixed boards ahead, the marker field behind, the marked lane beyond it."""
    field = field or MarkerField()
    return SceneSpec(
        boards=mixed_boards() if boards is None else boards,
        field=field,
        road=road or lane_beyond(field),
    )
