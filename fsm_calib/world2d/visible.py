"""Which surfaces a camera sees, where in the image, and in which order they must be drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import FloatArray
from fsm_calib.world2d.lens import RayTable, distort_rays
from fsm_calib.world2d.surfaces import Surface

NEAREST = 0.015
"""Nearest depth that is drawn [m]; nothing comes nearer to a lens 0.1 m above the floor."""
_COARSE = 8
"""Spacing of the rays that look for surfaces reaching behind the camera [px]."""
_SMALLEST = 1.5
"""Surfaces smaller than this in the image are left out [px]; no detector sees them."""
_BAKED = 9.0
"""Prints on the floor that are lower than this in the image [px] are left to the floor's own, coarser
picture.
"""
_LAYERS = {"room": 0, "floor": 1, "decal": 2, "standing": 3}

_LARGE = 0.5
"""Longest side [m] from which a surface that reaches behind the camera is looked for by rays."""

Box = tuple[int, int, int, int]
RealBox = tuple[float, float, float, float]
Row = tuple[float, float, float]
Matrix = tuple[Row, Row, Row]
"""A 3 x 3 matrix as plain numbers, row by row."""


@dataclass(frozen=True, eq=False)
class Seen:
    """A surface in sight: the image box (x0, y0, x1, y1), ends excluded [px], and the map from rays to its
    plane.

    rows : of the matrix (x, y, 1) -> homogeneous plane point [m]; its third component is positive in front.
    """

    surface: Surface
    box: Box
    rows: Matrix


class SurfaceIndex:
    """The corners and frames of a scene's surfaces in arrays, so that one frame needs few numpy calls."""

    def __init__(self, surfaces: tuple[Surface, ...]) -> None:
        self.surfaces = surfaces
        self.frames = np.array([surface.world_from_plane for surface in surfaces])
        self.layers = np.array([_LAYERS[surface.layer] for surface in surfaces])
        self.sides = np.array([surface.texture.size for surface in surfaces])
        self.two_sided = np.array([surface.two_sided for surface in surfaces])
        steps = np.linspace(0.0, 1.0, 3)
        edge = [p for t in steps for p in ((t, 0.0), (1.0, t), (t, 1.0), (0.0, t))]
        plane = np.array([[*point, 1.0] for point in edge])
        scale = np.concatenate([self.sides, np.ones((len(surfaces), 1))], axis=1)
        self.outlines = np.einsum("sij,spj->spi", self.frames, plane[None] * scale[:, None])

    def look(self, table: RayTable, rotation: FloatArray, position: FloatArray) -> list[Seen]:
        """Return the surfaces in sight, in the order in which they must be drawn."""
        frames_camera = np.einsum("ji,sjk->sik", rotation, self.frames)
        frames_camera[:, :, 2] -= rotation.T @ position
        # a ray d meets a plane where depth d = frame (a, b, 1), so the inverse gives (a, b, 1) / depth
        plane_from_ray = np.linalg.inv(frames_camera)
        outlines = (self.outlines - position) @ rotation
        facing = self.two_sided | (np.linalg.det(frames_camera) > 0.0)
        in_front = (outlines[..., 2] > NEAREST).all(axis=1)
        some = (outlines[..., 2] > NEAREST).any(axis=1)
        boxes = _project_boxes(table, outlines)
        seen = []
        for index in np.flatnonzero(facing & some):
            box: RealBox | None = boxes[index]
            if not in_front[index] and self.sides[index].max() > _LARGE:
                box = _search_box(table, plane_from_ray[index], self.sides[index])
            low = _BAKED if self.layers[index] == _LAYERS["decal"] else _SMALLEST
            whole = _clip(box, table, low)
            if whole is not None:
                a, b, w = plane_from_ray[index].tolist()
                seen.append(Seen(self.surfaces[index], whole, (tuple(a), tuple(b), tuple(w))))
        return _in_drawing_order(seen, position)


