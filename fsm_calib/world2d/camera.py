"""The camera: renders what a lens sees of a scene, pixel by pixel, and exposes it.

For every pixel the undistorted ray is known (`lens.ray_table`); a plane turns rays into texture coordinates by one
3 x 3 matrix. Each surface is sampled on a grid of n x n rays per pixel, n chosen so that neighbouring samples are
about one texture pixel apart at a halving of the texture fine enough not to blur, and the samples are averaged: edges
come out anti-aliased and in their true places. While the robot moves, several poses of the exposure are averaged.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import CameraModel, CameraMount, FloatArray, Pose2
from fsm_calib.world2d.lens import RayTable, camera_pose, ray_table
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import Scene
from fsm_calib.world2d.visible import Seen, SurfaceIndex

Image = NDArray[np.uint8]

_BAND_ROWS = 60
"""Rows of the image that share one texture level, for surfaces seen at a slant [px]."""
_MAX_SAMPLES = {"room": 1, "floor": 1, "decal": 4, "standing": 4}
"""Largest n of the n x n samples per pixel, by layer: edges of prints matter, the grain of the floor does not."""
_SAMPLE_BUDGET = 500_000
"""Samples of one surface in one band beyond which n is lowered; keeps a frame's cost bounded."""
_OUTSIDE = np.float32(-1e4)
"""Texture coordinate of rays that miss the plane [px]."""
_STILL = 0.25
"""Image motion during an exposure below which one pose is enough [px]."""
_MAX_POSES = 9
"""Largest number of poses that are averaged."""
_NEAR_FLOOR = 0.15
"""Distance of the nearest floor in sight [m]: what a translation blurs most."""
_REMEMBERED = 2
"""Ideal images kept for a robot that stands still."""


