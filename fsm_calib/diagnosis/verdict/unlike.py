"""Are the motors unlike beside the first effect? What that effect does hides in the base what it leaves bare beside it.

Windings that heat hid that one motor's torque falls 7 % less with speed than the other's; a mass 10 mm beside the axle,
where 1 mm is true, stood for it as the second name.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranking import Bank, Ranked
from fsm_calib.diagnosis.candidates.stiffness import is_free, with_stiffness
from fsm_calib.diagnosis.verdict.selection import Selector


def ranked_if_unlike(
    selector: Selector, bank: Bank, ranking: list[Ranked]
) -> tuple[Selector, Bank, list[Ranked]]:
    """Return selector, bank and ranking on unlike motors where the first effect shows them; else as given."""
    measured = selector.engine.simulators[0].measured_input
    if measured or is_free(selector.base) or not ranking or ranking[0].evidence < selector.needed:
        return selector, bank, ranking
    leader = ranking[0]
    others = [effect for effect in selector.catalogue if effect.name != leader.name]
    freed = with_stiffness(selector.engine, leader.fit, others)
    if not is_free(freed):
        return selector, bank, ranking
    unlike = replace(selector, base=selector.without(freed, leader.name), distinct={})
    return unlike, *unlike.first_ranked()
