"""The point of a model as a point of a larger one that explains nothing more."""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import Slot


def nothing_found(parent: Fit, slots: tuple[Slot, ...]) -> Fit:
    """Return a fit at its parent's point; slots : the parent's and those that found nothing to explain."""
    extra = len(slots) - len(parent.slots)
    nothing = tuple(np.zeros((*c.shape[:2], extra)) for c in parent.columns)
    covariance = np.zeros((len(slots), len(slots)))
    covariance[: len(parent.slots), : len(parent.slots)] = parent.covariance
    return Fit(
        parent.values, slots, parent.noise, parent.log_likelihood, parent.log_prior, covariance,
        parent.simulated, (parent.columns, nothing),
    )  # fmt: skip
