"""Points of a plane as complex numbers: a turn is a product, a shift a sum."""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray


def as_complex(points: FloatArray) -> np.ndarray:
    """Return x + i y of points (..., 2), shape (...)."""
    return np.asarray(points[..., 0] + 1j * points[..., 1])


def sum_by_group(values: np.ndarray, group: np.ndarray, count: int = 0) -> np.ndarray:
    """Return the sums of values (n,) that have the same number in `group` (n,), shape (at least count,)."""
    return np.asarray(np.bincount(group, values.real, count) + 1j * np.bincount(group, values.imag, count))
