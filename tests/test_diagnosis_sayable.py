"""A name is said only where the effect is still what it says in the whole model."""

from types import SimpleNamespace

import pytest

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.verdict.decide import sayable
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import Belief
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameters

SUPPLY = registry()["command_saturation"].closure("end of supply")


def fit_with(end):
    """Return a fit in which the motors' supply ends at a share of full command."""
    values = parameters({"command_saturation.voltage": end, "command_saturation.loop": 2.0})[None]
    return SimpleNamespace(values=values, slots=())


def model_of(joined, now, probability=0.9):
    """Return a model whose supply ended at one share as it joined, and ends at another in the whole fit."""
    form = Hypothesis("command_saturation", SUPPLY.frees, closure=SUPPLY.name)
    ranked = Ranked(form, fit_with(joined), 400.0, 200.0)
    belief = Belief(ranked, probability, ("command_saturation",))
    return Model((ranked,), fit_with(now), None, (), None, (), (belief,))


@pytest.mark.parametrize(("now", "said"), [(0.8, ["command_saturation"]), (1.02, []), (1.2, [])])
def test_a_supply_that_ends_above_full_command_in_the_whole_model_is_no_finding(now, said):
    assert [belief.name for belief in sayable(model_of(0.8, now), 0.6, ())] == said


def test_what_is_not_sure_is_not_said():
    assert sayable(model_of(0.8, 0.8, probability=0.5), 0.6, ()) == ()
