"""A scene as textured rectangles in space, ready to be looked at.

A surface's frame has its origin at the picture's upper left, u along the picture's rows, v down its columns
and its normal u x v into the picture, away from who reads it. `world_from_plane` holds (u, v, origin) as
columns: a plane point (a, b) [m] is at  a u + b v + origin  in `world`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from fsm_calib.types import FloatArray, Pose2, read_only
from fsm_calib.world2d.scene import FLAT_CLEARANCE, BoardPlacement, MarkerField, Road, SceneSpec, Wall
from fsm_calib.world2d.textures import (
    Texture,
    board_texture,
    floor_texture,
    make_texture,
    road_texture,
    tag_texture,
    wall_texture,
)

Layer = Literal["room", "floor", "decal", "standing"]


@dataclass(frozen=True, eq=False)
class Surface:
    """One textured rectangle: its name, its texture, where it is and in which layer it is drawn."""

    name: str
    layer: Layer
    texture: Texture
    world_from_plane: FloatArray
    two_sided: bool = False

    @property
    def normal(self) -> FloatArray:
        """The direction u x v, away from who reads the picture, shape (3,)."""
        return np.cross(self.world_from_plane[:, 0], self.world_from_plane[:, 1])

    def corners_world(self) -> FloatArray:
        """The rectangle's corners in `world`, shape (4, 3) [m], from the picture's upper left round to the
        right.
        """
        width, height = self.texture.size
        plane = np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1]], dtype=float)
        return plane @ self.world_from_plane.T


@dataclass(frozen=True, slots=True)
class Marker:
    """A marker that lies on the floor: its number, the pose of its centre and x axis in `world`, its side
    [m].
    """

    tag_id: int
    pose: Pose2
    size: float


@dataclass(frozen=True, eq=False)
class Scene:
    """A built scene: the specification, its surfaces and where each board and marker truly is."""

    spec: SceneSpec
    surfaces: tuple[Surface, ...]
    markers: tuple[Marker, ...]


def board_axes(placement: BoardPlacement) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the print's right and down directions and the face's normal in `world`, three unit vectors."""
    cy, sy = math.cos(placement.yaw), math.sin(placement.yaw)
    cl, sl = math.cos(placement.lean), math.sin(placement.lean)
    normal = np.array([cy * cl, sy * cl, sl])
    up = np.array([-cy * sl, -sy * sl, cl])
    return np.cross(-normal, up), -up, normal


def board_points_world(placement: BoardPlacement) -> FloatArray:
    """Return the inner corners in `world`, shape (rows * columns, 3) [m], ordered as `points_board`."""
    right, down, _ = board_axes(placement)
    board = placement.board
    points = board.points_board()
    points[:, :2] -= 0.5 * board.square * np.array([board.columns - 1, board.rows - 1])
    centre = np.array([placement.x, placement.y, placement.centre_z])
    return centre + points[:, :1] * right + points[:, 1:2] * down


def _rectangle(centre: FloatArray, right: FloatArray, down: FloatArray, texture: Texture) -> FloatArray:
    width, height = texture.size
    origin = centre - 0.5 * width * right - 0.5 * height * down
    return read_only(np.stack([right, down, origin], axis=1))


def board_surface(placement: BoardPlacement, index: int) -> Surface:
    """Return the printed sheet of a board."""
    right, down, _ = board_axes(placement)
    texture = board_texture(placement.board, placement.margin)
    centre = np.array([placement.x, placement.y, placement.centre_z])
    layer: Layer = "decal" if placement.kind == "flat" else "standing"
    return Surface(f"board {index}", layer, texture, _rectangle(centre, right, down, texture))


def marker_surface(marker: Marker) -> Surface:
    """Return the print of a floor marker; the picture's right is the marker's x axis."""
    texture = tag_texture(marker.tag_id, marker.size)
    c, s = math.cos(marker.pose.theta), math.sin(marker.pose.theta)
    right, down = np.array([c, s, 0.0]), np.array([s, -c, 0.0])
    centre = np.array([marker.pose.x, marker.pose.y, FLAT_CLEARANCE])
    return Surface(f"marker {marker.tag_id}", "decal", texture, _rectangle(centre, right, down, texture))


def marker_corners_world(marker: Marker) -> FloatArray:
    """Return the black square's corners in `world`, shape (4, 3) [m], in the AprilTag library's order.

    Bottom left, bottom right, top right, top left of the print; its x axis runs from the first to the second.
    """
    half = 0.5 * marker.size
    x, y = np.array([-half, half, half, -half]), np.array([-half, -half, half, half])
    c, s = math.cos(marker.pose.theta), math.sin(marker.pose.theta)
    height = np.full(4, FLAT_CLEARANCE)
    return np.stack([marker.pose.x + c * x - s * y, marker.pose.y + s * x + c * y, height], axis=1)


def field_markers(field: MarkerField, rng: np.random.Generator) -> tuple[Marker, ...]:
    """Return the field's markers with their irregular places and headings, without the missing ones."""
    noise = rng.standard_normal((field.rows, field.columns, 3))
    markers = []
    for row in range(field.rows):
        for column in range(field.columns):
            along, across, turn = noise[row, column]
            pose = Pose2(
                field.first_x - column * field.pitch + field.spacing_sd * along,
                (0.5 * (field.rows - 1) - row) * field.pitch + field.spacing_sd * across,
                field.heading + field.heading_sd * turn,
            )
            markers.append(Marker(field.first_id + row * field.columns + column, pose, field.size))
    return tuple(marker for marker in markers if marker.tag_id not in field.missing)


