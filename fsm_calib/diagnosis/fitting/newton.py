"""One step of the fit: normal equations of the weighted columns, priors, bounds, and what a step promises.

Source: Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, chapter 10 (Gauss-Newton, Levenberg-Marquardt).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.fitting.slot import Slot, slot_bounds
from fsm_calib.diagnosis.likelihood.robust import robust_weights
from fsm_calib.types import FloatArray


def log_prior(slots: Sequence[Slot], numbers: FloatArray) -> float:
    """Return the log-density of normal priors, up to a constant, at `numbers` (m,)."""
    spread = np.array([slot.spread for slot in slots])
    off = numbers - np.array([slot.centre for slot in slots])
    with_prior = spread > 0
    return float(-0.5 * np.sum((off[with_prior] / spread[with_prior]) ** 2))


def normal_equations(
    white: FloatArray, residual: FloatArray, slots: Sequence[Slot], numbers: FloatArray, nu: float
) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix (m, m) and the gradient (m,) of the score, priors included.

    white : (N, m) whitened columns; residual : (N,) whitened innovations; nu : of their t distribution.
    """
    weights = robust_weights(residual, nu)
    weighted = white * weights[:, None]
    normal, gradient = weighted.T @ white, weighted.T @ residual
    for j, slot in enumerate(slots):
        if slot.spread > 0:
            normal[j, j] += 1.0 / slot.spread**2
            gradient[j] -= (numbers[j] - slot.centre) / slot.spread**2
    return normal, gradient


def damped_step(
    normal: FloatArray, gradient: FloatArray, damping: float, slots: Sequence[Slot], numbers: FloatArray
) -> FloatArray:
    """Return the numbers after one damped step inside the bounds; what a bound stops is taken out."""
    low, high = slot_bounds(slots)
    free = ~(((numbers <= low) & (gradient < 0)) | ((numbers >= high) & (gradient > 0)))
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-12))
    step = np.zeros(len(numbers))
    index = np.flatnonzero(free)
    if len(index):
        scaled = normal[np.ix_(index, index)] / np.outer(scale[index], scale[index])
        scaled += max(damping, 1e-9) * np.eye(len(index))
        step[index] = np.linalg.solve(scaled, gradient[index] / scale[index]) / scale[index]
    return np.clip(numbers + step, low, high)


def promised(normal: FloatArray, gradient: FloatArray, step: FloatArray) -> float:
    """Return what a step (m,) would win of the score if it were quadratic: g's - s'Ns / 2."""
    return float(gradient @ step - 0.5 * step @ normal @ step)


def clipped(slots: Sequence[Slot], numbers: FloatArray, tried: FloatArray) -> bool:
    """Return whether a step from `numbers` to `tried` (m,) was stopped by a bound."""
    return any(
        after != before and after in (slot.low, slot.high)
        for slot, before, after in zip(slots, numbers, tried, strict=True)
    )
