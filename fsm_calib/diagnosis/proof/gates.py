"""Three gates before a name is said: detected, adequate, useful. And who cannot be told from whom.

The thresholds were read from generated robots with varied disturbance, outliers, rates and tag colour, clean ones,
ones with physics outside the catalogue, and ones whose true effect was taken out of it
(`benchmarks/concealed`, development seeds and sets whose key had been opened before; never the sealed set).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranking import Ranked
from fsm_calib.diagnosis.shapes.score_tests import LeftOver


@dataclass(frozen=True, slots=True)
class Gates:
    """Thresholds of the decision.

    Detected. detect : evidence that a first name needs (of 90 generated robots without an effect none has more than
    12); an event needs twice what the best other moment promises on top, since random forces have moments of their
    own; unexplained_surprise : surprise above which recordings without a name are no match, if it is significant after
    the looking, too; nameless : evidence of forms above which they are none either (of 290 such robots one has more
    than 6: jumps of the poses worth 14).

    Adequate. surprise : -log10 p of left-over structure in any feature group that is still noise; share : left-over
    log-likelihood over explained below which the equation may be inexact but the name stands; dominant : share of
    the base's error over the horizon below which a name stands whatever finer structure is left (real trackers and
    floors always leave some).

    Unrivalled. rival : evidence gap below which two names are one set; form_instead : evidence by which forms without
    a name may beat the name (`contest.py`), or instead_share of the name's own, whichever is more (a form may be the
    name's own law, a hair nearer to the truth); form_beside : evidence that they may add to it, or form_share of the
    name's own, whichever is more (an equation that is exact to a fifth of the effect leaves a 25th of its
    likelihood); loose_share : the same of places and moments, whose edges no equation draws exactly, and of robots
    with a controller of their own; pair_beside : of two names whose equations are exact; ruling : share of the base's
    error below which forms have no say; least_confidence : probability that a name, or a set that the data cannot
    tell apart, must have.

    Two effects. curious : surprise after a first name above which a second is looked for, as it is where forms win;
    second : evidence that it needs, and second_share of the first's, as form_share (it must be missed, too, when it
    is taken out again).
    """

    detect: float = 14.0
    surprise: float = 6.0
    share: float = 0.12
    rival: float = 8.0
    second: float = 20.0
    second_share: float = 0.04
    unexplained_surprise: float = 4.2
    nameless: float = 20.0
    curious: float = 4.5
    dominant: float = 0.25
    ruling: float = 0.15
    least_confidence: float = 0.6
    form_instead: float = 10.0
    instead_share: float = 0.02
    form_beside: float = 10.0
    form_share: float = 0.04
    loose_share: float = 0.15
    pair_beside: float = 8.0


DEFAULT_GATES = Gates()


@dataclass(frozen=True, slots=True)
class Adequacy:
    """What is left after a model: the largest surprise, the log-likelihood its group could win, that over the gain."""

    surprise: float
    left: float
    share: float
    group: str

    def passes(self, gates: Gates) -> bool:
        """Return whether the model may be called adequate."""
        return self.surprise < gates.surprise or self.share < gates.share


def adequacy(tests: Sequence[LeftOver], gain: float) -> Adequacy:
    """Summarise left-over tests of a model that won `gain` log-likelihood over the base."""
    worst = max(tests, key=lambda t: t.surprise)
    left = max((t.gain for t in tests if t.surprise > 3.0), default=0.0)
    return Adequacy(worst.surprise, left, left / max(gain, 1.0), worst.group.name)


def indistinguishable(ranking: Sequence[Ranked], gates: Gates) -> list[str]:
    """Return the names whose evidence comes within `rival` of the first, the first included."""
    if not ranking:
        return []
    top = ranking[0].evidence
    return [r.name for r in ranking if top - r.evidence < gates.rival and r.evidence > 0]
