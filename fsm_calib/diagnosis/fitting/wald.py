"""How clearly numbers of a fit leave those that change nothing, by their covariance: no fit without them is needed.

    chi2 = d' C^-1 d          d: numbers less their null values, C: their covariance

Source: A. Wald, Transactions of the American Mathematical Society 54 (1943) 426.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.world2d.parameters import parameter_table


def wald(fit: Fit, slots: Collection[Slot]) -> float:
    """Return chi-square [1] of some numbers of a fit against changing nothing, all of them together."""
    null, chosen = parameter_table().null, set(slots)
    rows = [row for row, slot in enumerate(fit.slots) if slot in chosen]
    offset = fit.slot_values()[rows] - null[[fit.slots[row].place for row in rows]]
    return float(offset @ np.linalg.pinv(fit.covariance[np.ix_(rows, rows)]) @ offset)


def strengths_of(fit: Fit, effect: str) -> list[Slot]:
    """Return the numbers of an effect that say how strong it is, as far as a fit frees them."""
    table = parameter_table()
    return [s for s in fit.slots if table.owner[s.place] == effect and table.entries[s.place].strength]
