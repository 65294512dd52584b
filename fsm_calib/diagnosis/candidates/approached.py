"""Fits near their end, and which of them are worth following along their valley.

Valleys take a sixth of the time of a diagnosis, and of an effect's forms one is kept. One that is farther behind the
best of them than its last steps won (six Gauss-Newton steps; the valley wins less than they did in most cases) does not
pass it: none of 313 such forms of nine robots of other engines did, and they took 91 of the valleys' 203 s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.climb import still_climbs

BEHIND = 20.0  # log-likelihood units within which every form of an effect is followed


@dataclass(frozen=True, eq=False)
class Approached:
    """A fit after its last Gauss-Newton steps, and what these won [log-likelihood units]."""

    ranked: Ranked
    won: float


def worth_following(fits: Sequence[Approached]) -> list[Approached]:
    """Return those that still climb and may pass the best of their effect."""
    best: dict[str, float] = {}
    for found in fits:
        name, score = found.ranked.name, found.ranked.fit.score
        best[name] = max(score, best.get(name, score))
    return [
        found
        for found in fits
        if still_climbs(found.won)
        and best[found.ranked.name] - found.ranked.fit.score <= max(BEHIND, found.won)
    ]
