"""Was the battery as full in the second drive as in the first? Motors are as fast as their voltage is high.

Nobody logs it, every battery does it: cells of 8.4 V when full have 6.6 V when empty, and a drive of half a minute
begins somewhere between. One gain for all drives then leaves each of them off by per cents, and what changes with time
(a voltage that sags, motors that warm up) takes the blame: a clean robot whose second drive was 3 % slower was said to
have both, 0.9 sure. So every drive but the first has a factor of its own on both motors where that has strong evidence,
and keeps it beside the effect that explains more: of drives at other speeds each, a dead zone makes one robot faster
than another, and does the whole job.
"""

from __future__ import annotations

from fsm_calib.diagnosis.candidates.free_number import SURE, found_free, unless_stood_in, with_free
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS

NAME = "charge"
TOLD = 0.01  # share of the speed from which on a drive's charge is told


def with_charges(engine: Engine, base: Fit, rivals: Rivals) -> Fit:
    """Return the base with a charge for every drive but the first, where these have strong evidence.

    rivals : effects that are asked whether one does as well.
    """
    slots = [slot_of(NAME, run) for run in range(1, len(engine.simulators))]
    if not slots:
        return base
    return unless_stood_in(engine, base, lambda fit: with_free(engine, fit, slots, (1.0,)), rivals)


def charges_told(fit: Fit) -> list[str]:
    """Return a sentence for every drive whose motors were clearly faster or slower than in the first."""
    said = []
    for slot, value, sd in found_free(fit, NAME):
        if slot.run == ALL_RUNS or abs(value - 1.0) < max(TOLD, SURE * sd):
            continue
        kind = "slower" if value < 1.0 else "faster"
        said.append(
            f"in recording {slot.run + 1} both motors were {100.0 * abs(value - 1.0):.1f} +- {100.0 * sd:.1f} % {kind} "
            "than in the first: another charge of the battery, most likely"
        )
    return said
