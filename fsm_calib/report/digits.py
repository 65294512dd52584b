"""Numbers as text: as many digits as their standard deviation leaves, and a unit where there is one."""

from __future__ import annotations

import math

FEWEST = 6
"""Figures of a number whose deviation nobody knows."""
FIGURES = 2
"""Figures of a deviation; the value ends where it does."""


def estimate(value: float, sd: float | None, unit: str = "1", mark: str = "±") -> str:
    """Return ``0.6237 ± 0.0015 m/s``; a number without a unit has none, one without a deviation stands alone."""
    if sd is None or not math.isfinite(sd):
        return f"{value:.{FEWEST}g}{with_unit(unit)}"
    return f"{rounded(value, sd)} {mark} {rounded(sd, sd)}{with_unit(unit)}"


def rounded(value: float, sd: float) -> str:
    """Return a number to the second figure of its deviation; to six figures where that tells nothing."""
    if not (math.isfinite(sd) and sd > 0.0 and math.isfinite(value)):
        return f"{value:.{FEWEST}g}"
    places = FIGURES - 1 - math.floor(math.log10(float(f"{sd:.{FIGURES - 1}e}")))
    return f"{value:.{min(max(places, 0), 12)}f}"


def with_unit(unit: str) -> str:
    """Return a unit with the blank ahead of it; 1 is none."""
    return "" if unit == "1" else f" {unit}"
