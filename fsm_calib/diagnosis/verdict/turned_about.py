"""Is an effect of an angle a law of that angle? Turned about, by half a turn of its phase, it must do harm.

    x(phi) = A cos(n phi + phase)  ->  A cos(n phi + phase + pi) = -x(phi)

What is there with the amplitude A leaves A^2 without it and (2 A)^2 with its opposite. Where teeth float in the gap of
a gear, anything that shakes the wheels lets them float as the unknown forces of the floor do: two of three own robots
with play were told an oval wheel, 73 and 123 units of evidence, which any phase and either wheel gave.
"""

from __future__ import annotations

import math

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.gap import Gap, gap_between
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


def turned_about(engine: Engine, less: Fit, whole: Fit, effect: str) -> Gap | None:
    """Return what the model with an effect turned about lacks against that without it; None for one without a phase.

    less : the fit without the effect; whole : with it, whose numbers of the effect stay while all others are fitted.
    """
    table = parameter_table()
    phases = [table.place(f"{effect}.{p.name}") for p in registry()[effect].parameters if p.cyclic]
    if not phases:
        return None
    values = whole.values.copy()
    values[:, phases] += math.pi
    others = [slot for slot in whole.slots if table.owner[slot.place] != effect]
    return gap_between(engine, less, engine.fit(values, others, whole.noise))
