"""How much of what decays is gone after a step."""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC

SMALL = 0.02
"""Times of the decay's own below which its series is used: seven terms are right to 1e-15 there."""


@njit(**ARITHMETIC, forceinline=True)
def gone(time):
    """Return 1 - exp(-time), `time` [1] in units of the decay's own; by its series when it is small, for speed."""
    if abs(time) > SMALL:
        return -math.expm1(-time)
    rest = 1.0 - time * (1.0 / 5.0) * (1.0 - time * (1.0 / 6.0) * (1.0 - time * (1.0 / 7.0)))
    return time * (1.0 - time * 0.5 * (1.0 - time * (1.0 / 3.0) * (1.0 - time * 0.25 * rest)))
