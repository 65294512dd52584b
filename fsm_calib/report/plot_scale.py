"""One axis of a plot: from values to places in the figure, and where its ticks are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fsm_calib.types import FloatArray

_ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Steps between ticks within a power of ten."""


@dataclass(frozen=True)
class Scale:
    """A linear axis.

    Parameters
    ----------
    low, high : float
        Values at its two ends, not equal; `low` is the larger one where values run the other way.
    begin, end : float
        Where these ends are in the figure [px].
    """

    low: float
    high: float
    begin: float
    end: float

    def __call__(self, values: FloatArray | float) -> FloatArray:
        """Return where values are in the figure [px], in the shape of `values`."""
        share = (np.asarray(values, dtype=float) - self.low) / (self.high - self.low)
        return np.asarray(self.begin + share * (self.end - self.begin))

    def ticks(self, most: int = 6, least_step: float = 0.0) -> list[tuple[float, str]]:
        """Return (value, label) of at most about `most` round values; at least `least_step` apart."""
        low, high = sorted((self.low, self.high))
        step = max(round_step((high - low) / most), least_step)
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        return [(number * step, tick_label(number * step, step)) for number in range(first, last + 1)]


def round_step(least: float) -> float:
    """Return the smallest round number (1, 2, 2.5 or 5 times a power of ten) that is not below `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in _ROUND if step * power >= least * (1.0 - 1e-9))


def tick_label(value: float, step: float) -> str:
    """Return a value with as many decimals as multiples of `step` need."""
    decimals = next((count for count in range(12) if math.isclose(round(step, count), step)), 12)
    return f"{value + 0.0:.{decimals}f}".replace("-", "−")


def limits(values: FloatArray, margin: float = 0.06) -> tuple[float, float]:
    """Return the range of values, wider by `margin` of it on either side; of one value, 1 wide or so."""
    low, high = float(np.min(values)), float(np.max(values))
    room = margin * (high - low) or max(abs(low), 1.0)
    return low - room, high + room
