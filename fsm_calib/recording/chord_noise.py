"""The white noise of a measured series, told by the series itself."""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray


def chord_noise(value: FloatArray) -> float:
    """Return the white noise's standard deviation from the deviations of each value from its neighbours' chord."""
    middle = value[1:-1] - 0.5 * (value[:-2] + value[2:])
    if not len(middle):
        return 1e-3
    quartile = float(np.quantile(np.abs(middle), 0.25))  # 0.3186 standard deviations; motion only adds
    return float(max(quartile / 0.3186 / np.sqrt(1.5), 1e-6))
