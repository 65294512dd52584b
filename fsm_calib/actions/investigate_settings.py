"""The settings of an investigation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class InvestigateSettings:
    """Where the robot may drive, how long and how far, and how sure the answer shall be.

    Parameters
    ----------
    centre_x, centre_y : float
        The middle of the area in the world [m].
    width, depth : float
        The area's sides along x and y [m].
    margin : float
        How far planned paths of the axle's centre keep from edges and obstacles [m].
    stop_margin : float
        Where a drive is stopped [m]: half a robot, and what it rolls on in a tenth of a second.
    budget : float
        Robot time [s].
    distance : float
        Path of the axle's centre [m]; gears of small robots are plastic.
    sure : float
        Probability of the answer that ends the investigation [1].
    longest : float
        Longest single drive [s].
    command : float
        Largest command [1].
    settle : float
        Standing time before poses are taken, and for which they are taken [s].
    look_every : float
        Time between looks at the tracker while driving [s].
    room : float
        How far from edges and obstacles, beyond `margin`, a drive may begin [m].
    blind : float
        Driving time without a pose after which the drive is stopped [s].
    poses : str
        Where poses come from: `tracker`, a camera at the ceiling, or `camera`, the robot's own over the floor markers.
    tags : int
        Floor markers that a planned drive keeps in sight of the robot's own camera [1].
    unseen : float
        Longest planned time with fewer of them [s].
    exposure : float
        Time the own camera's shutter is open [s]; a frame shows the robot half of it before its stamp.
    """

    centre_x: float = 0.0
    centre_y: float = 0.0
    width: float = 2.0
    depth: float = 2.0
    margin: float = 0.20
    stop_margin: float = 0.13
    budget: float = 180.0
    distance: float = 60.0
    sure: float = 0.95
    longest: float = 30.0
    command: float = 0.6
    settle: float = 0.5
    look_every: float = 0.1
    room: float = 0.15
    blind: float = 2.0
    poses: Literal["tracker", "camera"] = "tracker"
    tags: int = 2
    unseen: float = 0.4
    exposure: float = 0.008
