"""Settings of how the robot moves: turning with one wheel, and straight drives.

SI units, angles in rad, wheel commands normalised to [-1, 1]. "Paper" is Chaika et al., Appl. Sci. 2021, 11,
5806; "its program" is OSLL/duckietown-autocalibration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TurnSettings:
    """Turning with one wheel, a quantum at a time (paper, section 3.2).

    Parameters
    ----------
    quantum : float
        Duration of one push of the wheel [s]; paper: 0.1 s.
    settle : float
        Rest between the push and the frame [s]; its program waits 0.6 s, two to three time constants of the
        motors.
    first_command : float
        Command of the first push [1]; 5 degrees with nominal motors (27 rad/s at command 1, axle 0.1 m).
    largest_command : float
        The most a push may use [1]: no motor is worth burning.
    raise_factor : float
        Factor on the command when a push moved nothing [1].
    scan_step, search_step : float
        Angle wanted of a step with a board in sight and of a step of a search [rad]; 5 deg gives a board
        some fifteen views in a sweep, and a search loses nothing in a picture 100 deg wide.
    align_share : float
        Share of the remaining angle that an aligning step takes [1]; below 1, so that it seldom overshoots.
    smallest_align_step, largest_align_step : float
        Bounds of an aligning step [rad].
    smallest_turn : float
        A turn seen in the picture below this is none [rad]; the picture tells 0.3 deg.
    clear_likeness : float
        A shifted picture explains the change when it removes this share of it [1].
    still_change : float
        Two pictures that differ by less than this are of a robot that stands [grey levels, rms]; noise alone
        gives 1, a turn of 0.5 deg 10 and more.
    """

    quantum: float = 0.1
    settle: float = 0.6
    first_command: float = 0.1
    largest_command: float = 0.8
    raise_factor: float = 1.5
    scan_step: float = math.radians(5.0)
    search_step: float = math.radians(9.0)
    align_share: float = 0.8
    smallest_align_step: float = math.radians(1.0)
    largest_align_step: float = math.radians(12.0)
    smallest_turn: float = math.radians(0.5)
    clear_likeness: float = 0.15
    still_change: float = 4.0


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """Straight drives over the markers (paper, section 3.4) and out of the field (5.1).

    Parameters
    ----------
    command : float
        Left wheel's command while driving straight [1]; its program: 0.23.
    settle : float
        Rest after a drive [s].
    distance : float
        Length of a full drive [m]; a third of the 2 m test is the least (paper, section 3.1), its program
        drives 0.59 to 0.69 m. Longer drives tell the wheel ratio better; a scenario shortens it to what its field
        holds.
    expected_speed : float
        Speed at `command` before it is known [m/s]: 27 rad/s x 0.23 x 0.0318 m = 0.197.
    largest_heading_change : float
        The next drive is as long as keeps the expected change of heading below this [rad].
    first_mismatch : float
        Relative wheel mismatch expected before the first drive [1]; the extreme of 32 real robots is 0.22.
    shortest : float
        Shortest drive [m].
    stretch : float
        One stretch of the drive out of the field [m]; less than half of what the camera sees of the field.
    moved_share : float
        A drive that covers less than this share of what was expected was none [1].
    mismatch_margin : float
        Added to the mismatch that the last drive leaves to be expected [1].
    growth : float
        A drive is at most so many times as long as the one before [1]; so the markers seen in one reach the
        next.
    one_wheel_mismatch : float
        A relative mismatch above this is no mismatch but a wheel that stands [1]; one dead wheel gives 2.
    reached_share : float
        A drive that covers less than this share of what the drives before it let expect was held up [1]: the
        same command repeats its way to a few percent, and forward and backward differ by less than a third.
    least_shift : float
        Markers that moved by less than this between two starts tell no obstacle [m]: the camera's yaw, learnt
        in between, moves them by as much as 0.04.
    same_place : float
        Pictures that are this alike above the horizon are of one place [1]: rendered ones within 6 cm and 4 deg,
        markers gone or the picture blurred, are alike by 0.87 and more, ones 0.5 m apart by 0.67 and less.
    told_back : float
        A drive back that tells an obstacle from a dead wheel [m]: a robot of 0.1 m axle turns by 17 deg about a wheel
        that stands, within what the picture tells.
    one_wheel_turn : float
        Share of that turn which says that a wheel stands [1]; motors 22 % apart turn by as much less.
    straight_within : float
        A drive that turned by more than this tells nothing of where the camera looks [rad].
    """

    command: float = 0.23
    settle: float = 0.8
    distance: float = 1.2
    expected_speed: float = 0.197
    largest_heading_change: float = 0.35
    first_mismatch: float = 0.25
    shortest: float = 0.10
    stretch: float = 0.15
    moved_share: float = 0.25
    mismatch_margin: float = 0.01
    growth: float = 2.0
    one_wheel_mismatch: float = 0.9
    reached_share: float = 0.6
    least_shift: float = 0.10
    same_place: float = 0.77
    told_back: float = 0.03
    one_wheel_turn: float = 0.35
    straight_within: float = 0.5
