r"""How evidence becomes odds of explanations: one law for what a drive promises and for what is believed after it.

    log odds of k names against nothing = log prior + c(E, k)
    c(E, k) = (E - r) / 2 for E below r, (E - r) / (2 TEMPER) above, + r / 2         r = k DETECT

E [1] : evidence over the base robot, 2 (log L - log L_base) less the price of the numbers. What noise alone makes of
it is known, so that it counts in full as far as detection asks for it; beyond, it comes from structure that inexact
equations share, and counts by a third. Before anything was driven nothing is missing with even odds, and every effect
of the catalogue is as likely as any other.
"""

from __future__ import annotations

import math

import numpy as np

from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.types import FloatArray

DETECT = DEFAULT_GATES.detect
TEMPER = 3.0  # structure is over-confident by so much, where equations are inexact (verdict/posterior.py)


def room_of(evidence: float, names: int) -> float:
    """Return the evidence that an explanation of so many names may still win in full; negative beyond that."""
    return names * DETECT - evidence


def counted(won: FloatArray | float, room: FloatArray | float) -> FloatArray:
    """Return by how much log odds grow with evidence `won`, of which `room` counts in full; shapes broadcast."""
    return _beyond(np.asarray(won) - room) - _beyond(-np.asarray(room))


def log_odds(evidence: float, names: int, catalogue: int) -> float:
    """Return the log odds against nothing of an explanation with so many of `catalogue` names and so much evidence."""
    return float(counted(evidence, names * DETECT)) - names * math.log(max(catalogue, 1))


def _beyond(excess: FloatArray) -> FloatArray:
    """Return half of the evidence beyond what counts in full, a third of it where it is positive."""
    return np.asarray(0.5 * (np.minimum(excess, 0.0) + np.maximum(excess, 0.0) / TEMPER))
