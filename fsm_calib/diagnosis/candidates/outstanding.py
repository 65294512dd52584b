"""How many of the best moments stand out together from all others?

What is inexact somewhere falls off from moment to moment as exponentials do, of which k times the gap between the kth
and the next is one more. So k moments stand out together where that gap is worth one of them, as the kth is by itself,
and where it is CLEARLY a part of what the next wins. Source: Renyi, Acta Math. Hung. 4 (1953) 191.
"""

from __future__ import annotations

from collections.abc import Sequence

CLEARLY = 0.6  # of what the next moment wins


def standing_out(won: Sequence[float], worth: float, most: int) -> int:
    """Return how many of `won` (log-likelihoods of moments apart in time, falling) stand out, 0 to `most`.

    worth : log-likelihood that the numbers of one cost. The last of `won` has to be one that does not.
    """
    sizes = range(1, min(most + 1, len(won)))
    gaps = {k: won[k - 1] - won[k] for k in sizes if won[k - 1] >= worth}
    return max((k for k, gap in gaps.items() if k * gap >= worth and gap >= CLEARLY * won[k]), default=0)
