"""A name is said only where the effect is still what it says in the whole model."""

from types import SimpleNamespace

import pytest

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.diagnosis.verdict.decide import sayable
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import Belief
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table, parameters

SUPPLY = registry()["command_saturation"].closure("end of supply")
LOOP = registry()["command_saturation"].parameter("loop")
SAID = ["command_saturation"]


def fit_with(end, loop):
    """Return a fit in which the motors' supply ends at a share of full command, behind a loop of some gain."""
    values = parameters({"command_saturation.voltage": end, "command_saturation.loop": loop})[None]
    place = parameter_table().place("command_saturation.loop")
    return SimpleNamespace(values=values, slots=(Slot(place, LOOP.low, LOOP.high, 0.01),))


def model_of(joined, now, probability=0.9, loop=2.0):
    """Return a model whose supply ended at one share as it joined, and ends at another in the whole fit."""
    form = Hypothesis("command_saturation", SUPPLY.frees, closure=SUPPLY.name)
    ranked = Ranked(form, fit_with(joined, loop), 400.0, 200.0)
    belief = Belief(ranked, probability, ("command_saturation",))
    return Model((ranked,), fit_with(now, loop), None, (), None, (), (belief,))


def said_of(model):
    return [belief.name for belief in sayable(model, 0.6, ())]


@pytest.mark.parametrize(("now", "said"), [(0.8, SAID), (1.02, SAID), (1.2, [])])
def test_a_supply_that_reaches_every_set_point_in_the_whole_model_is_no_finding(now, said):
    assert said_of(model_of(0.8, now)) == said


@pytest.mark.parametrize(("now", "said"), [(0.8, SAID), (1.02, [])])
def test_a_bridge_ends_at_full_command_and_that_is_no_finding_where_no_loop_asks_for_more(now, said):
    assert said_of(model_of(0.8, now, loop=LOOP.low)) == said


def test_what_is_not_sure_is_not_said():
    assert sayable(model_of(0.8, 0.8, probability=0.5), 0.6, ()) == ()
