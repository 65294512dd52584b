"""A fitted hypothesis, and what it has more than its parent."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

EXACT = 0.01  # of what it explains: no equation is more exact
STRONG = 6.0  # evidence: "strong" (Kass & Raftery, J. Am. Stat. Assoc. 90 (1995) 773)


@dataclass(frozen=True, eq=False)
class Ranked:
    """One fitted hypothesis: evidence = 2 (log L - log L of its parent) - k ln N (Schwarz, Ann. Stat. 6 (1978) 461)."""

    hypothesis: Hypothesis
    fit: Fit
    evidence: float
    gain: float

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.hypothesis.effect


def evidence_of(fit: Fit, parent: Fit, count: int) -> float:
    """Return twice the gained log-likelihood minus the cost of the additional numbers."""
    extra = fit.size - parent.size
    return 2.0 * (fit.score - parent.score) - extra * float(np.log(count))


def simplest(forms: Sequence[Ranked]) -> Ranked:
    """Return the form of an effect with the fewest numbers of those that no other has strong evidence over.

    What such a form lacks a later effect may explain: a real Duckiebot's caster that swivels (four numbers, 2 units of
    evidence more) hid from a delay of 0.056 s what one that drags (one number) leaves it, 88 units.
    """
    most = max(ranked.evidence for ranked in forms)
    near = [ranked for ranked in forms if ranked.evidence > most - STRONG]
    return min(near, key=lambda ranked: (ranked.fit.size, -ranked.evidence))


def strongest(tried: Iterable[Ranked]) -> Ranked | None:
    """Return the one with the most evidence; None where there is none."""
    return max(tried, key=lambda ranked: ranked.evidence, default=None)


def parameters_of(ranked: Ranked) -> dict[str, FloatArray]:
    """Return the fitted numbers of the effect by parameter name, one a recording, shape (R,)."""
    table = parameter_table()
    effect = registry()[ranked.name]
    return {p.name: ranked.fit.values[:, table.place(f"{ranked.name}.{p.name}")] for p in effect.parameters}
