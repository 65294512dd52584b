"""Pictures of the things in the area: chessboards, markers, floor, road, walls, each at a known scale.

A texture is an 8-bit image whose pixel (0, 0) covers the square from (0, 0) to (1, 1) / scale [m] of its
plane; u runs to the right and v down. Prints are not pure black on white: ink 25 to 40, paper 215 to 230 of
255, as in photographs of printed boards.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import BoardSpec
from fsm_calib.world2d.scene import Road

Image = NDArray[Any]
"""8-bit pixels, (height, width) or (height, width, channels)."""

INK = 32
"""Grey value of printed black."""
PAPER = 222
"""Grey value of paper."""
BOARD_TEXELS = 32
"""Texture pixels along the side of a chessboard's square."""
TAG_TEXELS = 16
"""Texture pixels along the side of a marker's cell; a tag36h11 has 8 cells of black border and code."""
TAG_CELLS = 8
TAG_BORDER = 1
"""White border of a marker in cells: 0.8 cm of a 6.5 cm marker (Duckietown appearance specification)."""
ROAD_SCALE = 1000.0
"""Texture pixels per metre of the road."""
FLOOR_SCALE = 400.0
"""Texture pixels per metre of floor and walls."""

YELLOW_BGR = (40.0, 190.0, 225.0)
WHITE_BGR = (225.0, 222.0, 218.0)
FLOOR_GRAY = 73.0
SHADES_BGR = {"wood": (120.0, 165.0, 196.0), "plaster": (168.0, 172.0, 176.0), "dark": (60.0, 58.0, 66.0)}


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture of a plane and its halvings: level n has 1 / 2**n of the scale [px/m] of level 0.

    luma : grey images; chroma : (Cr, Cb) images, 128 neutral, or None for a grey picture. Colour is rendered
    at half the image's resolution, as JPEG keeps it (4:2:0).
    """

    luma: tuple[Image, ...]
    chroma: tuple[Image, ...] | None
    scale: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        height, width = self.luma[0].shape[:2]
        return width / self.scale, height / self.scale


def halvings(image: Image, count: int = 6) -> tuple[Image, ...]:
    """Return `image` and its halvings by averaging 2 x 2 pixels.

    Sides that do not divide are repeated at the edge, so that a halving may be longer by a part of its last
    pixel.
    """
    while min(image.shape[:2]) < 2**count and count > 0:
        count -= 1
    bottom, right = -image.shape[0] % 2**count, -image.shape[1] % 2**count
    level = cv2.copyMakeBorder(image, 0, bottom, 0, right, cv2.BORDER_REPLICATE) if bottom or right else image
    levels = [image]
    for number in range(1, count + 1):
        level = cv2.resize(level, (level.shape[1] // 2, level.shape[0] // 2), interpolation=cv2.INTER_AREA)
        height, width = (-(-side // 2**number) for side in image.shape[:2])
        levels.append(np.ascontiguousarray(level[:height, :width]))
    return tuple(levels)


def make_texture(image: Image, scale: float) -> Texture:
    """Build the texture of a grey (height, width) or BGR (height, width, 3) picture of `scale` [px/m]."""
    if image.ndim == 2:
        return Texture(halvings(image), None, scale)
    planes = cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb)
    luma, *chroma = cv2.split(planes)
    return Texture(halvings(luma), halvings(cv2.merge(chroma)), scale)


@lru_cache(maxsize=16)
def board_texture(board: BoardSpec, margin: float) -> Texture:
    """Return a printed chessboard with a white margin [m]; a dark square is at the first inner corner's upper
    left.
    """
    scale = BOARD_TEXELS / board.square
    squares = np.indices((board.rows + 1, board.columns + 1)).sum(axis=0) % 2
    cells = np.where(squares == 0, INK, PAPER)
    gray = np.kron(cells, np.ones((BOARD_TEXELS, BOARD_TEXELS)))
    border = round(margin * scale)
    return make_texture(np.pad(gray, border, constant_values=PAPER).astype(np.uint8), scale)


@lru_cache(maxsize=1024)
def tag_texture(tag_id: int, size: float) -> Texture:
    """Return tag36h11 number `tag_id` as the AprilTag library draws it, upright, with its white border.

    OpenCV's dictionary draws the same tag turned by half a turn, which is undone here.
    """
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    side = TAG_CELLS * TAG_TEXELS
    drawn = np.rot90(cv2.aruco.generateImageMarker(dictionary, tag_id, side), 2)
    gray = np.where(drawn > 127, PAPER, INK)
    sheet = np.pad(gray, TAG_BORDER * TAG_TEXELS, constant_values=PAPER)
    return make_texture(sheet.astype(np.uint8), side / size)


def _grain(
    shape: tuple[int, int], sigmas: tuple[float, ...], weights: tuple[float, ...], seed: int
) -> NDArray:
    """Return smooth noise of several grain sizes, zero mean, each grain with its standard deviation
    `weights`.
    """
    rng = np.random.default_rng(seed)
    total: NDArray[Any] = np.zeros(shape, dtype=np.float32)
    for sigma, weight in zip(sigmas, weights, strict=True):
        small = max(1, int(sigma / 2.0))
        coarse = rng.standard_normal((-(-shape[0] // small) + 1, -(-shape[1] // small) + 1), dtype=np.float32)
        smooth = cv2.GaussianBlur(coarse, (0, 0), max(sigma / small, 0.3))
        grown = cv2.resize(smooth, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR)
        deviation = float(cv2.meanStdDev(grown)[1][0, 0])
        total = cv2.scaleAdd(grown, weight / max(deviation, 1e-6), total)
    return total


def _tinted(colour: tuple[float, float, float], grain: NDArray) -> Image:
    return cv2.merge([_speckled(level, grain) for level in colour])


def _speckled(level: float, grain: NDArray) -> Image:
    """Return a plane of grey `level` [0 to 255] that varies by `grain` [%], rounded downwards."""
    return cv2.convertScaleAbs(grain, alpha=level / 100.0, beta=level - 0.5)


@lru_cache(maxsize=4)
def floor_texture(width: float, height: float) -> Texture:
    """Return dark foam tiles of 0.61 m with grain and joints, `width` x `height` [m]."""
    shape = (round(height * FLOOR_SCALE), round(width * FLOOR_SCALE))
    grain = _grain(shape, (1.0, 6.0, 90.0), (5.0, 2.5, 5.0), seed=11)
    image = _speckled(FLOOR_GRAY, grain)
    step = round(0.61 * FLOOR_SCALE)
    image[::step], image[:, ::step] = 46, 46
    return make_texture(image, FLOOR_SCALE)


@lru_cache(maxsize=16)
def wall_texture(width: float, height: float, shade: str, seed: int = 5) -> Texture:
    """Return a wall with a skirting board, a few posters and large soft shadows, `width` x `height` [m]."""
    shape = (max(8, round(height * FLOOR_SCALE)), max(8, round(width * FLOOR_SCALE)))
    image = _tinted(SHADES_BGR[shade], _grain(shape, (2.0, 40.0, 160.0), (2.0, 4.0, 9.0), seed))
    rng = np.random.default_rng(seed + 1)
    if height > 1.0:
        _hang_posters(image, rng)
    image[-max(1, round(0.06 * shape[0])) :] //= 2
    return make_texture(image, FLOOR_SCALE)


def _hang_posters(image: Image, rng: np.random.Generator) -> None:
    """Draw windows and posters of random colour onto a wall, in place."""
    height, width = image.shape[:2]
    for _ in range(max(2, width // 300)):
        w, h = rng.integers(60, 360), rng.integers(60, 300)
        x, y = rng.integers(0, max(1, width - w)), rng.integers(0, max(1, height - h - 60))
        colour = tuple(int(c) for c in rng.integers(40, 235, 3))
        cv2.rectangle(image, (int(x), int(y)), (int(x + w), int(y + h)), colour, -1)
        cv2.rectangle(image, (int(x), int(y)), (int(x + w), int(y + h)), (50, 50, 52), 5)
        for line in range(int(y) + 30, int(y + h) - 10, 34):
            cv2.line(image, (int(x) + 12, line), (int(x + w * rng.uniform(0.4, 0.9)), line), (70, 70, 76), 6)


@lru_cache(maxsize=8)
def road_texture(road: Road) -> Texture:
    """Return the whole road from outer white edge to outer white edge.

    u runs across, from the outer left edge to the outer right edge of the road as the right lane's traffic
    sees it; v runs against the traffic, so that the picture's lower edge is the road's beginning.
    """
    shape = (round(road.length * ROAD_SCALE), round(2.0 * road.half_width * ROAD_SCALE))
    image = _tinted((FLOOR_GRAY,) * 3, _grain(shape, (2.0, 12.0, 120.0), (4.0, 2.5, 4.0), seed=23))
    tape = 1.0 + _grain(shape, (3.0, 30.0), (1.0, 2.0), seed=29)[..., None] / 100.0
    across = (np.arange(shape[1]) + 0.5) / ROAD_SCALE - road.half_width
    along = road.length - (np.arange(shape[0]) + 0.5) / ROAD_SCALE
    white = np.abs(across) > road.half_width - road.white_width
    yellow = (np.abs(across) < 0.5 * road.yellow_width)[None] & (along % (road.dash + road.gap) < road.dash)[
        :, None
    ]
    image[:, white] = np.clip(np.asarray(WHITE_BGR) * tape[:, white], 0, 255).astype(np.uint8)
    image[yellow] = np.clip(np.asarray(YELLOW_BGR) * tape[yellow], 0, 255).astype(np.uint8)
    return make_texture(image, ROAD_SCALE)
