"""The camera: renders what a lens sees of a scene, pixel by pixel, and exposes it.

For every pixel the undistorted ray is known (`lens.ray_table`); a plane turns rays into texture coordinates
by one 3 x 3 matrix. Each surface is sampled on a grid of n x n rays per pixel, n chosen so that neighbouring
samples are about one texture pixel apart at a halving of the texture fine enough not to blur, and the samples
are averaged: edges come out anti-aliased and in their true places. While the robot moves, several poses of
the exposure are averaged.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import CameraModel, CameraMount, Pose2
from fsm_calib.world2d.lens import RayTable, camera_pose, ray_table
from fsm_calib.world2d.sensor import Light, SensorSettings, expose
from fsm_calib.world2d.surfaces import Scene
from fsm_calib.world2d.textures import Image, Texture
from fsm_calib.world2d.visible import Box, Matrix, Seen, SurfaceIndex

_BAND_ROWS = 60
"""Rows of the image that share one texture level, for surfaces seen at a slant [px]."""
_BACKGROUND = ("room", "floor")
"""Layers drawn at half the resolution: nothing in them is measured."""
_MAX_SAMPLES = 3
"""Largest n of the n x n samples per pixel of a print."""
_FINE = 0.5
"""Side of the finest texture pixel used, in image pixels across the sharper direction; 1 would blur."""
_SAMPLE_BUDGET = 300_000
"""Samples of one surface in one band beyond which n is lowered; keeps a frame's cost bounded."""
_OUTSIDE = np.float32(-1e4)
"""Texture coordinate of rays that miss the plane [px]."""
_STILL = 0.25
"""Image motion during an exposure below which one pose is enough [px]."""
_MAX_POSES = 9
"""Largest number of poses that are averaged."""
_NEAR_FLOOR = 0.15
"""Distance of the nearest floor in sight [m]: what a translation blurs most."""
_NEUTRAL = 128
"""Value of both chroma planes for grey."""
_GRAIN = 1e-5
"""Poses are rounded to this [m, rad], 0.003 px, so that a robot that has all but stopped is drawn once."""
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
        self._kept: OrderedDict[Pose2, Light] = OrderedDict()

    def ideal(self, base: Pose2) -> Light:
        """Return what reaches the sensor, without blur, noise and coding, from a robot at `base`.

        Must not be written to: a robot that stands still gets the same arrays again.
        """
        base = Pose2(*(round(value / _GRAIN) * _GRAIN for value in (base.x, base.y, base.theta)))
        if base in self._kept:
            self._kept.move_to_end(base)
            return self._kept[base]
        light = self._draw(base)
        self._kept[base] = light
        if len(self._kept) > _REMEMBERED:
            self._kept.popitem(last=False)
        return light

    def light(self, poses: Sequence[Pose2]) -> Light:
        """Return the ideal image averaged over `poses`, evenly spaced in the exposure; at least one."""
        if not poses:
            raise InputError(
                "no pose to render", where="camera", cure="Give at least one pose of the exposure."
            )
        motion = self._image_motion(poses[0], poses[-1])
        if motion < _STILL or len(poses) == 1:
            return self.ideal(poses[len(poses) // 2])
        count = int(np.clip(math.ceil(motion), 2, _MAX_POSES))
        picks = np.unique(np.linspace(0, len(poses) - 1, count).round().astype(int))
        total = np.zeros((self.camera.height, self.camera.width), dtype=np.float32)
        for pick in picks:
            light = self._draw(poses[int(pick)])
            cv2.accumulate(light.luma, total)
        return Light(cv2.convertScaleAbs(total, alpha=1.0 / len(picks)), light.chroma)

    def _image_motion(self, first: Pose2, last: Pose2) -> float:
        """Return about how far the image moves between two poses [px]."""
        turn = abs(math.remainder(last.theta - first.theta, math.tau))
        travel = math.hypot(last.x - first.x, last.y - first.y)
        return float(self.camera.matrix[0, 0]) * (turn + travel / _NEAR_FLOOR)

    def _draw(self, base: Pose2) -> Light:
        rotation, position = camera_pose(base, self.mount)
        table = self._table
        half = np.zeros(table.coarse.shape[:2], dtype=np.uint8)
        chroma = np.full((*half.shape, 2), _NEUTRAL, dtype=np.uint8)
        in_sight = self._index.look(table, rotation, position)
        for seen in (item for item in in_sight if item.surface.layer in _BACKGROUND):
            _draw_background(half, chroma, seen, table)
        luma = cv2.resize(half, (self.camera.width, self.camera.height), interpolation=cv2.INTER_LINEAR)
        for seen in (item for item in in_sight if item.surface.layer not in _BACKGROUND):
            for box in _bands(seen.box):
                _draw_luma(luma, seen, box, table)
            _draw_chroma(chroma, seen, table)
        if table.has_blind:
            luma[table.blind] = 0
        return Light(luma, chroma)


@lru_cache(maxsize=8)
def _table_of(camera: CameraModel) -> RayTable:
    return ray_table(camera)


def _bands(box: Box) -> list[Box]:
    """Cut a box into bands of rows, so that each has its own texture level."""
    x0, y0, x1, y1 = box
    count = max(1, round((y1 - y0) / _BAND_ROWS))
    cuts = [y0 + (y1 - y0) * i // count for i in range(count + 1)]
    return [(x0, top, x1, bottom) for top, bottom in pairwise(cuts)]


def _halved(box: Box) -> Box:
    """Return the box in an image of half the resolution."""
    return box[0] // 2, box[1] // 2, (box[2] + 1) // 2, (box[3] + 1) // 2


def _draw_background(luma: Image, chroma: Image, seen: Seen, table: RayTable) -> None:
    """Draw a wall of the hall or the floor into images of half the resolution, in place."""
    texture = seen.surface.texture
    for box in _bands(seen.box):
        sharp, slanted = _footprint(table.rays, box, seen)
        level = _level(2.0 * math.sqrt(sharp * slanted), texture)
        x0, y0, x1, y1 = _halved(box)
        where = _project(table.coarse[y0:y1, x0:x1], _to_texels(seen, level))
        _lookup(texture.luma[level], where, luma[y0:y1, x0:x1])
        if texture.chroma is not None:
            _lookup(texture.chroma[level], where, chroma[y0:y1, x0:x1])


def _draw_luma(image: Image, seen: Seen, box: Box, table: RayTable) -> None:
    """Draw the grey values of what of a surface lies in `box` into `image`, in place."""
    x0, y0, x1, y1 = box
    level, samples = _sampling(table.rays, box, seen)
    to_texels, picture = _to_texels(seen, level), seen.surface.texture.luma[level]
    target = image[y0:y1, x0:x1]
    if samples == 1:
        _lookup(picture, _project(table.rays[y0 + 1 : y1 + 1, x0 + 1 : x1 + 1], to_texels), target)
        return
    where = _project(table.rays[y0 : y1 + 2, x0 : x1 + 2], to_texels)
    size = ((x1 - x0) * samples, (y1 - y0) * samples)
    fine = cv2.resize(where, (size[0] + 2 * samples, size[1] + 2 * samples), interpolation=cv2.INTER_LINEAR)
    drawn = cv2.resize(target, size, interpolation=cv2.INTER_NEAREST)
    _lookup(picture, fine[samples:-samples, samples:-samples], drawn)
    cv2.resize(drawn, (x1 - x0, y1 - y0), dst=target, interpolation=cv2.INTER_AREA)


def _draw_chroma(image: Image, seen: Seen, table: RayTable) -> None:
    """Draw a surface's colours into `image` of half the resolution, in place; grey ones hide what was."""
    x0, y0, x1, y1 = _halved(seen.box)
    texture = seen.surface.texture
    if texture.chroma is None and seen.surface.layer != "standing":
        return  # prints lie on grey ground
    level, picture = 0, _grey(texture.luma[0].shape)
    if texture.chroma is not None:
        sharp, slanted = _footprint(table.rays, seen.box, seen)
        level = _level(2.0 * math.sqrt(sharp * slanted), texture)
        picture = texture.chroma[level]
    where = _project(table.coarse[y0:y1, x0:x1], _to_texels(seen, level))
    _lookup(picture, where, image[y0:y1, x0:x1])


@lru_cache(maxsize=16)
def _grey(shape: tuple[int, int]) -> Image:
    return np.full((*shape, 2), _NEUTRAL, dtype=np.uint8)


def _to_texels(seen: Seen, level: int) -> Matrix:
    """Return the map from rays to texture pixels of a level, three rows; texel t covers [t, t + 1), so centres
    are half a texel off.

    Plain numbers: thousands of such maps are made in a second, and numpy takes ten times as long for nine numbers.
    """
    scale = seen.surface.texture.scale * 0.5**level
    a, b, (w0, w1, w2) = seen.rows
    h0, h1, h2 = 0.5 * w0, 0.5 * w1, 0.5 * w2
    return (
        (a[0] * scale - h0, a[1] * scale - h1, a[2] * scale - h2),
        (b[0] * scale - h0, b[1] * scale - h1, b[2] * scale - h2),
        (w0, w1, w2),
    )


def _lookup(picture: Image, where: NDArray[Any], target: Image) -> None:
    """Write samples of `picture` at `where` into `target`; places outside of it keep what is there."""
    none: Any = None  # the map is one array of pairs
    cv2.remap(picture, where, none, cv2.INTER_LINEAR, dst=target, borderMode=cv2.BORDER_TRANSPARENT)


def _project(rays: NDArray[Any], matrix: Matrix) -> NDArray[Any]:
    """Return the texture coordinates of rays, shape (h, w, 2) [texture px]; far outside where the ray misses
    the plane.
    """
    texels = cv2.perspectiveTransform(rays, np.array(matrix))
    w0, w1, w2 = matrix[2]
    corners = (rays[0, 0].tolist(), rays[0, -1].tolist(), rays[-1, 0].tolist(), rays[-1, -1].tolist())
    if min(x * w0 + y * w1 + w2 for x, y in corners) < 0.05 * max(abs(w0), abs(w1), abs(w2)):
        third = rays[..., 0] * np.float32(w0)
        third += rays[..., 1] * np.float32(w1)
        texels[third <= np.float32(1e-6 - w2)] = _OUTSIDE
    return texels


def _footprint(rays: NDArray[Any], box: Box, seen: Seen) -> tuple[float, float]:
    """Return the texels of level 0 that a pixel covers at the box's centre, along the sharper and the slanted
    way.
    """
    row, column = (box[1] + box[3]) // 2 + 1, (box[0] + box[2]) // 2 + 1
    (a0, a1, a2), (b0, b1, b2), (w0, w1, w2) = _to_texels(seen, 0)
    points = []
    for x, y in (rays[row, column].tolist(), rays[row, column + 1].tolist(), rays[row + 1, column].tolist()):
        w = max(abs(w0 * x + w1 * y + w2), 1e-6)
        points.append(((a0 * x + a1 * y + a2) / w, (b0 * x + b1 * y + b2) / w))
    across, down = math.dist(points[0], points[1]), math.dist(points[0], points[2])
    return min(across, down), max(across, down)


def _level(texels: float, texture: Texture) -> int:
    """Return the halving of a texture at which `texels` of level 0 are about one pixel."""
    return min(int(math.log2(max(1.0, texels))), len(texture.luma) - 1)


def _sampling(rays: NDArray[Any], box: Box, seen: Seen) -> tuple[int, int]:
    """Choose the texture's level and the samples per pixel and direction for a print."""
    sharp, slanted = _footprint(rays, box, seen)
    level = _level(max(_FINE * sharp, slanted / _MAX_SAMPLES), seen.surface.texture)
    samples = min(max(math.ceil(slanted / 2**level), 2), _MAX_SAMPLES)
    pixels = (box[2] - box[0]) * (box[3] - box[1])
    while samples > 1 and samples * samples * pixels > _SAMPLE_BUDGET:
        samples -= 1
    return level, samples


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
