"""Collision shapes: what of the scene stops the robot, and the robot's own outline, in pymunk.

Standing boards stop the robot as far up as the robot is high; a leaned one with the strip of floor under it.
Boards on the floor and markers are paper and stop nothing. Lengths in metres; a slop of 0.1 mm replaces
pymunk's default of 0.1, which is meant for pixels.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk

from fsm_calib.world2d.scene import SceneSpec, Wall
from fsm_calib.world2d.surfaces import board_axes

COLLISION_SLOP = 1e-4
"""How deep shapes may overlap [m]."""
ROBOT_LENGTH, ROBOT_WIDTH, ROBOT_HEIGHT = 0.18, 0.13, 0.12
"""Duckiebot's body [m]: gym-duckietown."""
ROBOT_FRONT = 0.095
"""From the axle to the robot's front [m]: camera 0.07 m ahead of the axle, the bumper a little more."""
SHEET = 0.003
"""Half the thickness of boards and walls [m]."""
CONTACT_FRICTION = 0.4
"""Friction of plastic against wood [1], assumed."""

_ROBOT_KIND = 0b10
"""Bit that marks the robot's outline among the shapes of a space."""
SOLID = pymunk.ShapeFilter(mask=pymunk.ShapeFilter.ALL_MASKS() ^ _ROBOT_KIND)
"""Finds whatever is not the robot itself."""


def make_space() -> pymunk.Space:
    """Return an empty space seen from above: no gravity, no damping, SI slop."""
    space = pymunk.Space()
    space.collision_slop = COLLISION_SLOP
    return space


def robot_outline(body: pymunk.Body) -> pymunk.Poly:
    """Return the robot's outline attached to `body`, whose origin is the axle's centre."""
    rear, half = ROBOT_FRONT - ROBOT_LENGTH, 0.5 * ROBOT_WIDTH
    shape = pymunk.Poly(body, [(rear, -half), (ROBOT_FRONT, -half), (ROBOT_FRONT, half), (rear, half)])
    shape.friction = CONTACT_FRICTION
    shape.filter = pymunk.ShapeFilter(categories=_ROBOT_KIND)
    return shape


def _segment(space: pymunk.Space, a: tuple[float, float], b: tuple[float, float]) -> pymunk.Shape:
    shape = pymunk.Segment(space.static_body, a, b, SHEET)
    shape.friction = CONTACT_FRICTION
    return shape


def add_wall(space: pymunk.Space, wall: Wall) -> list[pymunk.Shape]:
    """Put up a wall; return its shapes."""
    shapes = [_segment(space, (wall.x0, wall.y0), (wall.x1, wall.y1))]
    space.add(*shapes)
    return shapes


def _add_board(space: pymunk.Space, spec: SceneSpec, index: int) -> list[pymunk.Shape]:
    placement = spec.boards[index]
    if placement.kind == "flat":
        return []
    right, down, _ = board_axes(placement)
    centre = np.array([placement.x, placement.y, placement.centre_z])
    low = centre + 0.5 * placement.height * down
    rise = min(ROBOT_HEIGHT, placement.height * math.cos(placement.lean))
    high = low - down * rise / max(math.cos(placement.lean), 1e-3)
    half = 0.5 * placement.width * right
    foot = [tuple(point[:2]) for point in (low - half, low + half, high + half, high - half)]
    if placement.kind == "upright":
        shape: pymunk.Shape = _segment(space, foot[0], foot[1])
    else:
        shape = pymunk.Poly(space.static_body, foot, radius=SHEET)
        shape.friction = CONTACT_FRICTION
    space.add(shape)
    return [shape]


def add_scene(space: pymunk.Space, spec: SceneSpec) -> list[pymunk.Shape]:
    """Put the scene's boards, walls and hall into `space`; return the shapes, to be taken away when the scene
    changes.
    """
    shapes: list[pymunk.Shape] = []
    for index in range(len(spec.boards)):
        shapes += _add_board(space, spec, index)
    (half_x, half_y), (cx, cy) = spec.room, spec.room_centre
    corners = [
        (cx - half_x, cy - half_y),
        (cx + half_x, cy - half_y),
        (cx + half_x, cy + half_y),
        (cx - half_x, cy + half_y),
    ]
    hall = [Wall(*corners[i], *corners[(i + 1) % 4]) for i in range(4)]
    for wall in (*spec.walls, *hall):
        shapes += add_wall(space, wall)
    return shapes