def _project_boxes(table: RayTable, outlines: FloatArray) -> list[RealBox]:
    """Return the image boxes [px] of outlines (n, points, 3) in the camera's frame; rays beyond the widest
    are clamped.
    """
    depth = np.maximum(outlines[..., 2], NEAREST)
    x, y = outlines[..., 0] / depth, outlines[..., 1] / depth
    shrink = np.minimum(1.0, table.widest / np.maximum(np.hypot(x, y), 1e-12))
    x, y = distort_rays(table.camera, x * shrink, y * shrink)
    matrix = table.camera.matrix
    u, v = matrix[0, 0] * x + matrix[0, 2], matrix[1, 1] * y + matrix[1, 2]
    low = np.stack([u.min(axis=1), v.min(axis=1)], axis=1)
    high = np.stack([u.max(axis=1), v.max(axis=1)], axis=1)
    bend = 0.04 * np.max(high - low, axis=1, keepdims=True)  # edges are curved between the outline's points
    return [
        (row[0], row[1], row[2], row[3]) for row in np.concatenate([low - bend, high + bend], axis=1).tolist()
    ]


def _search_box(table: RayTable, plane_from_ray: FloatArray, size: FloatArray) -> RealBox | None:
    """Return the image box of a rectangle that reaches behind the camera, by asking a coarse grid of rays."""
    rays = _coarse_rays(table)
    a, b, w = (
        plane_from_ray[:, :2].astype(np.float32) @ rays.reshape(2, -1) + plane_from_ray[:, 2:]
    ).reshape(3, *rays.shape[1:])
    slack = 0.02 * w  # m; a surface narrower than the grid must not slip through
    hit = (w > 0) & (a >= -slack) & (b >= -slack) & (a <= size[0] * w + slack) & (b <= size[1] * w + slack)
    rows, columns = np.flatnonzero(hit.any(axis=1)), np.flatnonzero(hit.any(axis=0))
    if rows.size == 0:
        return None
    low_x, low_y = (columns[0] - 1) * _COARSE, (rows[0] - 1) * _COARSE
    return low_x, low_y, (columns[-1] + 2) * _COARSE, (rows[-1] + 2) * _COARSE


@lru_cache(maxsize=8)
def _coarse_rays(table: RayTable) -> NDArray[Any]:
    """Return the coarse grid of rays, x and y apart, shape (2, rows, columns)."""
    return np.ascontiguousarray(np.moveaxis(table.rays[1:-1:_COARSE, 1:-1:_COARSE], -1, 0))


def _clip(box: RealBox | None, table: RayTable, low: float) -> Box | None:
    """Round a box outwards and cut it at the image; None when nothing worth drawing is left."""
    if box is None or box[3] - box[1] < low or box[2] - box[0] < _SMALLEST:
        return None
    x0, y0 = max(0, math.floor(box[0]) - 1), max(0, math.floor(box[1]) - 1)
    x1 = min(table.camera.width, math.ceil(box[2]) + 2)
    y1 = min(table.camera.height, math.ceil(box[3]) + 2)
    return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None


def _in_drawing_order(seen: list[Seen], position: FloatArray) -> list[Seen]:
    """Sort by layer, standing things from behind to front (no two of them may pierce each other)."""
    flat = [item for item in seen if item.surface.layer != "standing"]
    flat.sort(key=lambda item: _LAYERS[item.surface.layer])
    left = [item for item in seen if item.surface.layer == "standing"]
    ordered: list[Seen] = []
    while left:
        last = next((one for one in left if not any(_hides(one, other, position) for other in left)), left[0])
        left.remove(last)
        ordered.append(last)
    return flat + ordered


def _hides(one: Seen, other: Seen, position: FloatArray) -> bool:
    """Tell whether `one` may cover `other` and not the other way round."""
    if one is other or not _overlap(one.box, other.box):
        return False
    return _cannot_cover(other, one, position) and not _cannot_cover(one, other, position)


def _cannot_cover(one: Seen, other: Seen, position: FloatArray) -> bool:
    """Tell whether `other` lies on the camera's side of one's plane, or `one` beyond the other's plane."""
    return _side(other, one, position) > 0 or _side(one, other, position) < 0


def _side(one: Seen, other: Seen, position: FloatArray) -> int:
    """Return 1 when all of `one` is on the camera's side of `other`'s plane, -1 when all beyond, else 0."""
    origin, normal = other.surface.world_from_plane[:, 2], other.surface.normal
    camera = float(normal @ (position - origin))
    distances = (one.surface.corners_world() - origin) @ normal * np.sign(camera)
    if np.all(distances > -1e-9):
        return 1
    return -1 if np.all(distances < 1e-9) else 0


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