class Renderer:
    """Draws one scene through one mounted camera.

    Parameters
    ----------
    scene : Scene
    camera : CameraModel
        The true lens, plumb_bob or rational_polynomial.
    mount : CameraMount
    """

    def __init__(self, scene: Scene, camera: CameraModel, mount: CameraMount) -> None:
        self.camera, self.mount = camera, mount
        self._table = _table_of(camera)
        self._index = SurfaceIndex(scene.surfaces)
        self._kept: OrderedDict[Pose2, Image] = OrderedDict()

    def ideal(self, base: Pose2) -> Image:
        """Return the image without blur, noise and coding, uint8 (height, width, 3) BGR, of a robot at `base`.

        Must not be written to: a robot that stands still gets the same array again.
        """
        if base in self._kept:
            self._kept.move_to_end(base)
            return self._kept[base]
        image = self._draw(base)
        self._kept[base] = image
        if len(self._kept) > _REMEMBERED:
            self._kept.popitem(last=False)
        return image

    def light(self, poses: Sequence[Pose2]) -> Image:
        """Return the ideal image averaged over `poses`, evenly spaced in the exposure; at least one."""
        if not poses:
            raise InputError("no pose to render", where="camera", cure="Give at least one pose of the exposure.")
        count = min(_MAX_POSES, max(1, math.ceil(self._image_motion(poses[0], poses[-1]) / 1.0)))
        if self._image_motion(poses[0], poses[-1]) < _STILL or len(poses) == 1:
            return self.ideal(poses[len(poses) // 2])
        picks = np.unique(np.linspace(0, len(poses) - 1, max(2, count)).round().astype(int))
        total = np.zeros((self.camera.height, self.camera.width, 3), dtype=np.float32)
        for pick in picks:
            cv2.accumulate(self._draw(poses[int(pick)]), total)
        return cv2.convertScaleAbs(total, alpha=1.0 / len(picks))

    def _image_motion(self, first: Pose2, last: Pose2) -> float:
        """Return about how far the image moves between two poses [px]."""
        turn = abs(math.remainder(last.theta - first.theta, math.tau))
        travel = math.hypot(last.x - first.x, last.y - first.y)
        return float(self.camera.matrix[0, 0]) * (turn + travel / _NEAR_FLOOR)

    def _draw(self, base: Pose2) -> Image:
        rotation, position = camera_pose(base, self.mount)
        image = np.zeros((self.camera.height, self.camera.width, 3), dtype=np.uint8)
        for seen in self._index.look(self._table, rotation, position):
            for box in _bands(seen):
                _draw_surface(image, seen, box, self._table)
        if self._table.has_blind:
            image[self._table.blind] = 0
        return image


@lru_cache(maxsize=8)
def _table_of(camera: CameraModel) -> RayTable:
    return ray_table(camera)


def _bands(seen: Seen) -> list[tuple[int, int, int, int]]:
    """Cut the box of a surface into bands of rows, so that each has its own texture level."""
    x0, y0, x1, y1 = seen.box
    if y1 - y0 < 1.5 * _BAND_ROWS:
        return [seen.box]
    cuts = np.linspace(y0, y1, round((y1 - y0) / _BAND_ROWS) + 1).round().astype(int)
    return [(x0, int(top), x1, int(bottom)) for top, bottom in zip(cuts[:-1], cuts[1:], strict=True)]


def _draw_surface(image: Image, seen: Seen, box: tuple[int, int, int, int], table: RayTable) -> None:
    """Draw what of a surface lies in `box` into `image`, in place."""
    x0, y0, x1, y1 = box
    rays = table.rays[y0 : y1 + 2, x0 : x1 + 2]
    texture = seen.surface.texture
    to_texels = np.diag([texture.scale, texture.scale, 1.0]) @ seen.plane_from_ray
    texels = _project(rays, to_texels)
    level, samples = _sampling(texels, texture, seen.surface.layer, (x1 - x0) * (y1 - y0))
    picture = texture.levels[level]
    scale = 1.0 / 2**level
    # texel t of level 0 covers [t, t + 1): the centre of texel 0 is at 0.5, at every level
    where = cv2.addWeighted(texels, scale, texels, 0.0, -0.5)
    target = image[y0:y1, x0:x1]
    if samples == 1:
        where = np.ascontiguousarray(where[1:-1, 1:-1])
        target[:] = _lookup(picture, where, np.ascontiguousarray(target))
        return
    height, width = where.shape[:2]
    fine = cv2.resize(where, (width * samples, height * samples), interpolation=cv2.INTER_LINEAR)
    fine = np.ascontiguousarray(fine[samples:-samples, samples:-samples])
    back = cv2.resize(target, ((x1 - x0) * samples, (y1 - y0) * samples), interpolation=cv2.INTER_NEAREST)
    drawn = _lookup(picture, fine, back)
    target[:] = cv2.resize(drawn, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA)


def _lookup(picture: Image, where: NDArray[np.float32], back: Image) -> Image:
    """Sample `picture` at `where` over `back`; places outside of the picture keep the background."""
    return cv2.remap(picture, where, None, cv2.INTER_LINEAR, dst=back, borderMode=cv2.BORDER_TRANSPARENT)


def _project(rays: NDArray[np.float32], matrix: FloatArray) -> NDArray[np.float32]:
    """Return the texture coordinates of rays, shape (h, w, 2) [texture px]; far outside where the ray misses the plane."""
    texels = cv2.perspectiveTransform(np.ascontiguousarray(rays), matrix)
    corners = rays[[0, 0, -1, -1], [0, -1, 0, -1]].astype(float)
    if np.min(corners @ matrix[2, :2]) + matrix[2, 2] > 0.05 * abs(matrix[2]).max():
        return texels
    third = rays @ matrix[2, :2].astype(np.float32) + np.float32(matrix[2, 2])
    texels[third <= 1e-6] = _OUTSIDE
    return texels


def _sampling(texels: NDArray[np.float32], texture, layer: str, pixels: int) -> tuple[int, int]:
    """Choose the texture level and the samples per pixel and direction from the texture pixels per image pixel."""
    probe = texels[:: max(1, texels.shape[0] // 8), :: max(1, texels.shape[1] // 16)]
    inside = _inside(probe, texture)
    rows, columns = np.nonzero(inside)
    if rows.size == 0:
        rows, columns = np.array([probe.shape[0] // 2]), np.array([probe.shape[1] // 2])
    step_y, step_x = max(1, texels.shape[0] // 8), max(1, texels.shape[1] // 16)
    row = np.minimum(rows * step_y, texels.shape[0] - 2)
    column = np.minimum(columns * step_x, texels.shape[1] - 2)
    here = texels[row, column]
    across = float(np.median(np.linalg.norm(texels[row, column + 1] - here, axis=1)))
    down = float(np.median(np.linalg.norm(texels[row + 1, column] - here, axis=1)))
    sharp, slanted = min(across, down), max(across, down)
    most = _MAX_SAMPLES[layer]
    blur = 0.5 if most > 1 else 1.0
    level = int(np.clip(math.floor(math.log2(max(blur * (sharp if most > 1 else slanted), 1.0))), 0, len(texture.levels) - 1))
    samples = int(np.clip(math.ceil(slanted / 2**level), min(2, most), most))
    while samples > 1 and samples * samples * pixels > _SAMPLE_BUDGET:
        samples -= 1
    return level, samples


def _inside(texels: NDArray[np.float32], texture) -> NDArray[np.bool_]:
    height, width = texture.levels[0].shape[:2]
    return (texels[..., 0] >= 0) & (texels[..., 1] >= 0) & (texels[..., 0] < width) & (texels[..., 1] < height)


def render(
    scene: Scene,
    camera: CameraModel,
    mount: CameraMount,
    poses: Sequence[Pose2],
    settings: SensorSettings,
    rng: np.random.Generator,
) -> Image:
    """Return one frame, uint8 (height, width, 3) BGR.

    Parameters
    ----------
    scene : Scene
        What there is to see.
    camera, mount : CameraModel, CameraMount
        The true lens and where it sits on the robot.
    poses : sequence of Pose2
        The robot's poses in `world`, evenly spaced over the exposure; one for a robot that stands.
    settings : SensorSettings
        Blur, noise, exposure and coding.
    rng : numpy Generator
        Draws the noise of this frame.
    """
    renderer = Renderer(scene, camera, mount)
    return expose(renderer.light(poses), camera, settings, rng)
