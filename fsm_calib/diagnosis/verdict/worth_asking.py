"""Which effects of the catalogue could what a model leaves be? Only these are fitted on top of it.

Places and moments are sought again only where the score tests of places or of time find something, where they had
evidence of their own before, or, moments, where one stands out from all others.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import has_phase, is_event
from fsm_calib.diagnosis.candidates.outstanding import RARE
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.proof.form_test import Remainder
from fsm_calib.diagnosis.shapes.features import feature_groups
from fsm_calib.diagnosis.shapes.score_tests import surprising, tested
from fsm_calib.world2d.effects import Effect

PLACES = {"place", "place and heading"}
TIMES = {"time", "moment", "wear and warmth"}
"""Regimes of the score tests that ask for a place, and for a moment or a span."""


def worth_asking(
    bank: Bank, effects: Sequence[Effect], hinted: Collection[str], *, needed: float
) -> list[Effect]:
    """Return those of some effects, none of them in the bank's parent, that what it leaves could be.

    hinted : names that had evidence before; needed : as in `Selector`.

    Where nothing is left, neither to tests nor to forms, those are only what both are blind to. Events that had
    something to say before or that stand out among all moments: a push of a quarter of a second is one pose in a
    hundred to the test of a regime. Where the world's physics is another than ours, a moment that stands out may be
    none (`Support.alone`). A marker that had something to say before: where its edge is crossed the poses jump, in a
    few frames of a drive. And what swings with the turns of a wheel, whose phase no regime and no form has: 53
    units of a wheel out of round were left beside a limit of the command.
    """
    tests = tested(bank.scanner.residual, feature_groups(bank.scanner.situations))
    left = surprising(tests)
    regimes = {t.group.regime for t in left}
    hinted = {*hinted, *standing_out(bank, [e for e in effects if e.name not in hinted], needed)}
    if not left and Remainder.of(bank.engine, bank.parent).beside <= 0.0:
        return [e for e in effects if has_phase(e) or ((is_event(e) or e.jumps) and e.name in hinted)]
    return [
        e
        for e in effects
        if (e.where == "anywhere" or regimes & PLACES or e.name in hinted)
        and (e.when == "always" or regimes & TIMES or e.name in hinted)
    ]


def standing_out(bank: Bank, effects: Sequence[Effect], needed: float) -> set[str]:
    """Return the effects of a moment of which one promises clearly more than all others do on top of the parent."""
    price = float(np.log(bank.engine.count))
    found = set()
    for effect in (e for e in effects if e.when == "moment"):
        for moment in bank.scanner.candidates(effect):
            evidence = 2.0 * moment.promise - price * moment.size
            if evidence >= needed and moment.chance <= RARE:
                found.add(effect.name)
    return found
