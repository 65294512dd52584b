"""What is written down: poses of the tag with noise, outliers and gaps; ticks of the wheels."""

from __future__ import annotations

import numpy as np

from foreign.drive import Drive
from foreign.robots import Robot
from foreign.setup import Array, Setup, Track


def clean_poses(setup: Setup, drive: Drive, rate: float, phase: float) -> tuple[Array, Array]:
    """Return stamps (n,) and the poses (n, 3) that a tracker without noise would show."""
    end = float(drive.grid[-1])
    times = np.arange(0.02 + phase / rate, end, 1.0 / rate)
    track = Track(drive.grid, drive.rows[:, :6].copy(), times, times.copy(), np.zeros(3))
    for act in setup.sensing:
        act(track)
    shown = np.clip(track.shown, track.grid[0], end)
    x, y, theta = (np.interp(shown, track.grid, track.states[:, i]) for i in range(3))
    c, s = np.cos(theta), np.sin(theta)
    mx, my, mt = track.mount
    poses = np.column_stack([x + c * mx - s * my, y + s * mx + c * my, theta + mt])
    for after in track.after:
        poses = after(times, poses)
    return times, poses


def noisy(robot: Robot, times: Array, poses: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Add noise with tails (Student's t), outliers, dropped frames and two gaps; stamps jitter by half a millisecond."""
    s = robot.sensing
    n, tails = len(times), s["tails"]
    draws = rng.standard_t(tails, (n, 3)) / np.sqrt(tails / (tails - 2))
    poses = poses + draws * [s["noise"], s["noise"], s["turn_noise"]]
    wild = rng.random(n) < s["outliers"]
    poses[wild] += rng.normal(size=(int(wild.sum()), 3)) * [
        15 * s["noise"],
        15 * s["noise"],
        10 * s["turn_noise"],
    ]
    keep = rng.random(n) >= s["dropped"]
    for start in rng.uniform(5, times[-1] - 3, 2):
        keep &= ~((times > start) & (times < start + rng.uniform(0.1, 0.6)))
    times = times + rng.uniform(0, 0.0005, n)
    poses[:, 2] = np.angle(np.exp(1j * poses[:, 2]))
    return times[keep], poses[keep]


def ticks(robot: Robot, drive: Drive, rng: np.random.Generator) -> Array | None:
    """Return rows (n, 3) of time and whole ticks at 20 to 50 Hz, or None without encoders."""
    per_turn = robot.sensing["ticks"]
    if not per_turn:
        return None
    times = np.arange(0.03, drive.grid[-1], 1.0 / float(rng.choice([20.0, 30.0, 50.0])))
    counts = [
        np.floor((np.interp(times, drive.grid, drive.rows[:, c]) / (2 * np.pi) + p) * per_turn)
        for c, p in ((6, 0.3), (7, 0.7))
    ]
    return np.column_stack([times, *counts])
