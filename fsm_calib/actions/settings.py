"""Every duration, command and threshold of the actions, named, with unit and source.

Grouped by what they govern; those of the motion are in `settings_moving`. SI units, angles in rad, wheel
commands normalised to [-1, 1]. "Paper" is Chaika et al., Appl. Sci. 2021, 11, 5806; "its program" is
OSLL/duckietown-autocalibration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Literal

from fsm_calib.actions.settings_moving import DriveSettings, TurnSettings
from fsm_calib.errors import InputError
from fsm_calib.perception.information import DEFAULT_STOP
from fsm_calib.types import BoardSpec

HeadingSource = Literal["floor", "camera"]
RatioEquation = Literal["corrected", "published"]
NearestRule = Literal["distance", "last"]


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """Reading floor markers.

    Parameters
    ----------
    size : float
        Black square of a marker [m]; Duckietown appearance specification.
    frames : int
        Frames of one measurement at rest; the median over them is taken.
    farthest : float
        Markers farther than this from the camera are not used for measurements [m]; from 0.45 m on a marker
        is 10 px high.
    reference_distance, heading_sd : float
        At this distance from the camera [m] the heading of one marker has this standard deviation [rad]; it
        rises with the cube of the distance. Measured on rendered markers: 0.15 deg at 0.25 m.
    least_heading_sd : float
        No heading is better than this [rad].
    placement_sd : float
        Standard deviation of a marker's orientation on the floor [rad]: glued by hand, 0.4 deg.
    tilt_readings : int
        Readings of camera tilt and height from markers that are averaged.
    heading : {"floor", "camera"}
        Which heading counts: in the floor frame, or as published about the optical axis.
    nearest : {"distance", "last"}
        Which marker is the nearest; as published, the last of the detector's list.
    lane_first : int
        Reserved number of the first marker of the marked lane section (paper, section 5.2).
    """

    size: float = 0.065
    frames: int = 2
    farthest: float = 0.50
    reference_distance: float = 0.25
    heading_sd: float = math.radians(0.15)
    least_heading_sd: float = math.radians(0.04)
    placement_sd: float = math.radians(0.4)
    tilt_readings: int = 5
    heading: HeadingSource = "floor"
    nearest: NearestRule = "distance"
    lane_first: int = 280


@dataclass(frozen=True, slots=True)
class RatioSettings:
    """The wheel ratio k (paper, Eq. 3, as corrected in docs/method.md).

    Parameters
    ----------
    equation : {"corrected", "published"}
        How k_i follows from a drive.
    quiet_correction : float
        E: a correction |(k_i - 1) / 2| below this is quiet [1]. 0.0025 is 0.10 m after 2 m; published: 0.05.
    axle_length : float
        L [m]; only the speed of convergence depends on it.
    share : float
        Share of k_i - 1 that is applied [1]; paper: one half.
    combine : bool
        Whether the final k is the weighted least-squares value of the last drives and not the last iterate.
    combine_within : float
        Drives with |k_i - 1| below this enter the combination [1].
    largest_error : float
        A drive is quiet only when the combined k has at most this standard error [1]; 0.0006 is 0.012 m
        after 2 m.
    run_scatter : float
        Expected scatter of the mismatch from drive to drive, over 1 m [1]; longer drives average it out.
    least_ratio : float
        k stays between this and its inverse [1]; 32 real robots lie within 0.78 and 1.19.
    published_radius : float
        R of the published program [m]: the wheel's diameter.
    published_duration : float
        t of the published program [s].
    """

    equation: RatioEquation = "corrected"
    quiet_correction: float = 0.0025
    axle_length: float = 0.100
    share: float = 0.5
    combine: bool = True
    combine_within: float = 0.04
    largest_error: float = 0.0006
    run_scatter: float = 0.0023
    least_ratio: float = 0.5
    published_radius: float = 0.066
    published_duration: float = 3.25


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """Focus and camera calibration.

    Parameters
    ----------
    sharp_share : float
        In focus when the sharpness is at least this share of the best so far [1].
    least_sharpness : float
        Below this no picture of boards is in focus [1].
    skip_focus : bool
        The operator skips the focus step.
    target_px : float
        Predicted projection error over the image at which the scan has seen enough and the camera is solved: 95 of 100
        such calibrations stay within it [px]. What each value gives: docs/camera.md.
    smallest_gain : float
        A view is kept when it lowers the expected error by at least this share [1], or its board has too few
        views; 0, as published, keeps every view.
    least_views_per_board, least_views : int
        Views of every board, and of all boards together, before the scan may end; Zhang's method needs three
        views, and the predicted error tells the truth from six on (docs/camera.md).
    standpoint_move : float
        Way to the next standpoint, backwards [m].
    """

    sharp_share: float = 0.9
    least_sharpness: float = 0.08
    skip_focus: bool = False
    target_px: float = DEFAULT_STOP.predicted_px
    smallest_gain: float = DEFAULT_STOP.smallest_gain
    least_views_per_board: int = DEFAULT_STOP.views_per_board
    least_views: int = DEFAULT_STOP.views
    standpoint_move: float = 0.12


@dataclass(frozen=True, slots=True)
class LaneSettings:
    """Driving in the lane (paper, section 5.2; gains of Duckietown's lane_controller, default.yaml).

    Parameters
    ----------
    advance : float
        From the last column of markers to the middle of the lane [m]: the area's drawing.
    seek_step : float
        Angle wanted of a step that looks for the lane [rad].
    largest_phi : float
        The lane is taken when the robot heads along it within this [rad].
    command : float
        Mean wheel command in the lane [1].
    period : float
        Time between two looks [s].
    motor_answer : float
        Time until the wheels have answered a command [s], where a lag of the frames is made up for.
    lagging_share : float
        Share of the heading that one command turns away at most where frames come late [1].
    looks : int
        Looks of one stretch.
    still_autocorrelation : float
        A change of the picture is noise when its autocorrelation is below this [1]: noise gives at most 0.12, in any
        light, the 5 cm from look to look at least 0.30.
    k_d, k_phi, k_integral : float
        omega = k_d d + k_phi phi + k_integral int d [rad/s/m], [1/s], [rad/s^2/m], at 0.19 m/s.
    largest_integral : float
        Bound of the integral [m s].
    largest_omega : float
        Bound of the turn rate [rad/s].
    take_within : float
        The first marker is taken when it is this near ahead of the axle [m].
    marker_pitch : float
        Distance of neighbouring markers when only one is in sight [m]; paper: 0.15.
    change : float
        A new k differs significantly when it differs by more than this [1].
    significance : float
        ... and by more than this many standard errors [1].
    largest_scatter : float
        k_i are constant when their standard deviation is below this [1].
    least_readings : int
        Fewer k_i than this are never applied.
    """

    advance: float = 0.227
    seek_step: float = math.radians(9.0)
    largest_phi: float = math.radians(35.0)
    command: float = 0.20
    period: float = 0.3
    motor_answer: float = 0.15
    lagging_share: float = 0.8
    looks: int = 4
    still_autocorrelation: float = 0.17
    k_d: float = -6.0
    k_phi: float = -5.0
    k_integral: float = -0.3
    largest_integral: float = 0.3
    largest_omega: float = 2.5
    take_within: float = 0.36
    marker_pitch: float = 0.15
    change: float = 0.0075
    significance: float = 4.0
    largest_scatter: float = 0.012
    least_readings: int = 3


@dataclass(frozen=True, slots=True)
class ActionSettings:
    """All settings of the actions, and the chessboard's form.

    Raises
    ------
    InputError
        When a number is not finite or a duration is negative.
    """

    board: BoardSpec = field(default_factory=BoardSpec)
    turn: TurnSettings = field(default_factory=TurnSettings)
    drive: DriveSettings = field(default_factory=DriveSettings)
    marker: MarkerSettings = field(default_factory=MarkerSettings)
    ratio: RatioSettings = field(default_factory=RatioSettings)
    camera: CameraSettings = field(default_factory=CameraSettings)
    lane: LaneSettings = field(default_factory=LaneSettings)

    def __post_init__(self) -> None:
        """Refuse numbers that no run could use."""
        for group in fields(self):
            values = getattr(self, group.name)
            for item in fields(values) if is_dataclass(values) else ():
                _check(f"{group.name}.{item.name}", getattr(values, item.name))


_MAY_BE_NEGATIVE = ("lane.k_d", "lane.k_phi", "lane.k_integral")


def _check(name: str, value: object) -> None:
    if isinstance(value, bool | str):
        return
    if isinstance(value, int | float) and (
        not math.isfinite(value) or (value < 0 and name not in _MAY_BE_NEGATIVE)
    ):
        raise InputError(
            f"action setting {name} is {value}", where=name, cure="Give a finite number, 0 or more."
        )
