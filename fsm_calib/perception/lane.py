"""The robot's pose in its lane from one image.

White and yellow pixels are projected to the floor. In the lane's frame a floor point p = (x, y) of `base` has
the lateral coordinate s = d + x sin(phi) + y cos(phi) [m] (left of the lane's centre positive); pixels of the
white line have s near -(w + w_white)/2, those of the yellow one s near (w + w_yellow)/2, with w the clear
width of the lane. A vote over (d, phi) finds the lane, a robust least-squares fit of both lines refines it.
Source of the idea: Paull et al., Duckietown, ICRA 2017 (the lane filter's histogram); signs as Duckietown's
LanePose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.ground import floor_points
from fsm_calib.perception.tape_colours import tape_masks, tape_values
from fsm_calib.types import CameraModel, CameraMount, FloatArray, LanePose


@dataclass(frozen=True, slots=True)
class LaneSettings:
    """The lane's geometry (Duckietown appearance specification) and the search.

    Parameters
    ----------
    lane_width : float
        Clear width between the tapes [m].
    white_width, yellow_width : float
        Widths of the tapes [m].
    nearest, farthest : float
        Floor points used, distance ahead of the axle [m].
    largest_d, largest_phi : float
        Range of the vote [m], [rad].
    inlier : float
        A point votes for a line when it is within half the tape and this much more of it [m].
    smallest_support : int
        Fewer points than this are no lane.
    most_points : int
        Pixels kept per colour, taken evenly.
    """

    lane_width: float = 0.219
    white_width: float = 0.048
    yellow_width: float = 0.024
    nearest: float = 0.05
    farthest: float = 0.60
    largest_d: float = 0.20
    largest_phi: float = math.radians(75.0)
    inlier: float = 0.012
    smallest_support: int = 40
    most_points: int = 600


DEFAULT_LANE = LaneSettings()
_BLOCK = 8  # px: side of the blocks that tell how bright the floor is, without its noise


def observe_lane(
    image: NDArray[np.uint8], camera: CameraModel, mount: CameraMount, settings: LaneSettings = DEFAULT_LANE
) -> LanePose | None:
    """Return where the robot is in its lane, or None when no lane is seen.

    Parameters
    ----------
    image : array, shape (height, width, 3), uint8, BGR
    """
    hsv = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), dtype=np.uint8)
    begins = tape_values(_floor_colours(image, camera, mount, settings))
    white, yellow = (_floor_pixels(mask, camera, mount, settings) for mask in tape_masks(hsv, begins))
    start = _vote(white, yellow, settings)
    return None if start is None else _refine(white, yellow, start, settings)


def _floor_colours(
    image: NDArray[np.uint8], camera: CameraModel, mount: CameraMount, settings: LaneSettings
) -> NDArray[np.uint8]:
    """Return hue, saturation and value (n, 3) of the floor inside the range: means over blocks of the image."""
    height, width = image.shape[0] // _BLOCK, image.shape[1] // _BLOCK
    whole = image[: height * _BLOCK, : width * _BLOCK]
    means = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)
    blocks = np.asarray(cv2.cvtColor(means, cv2.COLOR_BGR2HSV), dtype=np.uint8)
    rows, columns = np.mgrid[:height, :width].reshape(2, -1)
    centres = (np.column_stack([columns, rows]) + 0.5) * _BLOCK - 0.5
    return blocks[rows, columns][_is_in_range(floor_points(centres, camera, mount), settings)]


def _is_in_range(points: FloatArray, settings: LaneSettings) -> NDArray[np.bool_]:
    ahead = (points[:, 0] > settings.nearest) & (points[:, 0] < settings.farthest)
    return np.asarray(ahead & (np.abs(points[:, 1]) < settings.farthest))


def _floor_pixels(
    mask: NDArray, camera: CameraModel, mount: CameraMount, settings: LaneSettings
) -> FloatArray:
    """Return floor points (n, 2) [m] of the set pixels inside the range, thinned evenly."""
    places = np.flatnonzero(mask)
    step = max(1, places.size // (4 * settings.most_points))
    rows, columns = np.divmod(places[::step], mask.shape[1])
    points = floor_points(np.column_stack([columns, rows]), camera, mount)
    points = points[_is_in_range(points, settings)]
    return points[:: max(1, len(points) // settings.most_points)]


def _line_offsets(settings: LaneSettings) -> tuple[float, float]:
    white = -(settings.lane_width + settings.white_width) / 2.0
    return white, (settings.lane_width + settings.yellow_width) / 2.0


def _laterals(points: FloatArray, d: FloatArray | float, phi: FloatArray | float) -> FloatArray:
    return d + points[:, 0] * np.sin(phi) + points[:, 1] * np.cos(phi)


def _vote(white: FloatArray, yellow: FloatArray, settings: LaneSettings) -> tuple[float, float] | None:
    """Return the (d, phi) that most points agree with, both colours weighing the same."""
    if len(white) + len(yellow) < settings.smallest_support:
        return None
    d = np.arange(-settings.largest_d, settings.largest_d, 0.01)
    phi = np.arange(-settings.largest_phi, settings.largest_phi, math.radians(3.0))
    score = np.zeros((phi.size, d.size))
    widths = (settings.white_width, settings.yellow_width)
    for points, offset, width in zip((white, yellow), _line_offsets(settings), widths, strict=True):
        if len(points):
            side = np.sort(np.sin(phi)[:, None] * points[:, 0] + np.cos(phi)[:, None] * points[:, 1], axis=1)
            reach = width / 2.0 + settings.inlier
            near = [_between(row, offset - d - reach, offset - d + reach) for row in side]
            score += np.array(near) / max(len(points), settings.smallest_support) / reach
    best = np.unravel_index(int(np.argmax(score)), score.shape)
    return float(d[best[1]]), float(phi[best[0]])


def _between(ordered: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return how many of the ordered values lie between `low` and `high`, each of shape (n,)."""
    count = np.searchsorted(ordered, high, side="left") - np.searchsorted(ordered, low, side="right")
    return count.astype(float)


def _refine(
    white: FloatArray, yellow: FloatArray, start: tuple[float, float], settings: LaneSettings
) -> LanePose | None:
    """Return the robust least-squares pose: points near their line, weighed down as they leave it."""
    d, phi = start
    offsets = np.repeat(_line_offsets(settings), (len(white), len(yellow)))
    halves = np.repeat((settings.white_width / 2.0, settings.yellow_width / 2.0), (len(white), len(yellow)))
    points = np.vstack([white, yellow])
    inside = np.zeros(len(points), dtype=bool)
    for _ in range(8):
        residual = _laterals(points, d, phi) - offsets
        scale = halves + settings.inlier
        inside = np.abs(residual) < scale
        if int(inside.sum()) < settings.smallest_support:
            return None
        weight = np.where(inside, (1.0 - (residual / scale) ** 2) ** 2, 0.0)
        slope = points[:, 0] * np.cos(phi) - points[:, 1] * np.sin(phi)
        design = np.column_stack([np.ones(len(points)), slope]) * weight[:, None]
        normal = design.T @ np.column_stack([np.ones(len(points)), slope]) + np.eye(2) * 1e-9
        step = np.linalg.solve(normal, -design.T @ residual)
        d, phi = d + float(step[0]), phi + float(step[1])
    if abs(d) > 2.0 * settings.largest_d or abs(phi) > math.pi / 2.0:
        return None
    return LanePose(d=d, phi=phi, support=int(inside.sum()))
