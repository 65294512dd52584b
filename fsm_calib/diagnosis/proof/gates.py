"""The few numbers that decide a verdict, and what a model leaves, in one value.

docs/constants.md lists them with unit, meaning and the data that set them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranked import EXACT
from fsm_calib.diagnosis.shapes.score_tests import LeftOver


@dataclass(frozen=True, slots=True)
class Gates:
    """Thresholds of the decision.

    detect : evidence that an effect needs (of 90 robots without one none has more than 12 with a scanned place,
    plain ones win 5.9 at most); an event needs twice what the best other moment promises on top. The first needs
    `first`, since what is inexact in the base robot has no name, either. further_share : of the first effect's
    evidence, alone, that each further one must add (EXACT). Forms without a name that have more than `detect` are no
    match (of 290 clean robots one has more than 6: jumps of the poses worth 14). most : effects of one robot.
    least_confidence : probability that a name must have to be said.
    """

    detect: float = 14.0
    further_share: float = EXACT
    most: int = 6
    least_confidence: float = 0.6

    @property
    def first(self) -> float:
        """Evidence that the first effect needs over the base robot: twice `detect`.

        Of 62 clean robots of another generator two have more than 14 by one of some hundred closures (19 and 22), while
        effects of 1.1 to 1.5 times the floor have 270 to 5,000.
        """
        return 2.0 * self.detect


DEFAULT_GATES = Gates()


@dataclass(frozen=True, slots=True)
class Adequacy:
    """What is left after a model: the largest surprise, the log-likelihood its group could win, that over the gain."""

    surprise: float
    left: float
    share: float
    group: str


def adequacy(tests: Sequence[LeftOver], gain: float) -> Adequacy:
    """Summarise left-over tests of a model that won `gain` log-likelihood over the base."""
    worst = max(tests, key=lambda t: t.surprise)
    left = max((t.gain for t in tests if t.surprise > 3.0), default=0.0)
    return Adequacy(worst.surprise, left, left / max(gain, 1.0), worst.group.name)
