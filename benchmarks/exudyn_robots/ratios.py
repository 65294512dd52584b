"""How visible an effect is: what remains of it in 2 s displacements after the calibration of a simple
robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.exudyn_robots.robots import Setup

WINDOW = 2.0
GRID = 0.1
HOP = 5


@dataclass
class Visible:
    """Ratios of an effect: the larger, position's, heading's; share of windows touched, and seconds
    touched by run.
    """

    ratio: float
    position: float
    heading: float
    touched: float
    seconds: list[float]


def displacements(pose: np.ndarray) -> np.ndarray:
    """Displacements over WINDOW in the own frame, (n, 3), of poses on the GRID."""
    k = round(WINDOW / GRID)
    a, b = pose[:-k:HOP], pose[k::HOP]
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    dx, dy = b[:, 0] - a[:, 0], b[:, 1] - a[:, 1]
    return np.stack([c * dx + s * dy, -s * dx + c * dy, b[:, 2] - a[:, 2]], axis=1)


def kinematic(
    setup: Setup, commands: np.ndarray, end: float, gain: np.ndarray, axle: float, tau: float
) -> np.ndarray:
    """Poses on the GRID of v = gain * command through one first-order lag (m/s, m, s), exact arcs of
    20 ms.
    """
    h = 0.02
    n = int(end / h) + 1
    index = np.minimum((np.arange(n) * h * setup.sensing.command_hz + 1e-6).astype(int), len(commands) - 1)
    want = commands[index] * gain
    v = np.zeros_like(want)
    keep = math.exp(-h / tau)
    for k in range(1, n):
        v[k] = keep * v[k - 1] + (1.0 - keep) * want[k - 1]
    turn = np.cumsum((v[:, 1] - v[:, 0]) / axle) * h
    ahead = 0.5 * (v[:, 0] + v[:, 1]) * h
    pose = np.stack([np.cumsum(ahead * np.cos(turn)), np.cumsum(ahead * np.sin(turn)), turn], axis=1)
    return pose[:: round(GRID / h)]


def measure(
    setup: Setup, pairs: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], local: bool
) -> Visible:
    """Ratio over runs; each run: commands, poses with, poses without (on GRID), active flags on GRID."""
    gain = np.full(2, setup.sheet["max_wheel_rate"] * setup.sheet["wheel_radius"])
    axle, tau = setup.sheet["axle_length"], setup.time_constant
    noise = math.sqrt(2.0) * np.array([setup.sensing.position_sd] * 2 + [setup.sensing.heading_sd])
    rests, columns, masks, seconds = [], [], [], []
    for commands, with_it, without, active in pairs:
        n = min(len(with_it), len(without))
        d = (displacements(with_it[:n]) - displacements(without[:n])) / noise
        end = (n + 2) * GRID
        base = displacements(kinematic(setup, commands, end, gain, axle, tau)[:n])
        bumps = []
        for g, a, k in (
            ((1.02, 1.0), 1.0, 1.0),
            ((1.0, 1.02), 1.0, 1.0),
            ((1.0, 1.0), 1.02, 1.0),
            ((1.0, 1.0), 1.0, 1.1),
        ):
            bent = displacements(kinematic(setup, commands, end, gain * np.array(g), axle * a, tau * k)[:n])
            bumps.append(((bent - base) / noise)[: len(d)])
        rests.append(d)
        columns.append(np.stack(bumps, axis=-1))
        k = round(WINDOW / GRID)
        starts = range(0, n - k, HOP)
        masks.append(np.array([bool(np.any(active[i : i + k + 1])) for i in starts])[: len(d)])
        seconds.append(float(np.sum(active[:n]) * GRID))
    d = np.concatenate(rests)
    a = np.concatenate(columns)
    best, *_ = np.linalg.lstsq(a.reshape(-1, a.shape[-1]), d.reshape(-1), rcond=None)
    rest = d - a @ best
    mask = np.concatenate(masks)
    part = rest[mask] if local and mask.any() else rest
    position = math.sqrt(1.0 + float(np.mean(part[:, :2] ** 2)))
    heading = math.sqrt(1.0 + float(np.mean(part[:, 2] ** 2)))
    touched = float(mask.mean()) if local else 1.0
    return Visible(max(position, heading), position, heading, touched, seconds)
