"""Numbers of an answer as JSON has them."""

from __future__ import annotations

import math


def number(value: float) -> float | None:
    """Return a number to six digits; None where it is not finite."""
    return float(f"{value:.6g}") if math.isfinite(value) else None
