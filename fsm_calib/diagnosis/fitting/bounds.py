"""Which numbers of the base robot a fit has pushed against their bounds, and what that means."""

from __future__ import annotations

from fsm_calib.diagnosis.fitting.base import LONGEST_TRAIL
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.world2d.parameters import parameter_table

NEAR = 1e-3  # of the range between the bounds


def at_bounds(fit: Fit) -> list[str]:
    """Return a sentence for every number of the base robot that stands at one of its bounds."""
    table, said = parameter_table(), []
    for slot, value, _ in fit.numbers():
        margin = NEAR * (slot.high - slot.low)
        if table.owner[slot.place] or slot.low + margin < value < slot.high - margin or _trail(slot):
            continue
        entry = table.entries[slot.place]
        bound = "lowest" if value <= slot.low + margin else "highest"
        stated = f" (stated: {slot.centre:g} +- {slot.spread:.2g})" if slot.spread else ""
        said.append(
            f"{table.names[slot.place]} stands at its {bound} value, {value:.4g} {entry.unit}{stated}: "
            "the recordings ask for more; is what the manifest states right, and its units?"
        )
    return said


def _trail(slot: Slot) -> bool:
    """Return whether this is how turning trails measured wheels: a few ms that no manifest states."""
    return parameter_table().names[slot.place] == "tau_turn" and slot.high == LONGEST_TRAIL
