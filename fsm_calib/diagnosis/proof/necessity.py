"""Two effects or one? Each effect of a pair must be missed when it is taken out again.

A fit of one effect may rest at a local optimum that a second effect, however small, helps it out of. So each effect
of a pair is fitted alone once more from where the pair ended: backward elimination (Efroymson 1960; Miller, Subset
Selection in Regression, 2nd ed. 2002, section 3.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.ranking import Ranked, evidence_of, polished
from fsm_calib.diagnosis.fitting.base import noise_names
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.world2d.parameters import parameter_table


def alone(engine: Engine, kept: Ranked, pair: Fit, dropped: str, base: Fit) -> Ranked:
    """Return the effect `kept` fitted without the effect `dropped`, from where the `pair` ended."""
    table = parameter_table()
    slots = [s for s in pair.slots if table.owner[s.place] != dropped]
    fit = engine.fit(switched_off(pair.values, [dropped]), slots, pair.noise)
    ranked = polished(engine, replace(kept, fit=fit), base, noise_names(engine.simulators))
    return replace(ranked, evidence=evidence_of(ranked.fit, base, engine.count))


def survivor(engine: Engine, pair: Sequence[Ranked], fit: Fit, base: Fit, wanted: float) -> Ranked | None:
    """Return the one effect of a pair that does without the other, None where both are needed.

    wanted : evidence by which the pair must beat the better of the two alone.
    """
    first, second = pair
    tried = [alone(engine, first, fit, second.name, base), alone(engine, second, fit, first.name, base)]
    best = max(tried, key=lambda ranked: ranked.evidence)
    won = evidence_of(fit, base, engine.count) - best.evidence
    return best if np.isfinite(best.evidence) and won < wanted else None
