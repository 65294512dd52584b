"""Following the sharpness while a person turns the lens's ring (paper, chapter 6).

The sharpness rises towards the sharp point and falls behind it. `has_passed` is told when the value has
fallen by more than the noise of a value from the best one; then the ring must be turned back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

_FALL = 0.05  # a value this share below the best has passed the sharp point: several times a value's noise


@dataclass(frozen=True, slots=True)
class FocusReading:
    """The sharpness now and the best so far [1], the number of the best reading, and whether it has been
    passed.
    """

    value: float
    best: float
    best_index: int
    has_passed: bool

    @property
    def share(self) -> float:
        """The value as a share of the best [1]."""
        return self.value / self.best if self.best > 0.0 else 0.0

    @property
    def sentence(self) -> str:
        """What to tell the person at the lens."""
        if self.has_passed:
            return f"you passed the sharp point: turn back ({100.0 * self.share:.0f} % of the best)"
        if self.value >= self.best:
            return "the best so far"
        return f"{100.0 * self.share:.0f} % of the best"


def read_focus(values: Sequence[float]) -> FocusReading:
    """Return the reading after the last of `values`.

    Raises
    ------
    ValueError
        No values.
    """
    if not values:
        raise ValueError("no sharpness has been measured")
    best_index = max(range(len(values)), key=values.__getitem__)
    value, best = values[-1], values[best_index]
    return FocusReading(value, best, best_index, value < (1.0 - _FALL) * best)
