"""A rival in the place of one effect of a model: from which grounds it is fitted.

Without the effect the others bend to stand in for it, and a rival that is its equal (a late command, a late pose) may
not find its way back from there. So it is fitted from where the model has the others beside the effect, too, and from
the base robot as the rival had it alone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import slot_numbers, with_slots
from fsm_calib.diagnosis.fitting.values import switched_off, taken_over
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table


class Fitting(Protocol):
    """What fits the models of one robot."""

    @property
    def engine(self) -> Engine:
        """Of its recordings."""
        ...

    def without(self, fit: Fit, name: str) -> Fit:
        """Return the fit without one of its effects, everything else and the noise fitted again."""
        ...

    def with_noise(self, fit: Fit) -> Fit:
        """Return a fit with its noise fitted again, and itself at that noise."""
        ...


def among_the_others(whole: Fit, name: str, rival: Ranked) -> FloatArray:
    """Return the parameters (R, p) of a model with a rival as it was fitted in the place of its effect `name`."""
    return taken_over(switched_off(whole.values, [name]), rival.name, rival.fit.values)


def in_the_others_company(fitting: Fitting, rival: Ranked, whole: Fit, name: str) -> Ranked:
    """Return a rival of the effect `name`, fitted from where the whole model has the others, if better."""
    values = among_the_others(whole, name, rival)
    moved = fitting.with_noise(fitting.engine.fit(values, rival.fit.slots, whole.noise))
    if moved.score <= rival.fit.score:
        return rival
    won = moved.score - rival.fit.score
    return replace(rival, fit=moved, evidence=rival.evidence + 2.0 * won, gain=rival.gain + won)


def on_its_own_ground(bank: Bank, rival: Ranked, whole: Fit, name: str) -> Ranked:
    """Return a rival on top of the bank's parent, fitted from the base robot as the rival has it.

    whole : the model with the effect `name`, in whose place the rival is asked; its other effects start as they are in
    it.
    """
    owner = parameter_table().owner
    ground = [slot for slot in bank.parent.slots if not owner[slot.place]]
    values = with_slots(among_the_others(whole, name, rival), ground, slot_numbers(rival.fit.values, ground))
    return bank.fit(rival.hypothesis, Start(values, 0.0))
