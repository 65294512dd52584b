"""What an effect adds to a fit, told by its own numbers and their covariance: no fit without it is needed."""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.world2d.parameters import parameter_table


def wald_evidence(fit: Fit, name: str) -> float:
    """Return what an effect seems to add by its strengths and their covariance (Wald): chi-square minus its cost."""
    table, null = parameter_table(), parameter_table().null
    own = [
        i for i, s in enumerate(fit.slots) if table.owner[s.place] == name and table.entries[s.place].strength
    ]
    offset = fit.slot_values()[own] - null[[fit.slots[i].place for i in own]]
    return float(offset @ np.linalg.pinv(fit.covariance[np.ix_(own, own)]) @ offset)
