"""Where a fit should start, by a scan: a place or a time with what it promises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

FAINT = 12.0  # log-likelihood units: below, only a scan's best candidate is fitted, no larger one sought
GROWTH = 3.0  # times what a candidate promises: as much as moving it and fitting it in full has won of others


@dataclass(frozen=True, slots=True)
class Candidate:
    """Start values by full parameter name, for one recording or all (-1), and the promised log-likelihood.

    chance : with which probability one moment in all of the recordings promises so much more than the next
    (`outstanding.by_chance`); 0 where no moment was sought. each : of an event that
    comes alike in every recording, what is each recording's own (when it came); empty for all others.
    """

    changes: Mapping[str, float]
    promise: float
    run: int = -1
    chance: float = 0.0
    each: tuple[Mapping[str, float], ...] = ()

    @property
    def size(self) -> int:
        """How many numbers it tells."""
        return len(self.changes) + sum(len(own) for own in self.each)
