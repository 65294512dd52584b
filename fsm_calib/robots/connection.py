"""What a socket hands to whoever runs a robot: the robot, its world where it is a simulated one, and how to let go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fsm_calib.ports import Robot
from fsm_calib.types import FloatArray
from fsm_calib.world2d.robot import World


@dataclass(frozen=True, eq=False)
class Connection:
    """A robot that is ready to be commanded.

    Parameters
    ----------
    robot : Robot
        What the activities get.
    world : World or None
        The simulated world, for scoring and pictures only; None for a robot that stands on a floor.
    pose : callable
        Returns [x, y, theta] of `base` in `world` [m, m, rad] for the journal: the true pose of a simulated
        robot; dead reckoning from the start pose of a real one.
    track : callable
        Returns the path so far, shape (n, 4): time [s], x, y [m], theta [rad]; true or dead-reckoned, as `pose`.
    close : callable
        Stops the wheels and ends the connection; may be called twice.
    """

    robot: Robot
    world: World | None
    pose: Callable[[], list[float]]
    track: Callable[[], FloatArray]
    close: Callable[[], None]
