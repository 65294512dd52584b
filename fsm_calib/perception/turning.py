"""How far a robot turned between two images, from their pixels alone, with no calibrated camera.

Each image is resampled to a small panorama: rows of equal elevation, columns of equal azimuth, through the
fleet's median camera and mount. A turn about the vertical shifts the panorama sideways; the shift with the
smallest mean squared difference is the turn. Accuracy about 0.3 deg, and 5 % of the turn for a camera at the
edge of the fleet: enough to see that a wheel moves, and to choose the next step's size; never used as a
measurement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.chessboard import as_gray
from fsm_calib.perception.fleet_camera import FLEET_MEDIAN, FLEET_SIZE
from fsm_calib.perception.lens import project
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.types import CameraMount

COLUMN = math.radians(0.25)
HALF_WIDTH = math.radians(48.0)
LOWEST, HIGHEST, ROWS = math.radians(-50.0), math.radians(14.0), 24
LARGEST_TURN = math.radians(24.0)
APART = math.radians(1.5)
"""Beyond a block of JPEG, 8 px, and within what a drive of 1 cm and more changes alike."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn between two images.

    angle : counter-clockwise positive [rad]; likeness : 1 - cost / cost without a shift [1], 0 when no shift
    explains the change; change : rms difference of the panoramas without a shift [grey levels]; autocorrelation :
    of that difference with itself `APART` to the side [1], 0 for noise, which is new in every pixel.
    """

    angle: float
    likeness: float
    change: float
    autocorrelation: float


def panorama(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the panorama of a grey or BGR image, shape (24, 385), uint8; column 0 is 48 deg to the left."""
    gray = as_gray(image)
    maps = _maps(gray.shape[1] / FLEET_SIZE[0], gray.shape[0] / FLEET_SIZE[1])
    small = cv2.remap(
        cv2.blur(gray, (3, 3)), *maps, interpolation=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(small, dtype=np.uint8)


def turn_between(before: NDArray[np.uint8], after: NDArray[np.uint8]) -> Turn:
    """Return the turn from panorama `before` to panorama `after`.

    Minimises over the shift s [columns] the mean of (after(c + s) - before(c))^2 over the common columns,
    each panorama freed of its rows' means; a parabola through the three best shifts gives the fraction.
    """
    first, second = (_without_means(item) for item in (before, after))
    reach = round(LARGEST_TURN / COLUMN)
    costs = _costs(first, second, reach)
    best = int(np.argmin(costs))
    still = float(costs[reach])
    shift = best - reach + _vertex(costs, best)
    likeness = 1.0 - float(costs[best]) / still if still > 0.0 else 0.0
    return Turn(shift * COLUMN, likeness, math.sqrt(still), _autocorrelation(second - first))


def likeness_above(before: NDArray[np.uint8], after: NDArray[np.uint8]) -> float:
    """Return how alike two panoramas are above the horizon, after the turn that makes them most alike [1].

    It is their correlation: 1 for the same, 0 for what has nothing in common. What stands above the horizon is far, so
    that it looks alike from places near one another, whatever lies on the floor.
    """
    rows = slice(0, int(np.count_nonzero(np.linspace(HIGHEST, LOWEST, ROWS) >= 0.0)))
    first, second = _without_means(before[rows]), _without_means(after[rows])
    reach = round(LARGEST_TURN / COLUMN)
    costs = _costs(first, second, reach)
    best = int(np.argmin(costs))
    left, right = max(best - reach, 0), max(reach - best, 0)
    power = float(np.mean(first[:, right : first.shape[1] - left] ** 2))
    power += float(np.mean(second[:, left : second.shape[1] - right] ** 2))
    return 1.0 - float(costs[best]) / power if power > 0.0 else 0.0


def _autocorrelation(difference: NDArray[np.float32]) -> float:
    """Return the correlation of a difference (rows, columns) with itself `APART` to the side; 0 where there is none."""
    power, apart = float(np.mean(difference * difference)), round(APART / COLUMN)
    return float(np.mean(difference[:, apart:] * difference[:, :-apart])) / power if power > 0.0 else 0.0


def _without_means(panorama: NDArray[np.uint8]) -> NDArray[np.float32]:
    return panorama.astype(np.float32) - panorama.mean(axis=1, keepdims=True, dtype=np.float32)


def _costs(first: NDArray[np.float32], second: NDArray[np.float32], reach: int) -> NDArray[np.float64]:
    """Return the mean squared differences when the world moved s columns to the right (a turn to the left),
    for s from -`reach` to `reach`.

    Over the common columns the sum of (b - a)^2 is that of b^2 and of a^2, both running sums, minus twice the
    correlation of the panoramas, which is made for all shifts at once.
    """
    rows, width = first.shape
    shifts = np.arange(-reach, reach + 1)
    padded = cv2.copyMakeBorder(second, 0, 0, reach, reach, cv2.BORDER_CONSTANT, value=0.0)
    common = cv2.matchTemplate(padded, first, cv2.TM_CCORR).ravel()
    sums = [
        np.concatenate([[0.0], np.cumsum((item * item).sum(axis=0, dtype=float))]) for item in (first, second)
    ]
    left, right = np.maximum(-shifts, 0), np.maximum(shifts, 0)
    squares = sums[0][width - right] - sums[0][left] + sums[1][width - left] - sums[1][right]
    return np.asarray((squares - 2.0 * common) / (rows * (width - np.abs(shifts))))


def _vertex(costs: NDArray[np.float64], best: int) -> float:
    """Return where the parabola through the best cost and its neighbours is lowest, in (-0.5, 0.5)."""
    if not 0 < best < costs.size - 1:
        return 0.0
    low, mid, high = costs[best - 1 : best + 2]
    bend = low - 2.0 * mid + high
    return float(0.5 * (low - high) / bend) if bend > 0.0 else 0.0


@lru_cache(maxsize=4)
def _maps(scale_x: float, scale_y: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the pixel coordinates of every cell of the panorama, for an image scaled against 640x480."""
    azimuth = np.arange(HALF_WIDTH, -HALF_WIDTH - 1e-9, -COLUMN)
    elevation = np.linspace(HIGHEST, LOWEST, ROWS)
    up, left = np.meshgrid(elevation, azimuth, indexing="ij")
    ray = np.stack([np.cos(up) * np.cos(left), np.cos(up) * np.sin(left), np.sin(up)], axis=-1).reshape(-1, 3)
    rotation, _ = base_from_camera(CameraMount())
    pixels = project(FLEET_MEDIAN, ray @ rotation).reshape(ROWS, azimuth.size, 2)
    return (
        np.ascontiguousarray(pixels[..., 0] * scale_x, dtype=np.float32),
        np.ascontiguousarray(pixels[..., 1] * scale_y, dtype=np.float32),
    )
