"""How much an effect shows: 2 s displacements with and without it, after the base's numbers are re-fitted.

Both drives have the same commands. The differences of their 2 s displacements (in the frame of each window's start) are
regressed on what the two wheel gains, the axle length and the two time constants of the base can move (first order), and
what is left is set against the noise of a pose (sideways also against what two fifths of a heading's noise
turn the way). `ratio` = sqrt(1 + mean square of it): 1 = nothing to be seen. Effects of
a place or a time are judged over the windows that they touch.
"""

from __future__ import annotations

import numpy as np

from foreign.drive import Drive
from foreign.robots import Robot
from foreign.setup import Array, Setup
from foreign.tracker import clean_poses

HORIZON = 2.0  # s
RATE = 50.0  # Hz


def displacements(poses: Array, span: int, stride: int) -> Array:
    """Return displacements (n, 3) over `span` rows, each in the frame of its start."""
    a, b = poses[:-span:stride], poses[span::stride]
    d = b - a
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    return np.column_stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2]])


def paths(times: Array, forward: Array, omega: Array) -> Array:
    """Integrate a unicycle (midpoint)."""
    dt = np.diff(times, prepend=times[0])
    theta = np.cumsum(omega * dt)
    middle = theta - 0.5 * omega * dt
    return np.column_stack(
        [np.cumsum(forward * np.cos(middle) * dt), np.cumsum(forward * np.sin(middle) * dt), theta]
    )


def levers(robot: Robot, drive: Drive, times: Array, span: int, stride: int) -> Array:
    """Return how displacements (n, 3) move with each of five numbers of the base: (n, 3, 5)."""
    rows = np.column_stack([np.interp(times, drive.grid, drive.rows[:, i]) for i in range(6)])
    forward = rows[:, 3] * np.cos(rows[:, 2]) + rows[:, 4] * np.sin(rows[:, 2])
    omega, axle = rows[:, 5], robot.parts["body"]["axle"]
    left, right = forward - omega * axle / 2, forward + omega * axle / 2
    late_f, late_o = (np.interp(times - 0.02, times, z) for z in (forward, omega))
    base = displacements(paths(times, forward, omega), span, stride)
    changed = [
        ((1.01 * left + right) / 2, (right - 1.01 * left) / axle),
        ((left + 1.01 * right) / 2, (1.01 * right - left) / axle),
        (forward, 1.01 * omega),
        (late_f, omega),
        (forward, late_o),
    ]
    return np.stack([displacements(paths(times, f, o), span, stride) - base for f, o in changed], axis=-1)


def ratio(
    robot: Robot, drives: list[tuple[Setup, Drive, Setup, Drive]], local: bool, refit: bool = True
) -> float:
    """Return the ratio for pairs (setup with, drive with, setup without, drive without)."""
    span, stride = int(HORIZON * RATE), int(0.5 * RATE)
    noise = np.array([robot.sensing["noise"], robot.sensing["noise"], robot.sensing["turn_noise"]]) * np.sqrt(
        1.3
    )
    gaps, moves = [], []
    for with_setup, with_drive, base_setup, base_drive in drives:
        times, one = clean_poses(with_setup, with_drive, RATE, 0.0)
        _, two = clean_poses(base_setup, base_drive, RATE, 0.0)
        still = displacements(two, span, stride)
        sigma = np.tile(noise, (len(still), 1))
        sigma[:, 1] = np.hypot(noise[1], 0.4 * robot.sensing["turn_noise"] * np.abs(still[:, 0]))
        gaps.append((displacements(one, span, stride) - still) / sigma)
        moves.append(levers(robot, base_drive, times, span, stride) / sigma[:, :, None])
    gap, move = np.concatenate(gaps), np.concatenate(moves)
    if refit:
        flat = move.reshape(-1, move.shape[-1])
        scale = np.linalg.norm(flat, axis=0) + 1e-12
        target = gap.ravel()
        weight = np.ones(len(target))
        for _ in range(3):  # robust: a push is not fitted by gains
            part, *_rest = np.linalg.lstsq(flat / scale * weight[:, None], target * weight, rcond=1e-6)
            left = target - flat / scale @ part
            weight = 1.0 / np.sqrt(1.0 + (left / (3.0 * (np.median(np.abs(left)) + 0.3))) ** 2)
        gap = left.reshape(gap.shape)
    size = np.abs(gap).max(axis=1)
    touched = size > 0.15 * size.max() if local else np.ones(len(size), dtype=bool)
    if not size.max() > 0:
        return 1.0
    power = gap[touched] ** 2
    return float(np.sqrt(1.0 + max(power[:, :2].mean(), power[:, 2].mean())))
