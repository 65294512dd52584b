"""A fitted model of the recordings with what speaks for it and against it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.form_test import Contest, Remainder, contest
from fsm_calib.diagnosis.proof.gates import Adequacy, adequacy
from fsm_calib.diagnosis.shapes.locate import Location
from fsm_calib.diagnosis.shapes.score_tests import LeftOver
from fsm_calib.diagnosis.verdict.posterior import Belief
from fsm_calib.diagnosis.verdict.support import Support


@dataclass(frozen=True, eq=False)
class Model:
    """A base robot with any number of effects, whether they can be named or not.

    effects : strongest first; fit : of all; adequacy, tests : what is left; contest : un-named forms beside it;
    supports, beliefs : of the effects, in their order.
    """

    effects: tuple[Ranked, ...]
    fit: Fit
    adequacy: Adequacy
    tests: tuple[LeftOver, ...]
    contest: Contest
    supports: tuple[Support, ...] = ()
    beliefs: tuple[Belief, ...] = ()

    def named(self, least: float) -> tuple[Belief, ...]:
        """Return the beliefs in names that are at least so probable."""
        return tuple(b for b in self.beliefs if b.probability >= least)

    def taking(self, found: Ranked) -> Model:
        """Return the model with one of its effects in the closure that was found, and with the fit of that."""
        taken = {
            e.name: replace(e, fit=found.fit, hypothesis=found.hypothesis) if e.name == found.name else e
            for e in self.effects
        }
        beliefs = tuple(replace(b, effect=taken[b.name]) for b in self.beliefs)
        return replace(self, effects=tuple(taken.values()), fit=found.fit, beliefs=beliefs)


def bare_model(engine: Engine, base: Fit, location: Location) -> Model:
    """Return the base robot alone as a model, with what it leaves and how forms do beside it."""
    against = contest(Remainder.of(engine, base), base, [])
    return Model((), base, adequacy(location.tests, 0.0), tuple(location.tests), against)
