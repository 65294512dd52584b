"""The simulated robot's socket: a world in this process, whose time runs as fast as it can be computed."""

from __future__ import annotations

from fsm_calib.robots.connection import Connection
from fsm_calib.world2d.robot import World, WorldSpec, make_world


def connect_simulated(spec: WorldSpec) -> Connection:
    """Build the world of `spec` and return the connection to its robot.

    Raises
    ------
    InputError
        A part of the specification has no meaning; see `make_world`.
    """
    world = make_world(spec)
    return Connection(
        robot=world.robot,
        world=world,
        pose=lambda: _true_pose(world),
        track=lambda: world.truth.trace,
        close=lambda: None,
    )


def _true_pose(world: World) -> list[float]:
    """Return the true pose [m, m, rad]."""
    pose = world.truth.pose
    return [pose.x, pose.y, pose.theta]
