"""The person who calibrates by hand, as settings: careful, with hands that shake and eyes that read centimetres."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fsm_calib.world2d.scene import check_range


@dataclass(frozen=True, slots=True)
class OperatorSettings:
    """How a person calibrates a Duckiebot by hand.

    Sources: Duckietown operation manual, camera and wheel calibration (30 views or so of a 7x5 board until the
    bars of ROS camera_calibration are full; a tape line, 2 m, adjust trim, done below 10 cm). How a hand holds
    and how an eye reads is assumed; the assumptions are those of a careful person.

    Parameters
    ----------
    views : int
        Views of the board that are kept.
    nearest, farthest : float
        Distance of the board from the camera [m]; at 0.18 m it fills the picture.
    largest_tilt : float
        The board is tilted up to this [rad]; manuals ask for up to 45 degrees.
    roll_sd : float
        Standard deviation of the board's turn about the line of sight [rad].
    tremor_speed, tremor_rate : float
        Standard deviations of the board's motion in each direction [m/s] and about each axis [rad/s]; a tremor
        of 0.2 mm at 8 to 12 Hz is 1 cm/s.
    fast_share : float
        Share of the views that are taken while the board is being moved [1].
    fast_factor : float
        How much faster than the tremor that is [1].
    readout : float
        From the first row's exposure to the last row's, of the camera that the person uses [s]
        (`held_board`).
    references : int
        Calibrations by hand from which the best one (least reprojection error) is fixed for test 1.
    board_offset_sd, board_turn_sd : float
        How the robot is placed before the floor board: standard deviations of x and y [m] and of the heading
        [rad].
    tries : int
        Drives along the tape line at most.
    line_length : float
        Length of the test drive [m].
    give_up_deviation : float
        A drive is stopped early once the robot is so far off the line [m].
    aim_sd : float
        Standard deviation of the robot's heading against the line at the start [rad]: 4 mm over the length of
        the robot.
    reading : float
        Deviations are read to this [m].
    path_reading : float
        The path driven is read to this when the drive was stopped early [m].
    feel_sd : float
        Relative error of the person's sense of how much trim a drift needs [1]: right within 40 % mostly.
    trim_step : float
        Trim is typed in steps of this [1]; 0.001 is 4 cm after 2 m.
    good_deviation : float
        The manual's criterion [m].
    """

    views: int = 30
    nearest: float = 0.18
    farthest: float = 0.60
    largest_tilt: float = math.radians(45.0)
    roll_sd: float = math.radians(10.0)
    tremor_speed: float = 0.01
    tremor_rate: float = math.radians(2.0)
    fast_share: float = 0.07
    fast_factor: float = 15.0
    readout: float = 0.020
    references: int = 3
    board_offset_sd: float = 0.002
    board_turn_sd: float = math.radians(0.5)
    tries: int = 6
    line_length: float = 2.0
    give_up_deviation: float = 0.30
    aim_sd: float = math.radians(0.5)
    reading: float = 0.01
    path_reading: float = 0.05
    feel_sd: float = 0.2
    trim_step: float = 0.001
    good_deviation: float = 0.10

    def __post_init__(self) -> None:
        """Refuse an operator who cannot do the work."""
        check_range("views", self.views, 4, 500)
        check_range("references", self.references, 1, 100)
        check_range("tries", self.tries, 1, 100)
        check_range("fast_share", self.fast_share, 0.0, 0.9)
        check_range("readout", self.readout, 0.0, 0.1)
        check_range("nearest", self.nearest, 0.05, self.farthest)
        for name in ("reading", "path_reading", "trim_step", "line_length", "good_deviation"):
            check_range(name, getattr(self, name), 1e-4, 20.0)
        for name in ("tremor_speed", "tremor_rate", "aim_sd", "feel_sd", "roll_sd", "largest_tilt"):
            check_range(name, getattr(self, name), 0.0, 2.0)
