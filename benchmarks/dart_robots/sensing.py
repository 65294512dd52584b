"""What a tracker and encoders make of a true trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.dart_robots.robots import Sensing
from benchmarks.dart_robots.truth import Trajectory, Watch


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the tag at the times that they are stamped with."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray


def seen(drive: Trajectory, watch: Watch, stamps: np.ndarray) -> Poses:
    """Return what a noise-free tracker would report at its `stamps`: tag, filter, delay, clock and seam."""
    x, y, theta = drive.x, drive.y, drive.theta
    if watch.smoothing:
        step = float(drive.time[1] - drive.time[0])
        x, y, theta = (_filtered(each, step / (watch.smoothing + step)) for each in (x, y, theta))
    true_time = stamps / (1.0 + watch.clock) - watch.delay
    x, y, theta = (np.interp(true_time, drive.time, each) for each in (x, y, theta))
    px = x + np.cos(theta) * watch.tag[0] - np.sin(theta) * watch.tag[1]
    py = y + np.sin(theta) * watch.tag[0] + np.cos(theta) * watch.tag[1]
    heading = theta + watch.tag_yaw
    if watch.seam is not None:
        dx, dy, turn = watch.seam_shift
        rx, ry = px - watch.seam.x, py - watch.seam.y
        inside = rx**2 + ry**2 < watch.seam.radius**2
        px = px + inside * (dx + np.cos(turn) * rx - np.sin(turn) * ry - rx)
        py = py + inside * (dy + np.sin(turn) * rx + np.cos(turn) * ry - ry)
        heading = heading + inside * turn
    return Poses(stamps, px, py, heading)


def _filtered(values: np.ndarray, share: float) -> np.ndarray:
    """Return exponentially smoothed values."""
    smooth = np.empty_like(values)
    level = values[0]
    for row, value in enumerate(values):
        level += share * (value - level)
        smooth[row] = level
    return smooth


def track(rng: np.random.Generator, drive: Trajectory, watch: Watch, sensing: Sensing) -> Poses:
    """Return noisy poses at the tracker's rate with missing frames."""
    period = 1.0 / sensing.pose_hz
    first = float(rng.uniform(0.0, period)) + watch.delay * (1.0 + watch.clock)
    last = float(drive.time[-1]) * (1.0 + watch.clock)
    stamps = np.arange(first, last, period)
    stamps = stamps + rng.uniform(-1.0, 1.0, len(stamps)) * min(sensing.stamp_jitter, 0.3 * period)
    stamps = np.clip(stamps, 0.0, last)
    stamps = stamps[rng.random(len(stamps)) >= sensing.missing]
    clean = seen(drive, watch, stamps)

    def noise(sd: float) -> np.ndarray:
        if not sensing.heavy_tail:
            return rng.normal(0.0, sd, len(stamps))
        freedom = sensing.heavy_tail
        return rng.standard_t(freedom, len(stamps)) * sd / np.sqrt(freedom / (freedom - 2.0))

    theta = clean.theta + noise(sensing.heading_sd)
    theta = (theta + np.pi) % (2 * np.pi) - np.pi
    position = sensing.position_sd
    return Poses(stamps, clean.x + noise(position), clean.y + noise(position), theta)


def counts(
    rng: np.random.Generator, drive: Trajectory, sensing: Sensing
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times and cumulative counts of left and right encoder, rounded down to whole ticks."""
    period = 1.0 / sensing.encoder_hz
    time = np.arange(float(rng.uniform(0.0, period)), float(drive.time[-1]), period)
    sides = []
    for angle in (drive.left, drive.right):
        turned = np.interp(time, drive.time, angle) * sensing.ticks_per_turn / (2 * np.pi)
        sides.append(np.floor(turned + rng.uniform(0.0, 1.0)))
    return time, sides[0], sides[1]
