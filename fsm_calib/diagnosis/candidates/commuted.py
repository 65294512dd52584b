"""The other order of two lags: a filter's time constant and the motors' own change places.

First-order lags in series commute: set points that pass a filter of 0.25 s before motors of 0.06 s look as they would
the other way round. Where each side has a filter of its own only one order is true, since the motors' time constants
are of the robot (`tau_forward`, `tau_turn`) and of both sides alike; a fit that took the filter for the motors stands
on a hill of its own, with no gradient towards the other. There, with T the mean of the motors' and F of the filters'
time constants [s],

    filter'_i = filter_i T / F,     motors'_j = motors_j F / T

(Two filters of 0.21 and 0.29 s: 1,174 units where the motors had 0.23 s, 1,254 with 0.064 s.)
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import with_slots
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

OF_THE_MOTORS = ("tau_forward", "tau_turn")


def commuted(fit: Fit, effect: str) -> FloatArray | None:
    """Return a fit's parameters (R, p) with an effect's lags and the motors' in each other's places; None where it has
    none, or nothing would change.
    """
    table, here = parameter_table(), fit.slot_values()
    low, high = fit.slot_bounds()
    places = [slot.place for slot in fit.slots]
    filters = np.array([table.owner[p] == effect and table.entries[p].in_series for p in places])
    motors = np.array([table.names[p] in OF_THE_MOTORS for p in places])
    if not filters.any() or not motors.any() or not here[filters].mean() > 0.0:
        return None
    longer = here[motors].mean() / here[filters].mean()
    there = here.copy()
    there[filters] *= longer
    there[motors] /= longer
    return with_slots(fit.values, fit.slots, np.clip(there, low, high))
