"""Fits near their end, and which of them are worth following along their valley.

A valley is a third of the time of a diagnosis, and of an effect's forms one is kept. One that is farther behind the
best of them than its last steps won (six Gauss-Newton steps; the valley wins less than they did in most cases) does not
pass it: none of 339 such forms of eight robots of other engines did, and they took two fifths of the valleys' time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranked import Ranked

BEHIND = 20.0  # log-likelihood units within which every form of an effect is followed


@dataclass(frozen=True, eq=False)
class Approached:
    """A fit after its last Gauss-Newton steps, what these won [log-likelihood units], and whether it still climbs."""

    ranked: Ranked
    won: float
    goes_on: bool


def worth_following(fits: Sequence[Approached]) -> list[Approached]:
    """Return those that still climb and may pass the best of their effect."""
    best: dict[str, float] = {}
    for found in fits:
        name, score = found.ranked.name, found.ranked.fit.score
        best[name] = max(score, best.get(name, score))
    return [f for f in fits if f.goes_on and best[f.ranked.name] - f.ranked.fit.score <= max(BEHIND, f.won)]
