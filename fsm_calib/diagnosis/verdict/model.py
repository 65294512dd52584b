"""A fitted model of the recordings with what speaks for it and against it."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranking import Ranked
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.proof.form_test import Contest
from fsm_calib.diagnosis.proof.gates import Adequacy, Gates
from fsm_calib.diagnosis.shapes.score_tests import LeftOver


@dataclass(frozen=True, eq=False)
class Model:
    """A base robot with zero, one or two effects.

    effects, fit; adequacy : what is left; gains : what it wins on other recordings; tests : of all feature groups;
    contest : how un-named forms do against the effects, None without effects; error_left : share of the base's error
    over the horizon.
    """

    effects: tuple[Ranked, ...]
    fit: Fit
    adequacy: Adequacy
    gains: tuple[float, ...]
    tests: tuple[LeftOver, ...]
    contest: Contest | None = None
    error_left: float = 1.0

    def sound(self, gates: Gates) -> bool:
        """Return whether no form without a name does better than the effects."""
        against = self.contest
        return against is None or not (against.replaceable(gates) or against.misshapen(gates))

    def rules(self, gates: Gates) -> bool:
        """Return whether the effects leave so little of the error that forms have no say."""
        return self.error_left < gates.ruling

    def complaint(self, gates: Gates) -> str:
        """Return in words which form without a name does better."""
        return self.contest.reason(gates, " and ".join(e.name for e in self.effects)) if self.contest else ""
