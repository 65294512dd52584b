"""Choose how strong a hidden effect is by what it costs a base robot that was re-fitted to it.

    ratio = sqrt(1 + (e / f)²)

e: rms difference over 2 s between the robot and the base re-fitted to it (gains, axle, motor strength, inertia);
f: rms over 2 s of what random disturbance and measurement noise alone give; position and heading, the larger ratio.
"""

from __future__ import annotations

import numpy as np

from concealed.drives import Drive
from concealed.physics import Physics, simulate
from concealed.robots import Change, Sensor, observe

FREE = ("gain_left", "gain_right", "axle", "stall", "inertia")
STEP = 0.001
GRID = 0.05
HORIZON = 2.0


def relative_motion(poses: np.ndarray, lag: int) -> np.ndarray:
    """Motion over `lag` samples in the frame at its start, shape (n - lag, 3)."""
    d = poses[lag:] - poses[:-lag]
    c, s = np.cos(poses[:-lag, 2]), np.sin(poses[:-lag, 2])
    return np.stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2]], 1)


def _poses(
    physics: Physics, drive: Drive, start: np.ndarray, effect: Change, rng: np.random.Generator | None = None
) -> np.ndarray:
    times, states = simulate(physics, *drive.arrays(), start, drive.end, rng, step=STEP)
    stamps = np.arange(0.0, drive.end - 0.01, GRID)
    return observe(times, states, stamps * (1.0 + effect.get("drift", 0.0)), effect)


def refit(truth: np.ndarray, drive: Drive, start: np.ndarray, guess: Physics, iterations: int = 4) -> Physics:
    """Fit the base's five levels to noise-free poses by Gauss-Newton on 0.5 s motions."""
    scale = np.array([1.0, 1.0, 0.3])
    lag = int(0.5 / GRID)
    target = relative_motion(truth, lag) * scale
    physics = guess
    for _ in range(iterations):
        here = relative_motion(_poses(physics, drive, start, {}), lag) * scale
        columns = []
        for name in FREE:
            bumped = physics._replace(**{name: getattr(physics, name) * 1.01})
            columns.append(
                ((relative_motion(_poses(bumped, drive, start, {}), lag) * scale) - here).ravel() / 0.01
            )
        step, *_ = np.linalg.lstsq(np.stack(columns, 1), (target - here).ravel(), rcond=None)
        physics = physics._replace(
            **{n: getattr(physics, n) * float(np.clip(1 + d, 0.6, 1.6)) for n, d in zip(FREE, step)}
        )
    return physics


def _rms(error: np.ndarray) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error[:, 0] ** 2 + error[:, 1] ** 2))), float(
        np.sqrt(np.mean(error[:, 2] ** 2))
    )


def floor(
    physics: Physics, sensor: Sensor, drive: Drive, start: np.ndarray, rng: np.random.Generator
) -> tuple[float, float]:
    """2 s error [m], [rad] that the true model would still have."""
    lag = int(HORIZON / GRID)
    quiet, noisy = _poses(physics, drive, start, {}), _poses(physics, drive, start, {}, rng)
    noisy = noisy + rng.standard_normal(noisy.shape) * [sensor.sigma_xy, sensor.sigma_xy, sensor.sigma_theta]
    return _rms(relative_motion(noisy, lag) - relative_motion(quiet, lag))


def ratio(
    physics: Physics,
    effect: Change,
    base: Physics,
    drive: Drive,
    start: np.ndarray,
    noise: tuple[float, float],
) -> float:
    """How many times the floor the re-fitted base errs over 2 s."""
    lag = int(HORIZON / GRID)
    truth = _poses(physics, drive, start, effect)
    fitted = refit(truth, drive, start, base)
    xy, theta = _rms(relative_motion(truth, lag) - relative_motion(_poses(fitted, drive, start, {}), lag))
    return float(np.sqrt(1.0 + max(xy / noise[0], theta / noise[1]) ** 2))
