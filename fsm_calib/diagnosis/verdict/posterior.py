"""How sure is a name? Its posterior probability among its rivals, nothing at all, and what has no name."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.ranking import Ranked
from fsm_calib.diagnosis.proof.gates import Gates, indistinguishable
from fsm_calib.diagnosis.verdict.model import Model

TEMPER = 3.0  # evidence gaps are divided by it: inexact equations make likelihoods over-confident (development seeds)
FORM_TEMPER = 2.0  # the same for forms without a name
GENERAL_DOUBT = 0.02  # share of names that were wrong on the development seeds for no visible reason
LARGEST_LOG_ODDS = 30.0


def confidence(name: str, evidence: float, pool: Sequence[Ranked], model: Model, gates: Gates) -> float:
    """Return the probability that a name is right.

    Tempered posterior over the rivals in `pool`, nothing at all, and un-named forms (`contest.py`; even odds at
    their gates), less what left-over structure says about the equation. evidence : of the name, should it not be in
    the pool.
    """
    top = max([r.evidence for r in pool if r.name == name], default=evidence)
    others = [0.5 * (r.evidence - top) / TEMPER for r in pool if r.name != name]
    none = -0.5 * top / TEMPER
    odds = sum(math.exp(min(x, LARGEST_LOG_ODDS)) for x in [*others, none, *_unnamed(model, gates)])
    left = model.adequacy
    doubt = GENERAL_DOUBT + 0.3 * min(left.share, 1.0) * (left.surprise > 4.0)
    return max(0.01, (1.0 - doubt) / (1.0 + odds))


def joint_confidence(names: Sequence[str], pool: Sequence[Ranked], model: Model, gates: Gates) -> float:
    """Return the probability that one of `names`, which the data cannot tell apart, is right."""
    return sum(confidence(name, 0.0, pool, model, gates) for name in names)


def sureness(model: Model, ranking: Sequence[Ranked], gates: Gates) -> float:
    """Return the probability that what a model says is right: of a name, that of its set in the ranking.

    A pair has no rivals in a ranking of single effects; forms without a name and nothing at all stand against it.
    """
    if len(model.effects) > 1:
        first = model.effects[0]
        return confidence(first.name, first.evidence, (), model, gates)
    return joint_confidence(indistinguishable(ranking, gates), ranking, model, gates)


def _unnamed(model: Model, gates: Gates) -> list[float]:
    """Return log odds of un-named forms, instead of the name and beside it; none where the name rules in spite."""
    against = model.contest
    if against is None or model.rules(gates) or not model.sound(gates):
        return []
    margins = (against.surplus(gates), against.beside - against.allowed(gates))
    return [0.5 * margin / FORM_TEMPER for margin in margins]