def lane_markers(road: Road, rng: np.random.Generator) -> tuple[Marker, ...]:
    """Return the refinement markers in the lane's middle, co-directed with the traffic, the reserved number
    first.
    """
    noise = rng.standard_normal((road.markers, 3))
    return tuple(
        Marker(
            road.first_id + index,
            road.start.then(
                Pose2(
                    road.first_marker + index * road.marker_pitch + road.marker_spacing_sd * along,
                    road.marker_spacing_sd * across,
                    road.marker_heading_sd * turn,
                )
            ),
            road.marker_size,
        )
        for index, (along, across, turn) in enumerate(noise)
    )


def road_surface(road: Road) -> Surface:
    """Return the road's picture, laid from its start along the traffic."""
    middle = road.start.then(Pose2(0.5 * road.length, road.centre_offset, 0.0))
    c, s = math.cos(road.start.theta), math.sin(road.start.theta)
    right, down = np.array([s, -c, 0.0]), np.array([-c, -s, 0.0])
    texture = road_texture(road)
    centre = np.array([middle.x, middle.y, 0.0])
    return Surface("road", "decal", texture, _rectangle(centre, right, down, texture))


def wall_surface(wall: Wall, name: str, layer: Layer = "standing", seed: int = 5) -> Surface:
    """Return a wall, seen from its right-hand side as it runs from its first to its second end."""
    length = math.hypot(wall.x1 - wall.x0, wall.y1 - wall.y0)
    right = np.array([wall.x1 - wall.x0, wall.y1 - wall.y0, 0.0]) / length
    texture = wall_texture(round(length, 4), wall.height, wall.shade, seed)
    origin = np.array([wall.x0, wall.y0, wall.height])
    plane = read_only(np.stack([right, np.array([0.0, 0.0, -1.0]), origin], axis=1))
    return Surface(name, layer, texture, plane, two_sided=True)


def room_surfaces(spec: SceneSpec) -> tuple[Surface, ...]:
    """Return the hall's four walls and its floor."""
    (half_x, half_y), (cx, cy) = spec.room, spec.room_centre
    ring = [
        (cx - half_x, cy + half_y),
        (cx + half_x, cy + half_y),
        (cx + half_x, cy - half_y),
        (cx - half_x, cy - half_y),
    ]
    walls = [
        wall_surface(
            Wall(*ring[i], *ring[(i + 1) % 4], spec.room_height, "plaster"), f"room {i}", "room", 40 + i
        )
        for i in range(4)
    ]
    texture = floor_texture(2.0 * half_x, 2.0 * half_y)
    right, down = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])
    floor = Surface("floor", "floor", texture, _rectangle(np.array([cx, cy, 0.0]), right, down, texture))
    return (*walls, floor)


def bake_floor(floor: Surface, decals: list[Surface]) -> Surface:
    """Return the floor with every print drawn into its picture, for views so distant that the prints' own is
    too fine.
    """
    scale = floor.texture.scale
    image = floor.texture.luma[0].copy()
    plane_from_world = np.linalg.inv(_flat(floor.world_from_plane))
    for decal in decals:
        level = min(int(max(0.0, math.log2(decal.texture.scale / scale))), len(decal.texture.luma) - 1)
        picture, fine = decal.texture.luma[level], decal.texture.scale / 2**level
        matrix = (
            np.diag([scale, scale, 1.0])
            @ plane_from_world
            @ _flat(decal.world_from_plane)
            / np.array([fine, fine, 1.0])
        )
        height, width = picture.shape[:2]
        corners = matrix[:2] @ np.array([[0, width, width, 0], [0, 0, height, height], [1, 1, 1, 1]])
        x0, y0 = np.clip(np.floor(corners.min(axis=1)).astype(int), 0, None)
        x1, y1 = np.minimum(np.ceil(corners.max(axis=1)).astype(int), image.shape[1::-1])
        if x1 <= x0 or y1 <= y0:
            continue
        half = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1]])  # pixel centres
        local = half @ np.array([[1, 0, -x0], [0, 1, -y0], [0, 0, 1]]) @ matrix @ np.linalg.inv(half)
        patch = np.ascontiguousarray(image[y0:y1, x0:x1])
        cv2.warpAffine(picture, local[:2], (x1 - x0, y1 - y0), dst=patch, borderMode=cv2.BORDER_TRANSPARENT)
        image[y0:y1, x0:x1] = patch
    return replace(floor, texture=make_texture(image, scale))


def _flat(world_from_plane: FloatArray) -> FloatArray:
    """Return the planar motion of a surface on the floor: (a, b, 1) -> (x, y, 1), shape (3, 3)."""
    return np.vstack([world_from_plane[:2], [0.0, 0.0, 1.0]])


def build_scene(spec: SceneSpec, rng: np.random.Generator) -> Scene:
    """Build every surface of `spec`; `rng` draws the irregular places and headings of the markers."""
    field_rng, lane_rng = rng.spawn(2)
    markers = field_markers(spec.field, field_rng) if spec.field else ()
    markers += lane_markers(spec.road, lane_rng) if spec.road else ()
    *walls, floor = room_surfaces(spec)
    prints = [road_surface(spec.road)] if spec.road else []
    prints += [marker_surface(marker) for marker in markers]
    surfaces = [*walls, bake_floor(floor, prints), *prints]
    surfaces += [board_surface(placement, index) for index, placement in enumerate(spec.boards)]
    surfaces += [wall_surface(wall, f"wall {index}") for index, wall in enumerate(spec.walls)]
    return Scene(spec, tuple(surfaces), markers)
