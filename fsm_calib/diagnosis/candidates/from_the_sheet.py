"""Effects sought from the robot as its sheet states it, where the fit of the base robot is bent.

A base robot that lacks a strong effect bends, and an effect that is fitted from there may not find its way back.
Where its axle or its lags rest more than three spreads from what is stated or usual (an axle 20 % too wide, a turn that
lags by 0.9 s), every lasting effect is asked from there, too. (Two laps of a real Duckiebot: from a bent base a dead
zone had 17 units of evidence, a caster none, a load 3, scrubbing tyres 372; from the sheet 779, 775, 757, 776. Laps
tell none from the others; each had been said with 0.9 by what its rivals missed.) The tyres' numbers are no sign:
their creep differs by five spreads from engine to engine, their grip gives way to a delay, and of five robots of other
engines with such a base the strongest effects were found from the base itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.asked import Distinct
from fsm_calib.diagnosis.candidates.from_the_leader import ended_on, with_better
from fsm_calib.diagnosis.candidates.ranked import STRONG, Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot, with_slots
from fsm_calib.diagnosis.replay.simulator import nominal_values
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.parameters import parameter_table

BENT = 3.0  # spreads from where a number is expected
TYRES = ("slip_speed", "slip_ratio", "friction")
GAINS = ("gain_left", "gain_right")


def is_bent(base: Fit) -> bool:
    """Return whether a number of the base robot, its tyres' aside, is far from what is stated or usual."""
    tyres = [parameter_table().place(name) for name in TYRES]
    return any(
        abs(value - slot.centre) > BENT * slot.spread
        for slot, value, _ in base.numbers()
        if slot.spread > 0.0 and slot.place not in tyres
    )


def sought_from_the_sheet(
    engine: Engine, base: Fit, ranking: Sequence[Ranked], effects: Sequence[Effect], distinct: Distinct
) -> list[Ranked]:
    """Return a ranking on top of a bent base, sorted again, with the lasting effects where they do clearly better.

    effects : the catalogue that may be asked; distinct : what is known of their starts.
    """
    bank = Bank.on(engine, _straight(engine, base), distinct=distinct)
    found = bank.rank([effect for effect in effects if not effect.scan])
    better = [ranked for ranked in found if evidence_of(ranked.fit, base, engine.count) > 0.0]
    return with_better(engine, ranking, ended_on(bank, base, better), STRONG)


def _straight(engine: Engine, base: Fit) -> Fit:
    """Return the base robot with its numbers as expected, its motors alike, and the noise that it has so."""
    values = with_slots(base.values, base.slots, _expected(engine, base))
    fit = engine.refit_noise(engine.fit(values, base.slots, base.noise, steps=0), SPEED_NOISE, 3)
    return engine.fit(fit.values, fit.slots, fit.noise, steps=0)


def _expected(engine: Engine, base: Fit) -> FloatArray:
    """Return where the numbers of the base are expected (m,): a prior's centre, the mean gain, or as stated."""
    table, stated = parameter_table(), nominal_values(engine.simulators)
    places = [table.place(name) for name in GAINS]
    mean = float(base.values[:, places].mean())
    return np.array([mean if slot.place in places else _usual(slot, stated) for slot in base.slots])


def _usual(slot: Slot, stated: FloatArray) -> float:
    return slot.centre if slot.spread > 0.0 else float(stated[slot.place])
