"""How far the robot is from the next thing that it could touch, so that steps far from everything need no search
for contacts.
"""

from __future__ import annotations

import math

import pymunk

from fsm_calib.world2d.obstacles import ROBOT_FRONT, ROBOT_LENGTH, ROBOT_WIDTH, SOLID

OUTLINE_REACH = math.hypot(max(ROBOT_FRONT, ROBOT_LENGTH - ROBOT_FRONT), 0.5 * ROBOT_WIDTH)
"""Largest distance of the robot's outline from the axle's centre [m]."""
MARGIN = 0.02
"""Free space that is always left [m]; a robot at 2 m/s crosses it in five steps of 2 ms, after which pymunk has
forgotten a past contact (`Space.collision_persistence`: 3 steps)."""
FARTHEST = 10.0
"""How far is looked [m]; more is no help."""


def free_room(space: pymunk.Space, place: tuple[float, float]) -> float:
    """Return how far the axle's centre [m] may move in any direction, whatever the heading, until something may
    be touched; negative where something may be touched already.
    """
    found = space.point_query_nearest(place, FARTHEST, SOLID)
    nearest = FARTHEST if found is None else found.distance
    return nearest - OUTLINE_REACH - MARGIN
