"""How many of the best moments stand out together from all others?

What is inexact somewhere falls off from moment to moment as exponentials do, of which k times the gap between the kth
and the next is one more. So k moments stand out together where that gap is worth one of them, as the kth is by itself,
and where it is CLEARLY a part of what the next wins. Source: Renyi, Acta Math. Hung. 4 (1953) 191.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from fsm_calib.diagnosis.shapes.score_tests import ALPHA

CLEARLY = 0.6  # of what the next moment wins
MOMENTS = 9  # the next best ones, by which it is told how fast they fall off
RARE = 2.0 * ALPHA  # chance up to which a moment is asked: the odds of its name count it once more
LEAST_FALL = 1.0  # log-likelihood units: the tail of half a chi-squared, where equations are exact


def by_chance(won: Sequence[float], together: int = 1) -> float:
    """Return the probability that the first of `won` stand out so far from the others where nothing happened.

        p = (1 + t / n)^-n,    t = k (w_k - w_k+1) / f,    f = sum_j j (w_j - w_j+1) / n,  j = k + 1 .. k + n

    won : log-likelihoods w of moments apart in time, falling, the first k = `together` of which are asked about; f how
    fast the next n fall off, a mean of n exponentials, so that t is of Fisher's F(2, 2n). No model falls off faster
    than LEAST_FALL.
    """
    others = won[together : together + MOMENTS]
    n = len(others) - 1
    gap = together * (won[together - 1] - others[0]) if others else math.inf
    if n < 1:
        return math.exp(-gap)
    steps = sum((together + j) * (others[j - 1] - others[j]) for j in range(1, n + 1))
    fall = max(steps / n, LEAST_FALL)
    return float((1.0 + max(gap, 0.0) / fall / n) ** -n)


def standing_out(won: Sequence[float], worth: float, most: int) -> int:
    """Return how many of `won` (log-likelihoods of moments apart in time, falling) stand out, 0 to `most`.

    worth : log-likelihood that the numbers of one cost. The last of `won` has to be one that does not.
    """
    sizes = range(1, min(most + 1, len(won)))
    gaps = {k: won[k - 1] - won[k] for k in sizes if won[k - 1] >= worth}
    return max((k for k, gap in gaps.items() if k * gap >= worth and gap >= CLEARLY * won[k]), default=0)
