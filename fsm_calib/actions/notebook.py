"""The notebook: what the actions have found so far. Plain values that a checkpoint can hold as JSON.

Frozen records for single results; the notebook itself is mutable and belongs to one run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.actions.notebook_state import (
    camera_from,
    camera_state,
    pack,
    progress_from,
    progress_state,
    tags_from,
    tags_state,
    unpack,
    view_from,
    view_state,
)
from fsm_calib.perception.information import ScanProgress
from fsm_calib.types import BoardView, CameraModel, CameraMount, Pose2, TagObservation


@dataclass(frozen=True, slots=True)
class MarkerReading:
    """The markers in sight, measured at rest.

    tags : medians over the frames, the nearest first; heading : the nearest marker's heading [rad], by the
    rule of the settings; time [s] of the first frame.
    """

    tags: tuple[TagObservation, ...]
    heading: float
    time: float

    def to_state(self) -> dict[str, Any]:
        """Return the reading as plain JSON values."""
        return {"tags": tags_state(self.tags), "heading": self.heading, "time": self.time}

    @classmethod
    def from_state(cls, data: Mapping[str, Any]) -> MarkerReading:
        """Return the reading that `to_state` wrote."""
        return cls(tags_from(data["tags"]), data["heading"], data["time"])


@dataclass(frozen=True, slots=True)
class WheelRun:
    """One drive over the markers.

    wheel_ratio : k that was used [1]; duration [s]; distance : length of the path [m]; turned : change of
    heading, counter-clockwise [rad]; sd : of `turned` [rad]; k_i : the paper's, k_i - 1 is the residual [1].
    """

    wheel_ratio: float
    duration: float
    distance: float
    turned: float
    sd: float
    k_i: float


@dataclass(frozen=True, slots=True)
class CameraFigures:
    """The figures of the camera calibration for the report [px]; None where a figure does not apply.

    expected_px : root mean square that the covariance gives, of which `predicted_px` is the 95 % quantile;
    target_px : predicted error that was asked for; weakest : the part of the image that is known least; advice : what
    to do about it where the target was not reached, empty where it was.
    """

    rms_px: float
    mean_px: float
    paper_px: float
    predicted_px: float | None
    cross_validated_px: float | None
    views_used: int
    views_per_board: dict[str, int] = field(default_factory=dict)
    reason: str = ""
    expected_px: float | None = None
    target_px: float | None = None
    weakest: str = ""
    advice: str = ""

    @property
    def is_reached(self) -> bool | None:
        """Whether the predicted error is what was asked for; None where nothing was."""
        if self.target_px is None or self.predicted_px is None:
            return None
        return self.predicted_px <= self.target_px


@dataclass(slots=True)
class Notebook:
    """What is known of the robot.

    Parameters
    ----------
    views : list of BoardView
        Every view of a chessboard, in order.
    progress : ScanProgress or None
        What the scan knows of the camera from them; None before the first, and where views are not weighed.
    fresh_views, views_refused : int
        Views since the last judgement, kept or not, and views that added too little.
    image_size : tuple
        (width, height) of the frames [px].
    camera, figures, mount
        The camera calibration, its figures, and how the camera sits over the floor.
    mount_known : str
        What the boards told of the mount: nothing, `tilt` or `all` (the height, too); the markers tell the
        rest.
    tilt_readings : list
        (pitch, roll, height) [rad, rad, m] as read from floor markers.
    push_gain : dict
        Angle turned per unit command by one push, by direction of turn [rad].
    push_floor : float
        Smallest command that is known to be too weak for the wheels [1].
    drive_command, speed : float
        Left command of straight drives [1] and the speed it gives [m/s]; 0 while unknown.
    wheel_ratio : float
        k in use.
    readings, lane_readings : list of MarkerReading
        Before and after every drive of `runs` and of `lane_runs`.
    marker_map : dict
        Poses of the markers seen so far, in the frame of the first reading.
    ratio_history : list
        k after every iteration, the start included.
    runs, lane_runs : list of WheelRun
        Drives of the wheel iteration and of the lane.
    reading : MarkerReading or None
        Start of the next drive.
    heading : float
        Last heading of the nearest marker [rad].
    last_step : Pose2
        Motion of the last drive in the frame of its start.
    is_length_told : bool
        Whether the markers told the length of the last drive (else it is speed times time).
    yaw_weight : float
        Sum of the squared lengths of the drives that told the camera's yaw [m^2].
    last_duration : float
        Duration of the last drive forward [s].
    last_ratio : float
        k of the last drive forward.
    sharpness : list of float
        Sharpness of every look of the focus step.
    board_azimuth : float or None
        Where the board followed so far was last seen, counter-clockwise of the optical axis [rad].
    followed_way : str
        The way of the turn in which it was last seen.
    lane_integral, lane_side : float
        Integral of d [m s] of the lane controller and the last d [m].
    lane_before : float or None
        k before the refinement in the lane.
    marker_ahead : float
        Farthest marker ahead of the axle in the last look [m].
    field_left : bool
        The last stretch of the exit ended with no marker in sight.
    panorama, frame_mark : array, int
        The last frame, small, and its check sum.
    start_panorama : array or None
        The last frame before the last drive forward, small.
    unseen : bool
        The last move was not looked at, because the camera gave no frame.
    """

    views: list[BoardView] = field(default_factory=list)
    progress: ScanProgress | None = None
    fresh_views: int = 0
    views_refused: int = 0
    image_size: tuple[int, int] = (640, 480)
    camera: CameraModel | None = None
    figures: CameraFigures | None = None
    mount: CameraMount = field(default_factory=CameraMount)
    mount_known: str = ""
    tilt_readings: list[tuple[float, float, float]] = field(default_factory=list)
    push_gain: dict[str, float] = field(default_factory=dict)
    push_floor: float = 0.0
    drive_command: float = 0.0
    speed: float = 0.0
    wheel_ratio: float = 1.0
    ratio_history: list[float] = field(default_factory=lambda: [1.0])
    runs: list[WheelRun] = field(default_factory=list)
    readings: list[MarkerReading] = field(default_factory=list)
    marker_map: dict[int, Pose2] = field(default_factory=dict)
    lane_runs: list[WheelRun] = field(default_factory=list)
    lane_readings: list[MarkerReading] = field(default_factory=list)
    reading: MarkerReading | None = None
    heading: float = 0.0
    last_step: Pose2 = field(default_factory=Pose2)
    is_length_told: bool = True
    yaw_weight: float = 0.0
    last_duration: float = 0.0
    last_ratio: float = 1.0
    sharpness: list[float] = field(default_factory=list)
    board_azimuth: float | None = None
    followed_way: str = ""
    lane_integral: float = 0.0
    lane_side: float = 0.0
    lane_before: float | None = None
    marker_ahead: float = 0.0
    field_left: bool = False
    panorama: NDArray[np.uint8] | None = None
    frame_mark: int | None = None
    start_panorama: NDArray[np.uint8] | None = None
    unseen: bool = False

    def to_state(self) -> dict[str, Any]:
        """Return the notebook as plain JSON values."""
        state = {item.name: getattr(self, item.name) for item in fields(self)}
        state["figures"] = asdict(self.figures) if self.figures is not None else None
        state["reading"] = None if self.reading is None else self.reading.to_state()
        for name in ("mount", "last_step"):
            state[name] = _record(state[name]) if state[name] is not None else None
        for name in ("runs", "lane_runs"):
            state[name] = [_record(item) for item in state[name]]
        for name in ("readings", "lane_readings"):
            state[name] = [item.to_state() for item in state[name]]
        state["marker_map"] = {str(number): [p.x, p.y, p.theta] for number, p in self.marker_map.items()}
        state["views"] = [view_state(view) for view in self.views]
        state["progress"] = progress_state(self.progress)
        state["camera"] = camera_state(self.camera)
        for name in ("panorama", "start_panorama"):
            state[name] = pack(state[name])
        return state

    @classmethod
    def from_state(cls, state: Mapping[str, Any]) -> Notebook:
        """Return the notebook that `to_state` wrote."""
        values = dict(state)
        values["image_size"] = tuple(values["image_size"])
        values["views"] = [view_from(view) for view in values["views"]]
        values["progress"] = progress_from(values["progress"])
        values["camera"] = camera_from(values["camera"])
        values["figures"] = CameraFigures(**values["figures"]) if values["figures"] else None
        values["mount"] = CameraMount(**values["mount"])
        values["last_step"] = Pose2(**values["last_step"])
        values["tilt_readings"] = [tuple(item) for item in values["tilt_readings"]]
        for name in ("runs", "lane_runs"):
            values[name] = [WheelRun(**run) for run in values[name]]
        for name in ("readings", "lane_readings"):
            values[name] = [MarkerReading.from_state(item) for item in values[name]]
        values["marker_map"] = {int(number): Pose2(*pose) for number, pose in values["marker_map"].items()}
        values["reading"] = MarkerReading.from_state(values["reading"]) if values["reading"] else None
        for name in ("panorama", "start_panorama"):
            values[name] = unpack(values[name])
        return cls(**values)


@lru_cache(maxsize=4096)
def _record(item: WheelRun | CameraMount | Pose2) -> dict[str, Any]:
    """Return a frozen record as plain values; kept, because a checkpoint after every event asks again."""
    return asdict(item)
