"""Where a fit should start, by a scan: a place or a time with what it promises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

GROWTH = 3.0  # times what a candidate promises: as much as moving it and fitting it in full has won of others


@dataclass(frozen=True, slots=True)
class Candidate:
    """Start values by full parameter name, for one recording or all (-1), and the promised log-likelihood.

    elsewhere : what the best other moment promises, from which this one has to stand out.
    """

    changes: Mapping[str, float]
    promise: float
    run: int = -1
    elsewhere: float = 0.0
