"""Fits of a robot that strong friction holds back start from stronger motors than the base robot's, too."""

import numpy as np
import pytest
from diagnosis_robots import driven, engine_of, fitted_number, recording

from fsm_calib.diagnosis.candidates.held_back import MOST, motors_to_try, stronger
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

REST = (0.6, 0.0, 0.0)
TURNS = (
    *((1.6, 0.51, -0.51), REST, (1.8, 0.3, -0.3), REST, (1.6, -0.51, 0.51), REST),
    *((0.25, 0.51, 0.1), (0.25, 0.1, 0.51)) * 4,
    *(REST, (1.5, 0.25, 0.5), REST, (2.0, 0.0, 0.51), REST, (2.0, 0.3, 0.3), REST, (1.8, -0.3, 0.3), REST),
)


def turning(rng, **changes):
    """Return a recording of a `robot` with `changes` that hardly does anything but turn."""
    return driven(TURNS, rng, [0.001, 0.001, 0.003], **changes)


@pytest.fixture(scope="module")
def weak():
    """The base robot of one that scrubs so much that it hardly turns."""
    scrubbing = {"tyre_scrub__moment": 0.27, "gain_left": 0.72, "gain_right": 0.69, "tau_turn": 0.37}
    engine = engine_of(turning(np.random.default_rng(0), **scrubbing))
    return engine, fit_base(engine)


def test_a_strong_scrub_is_found_with_the_motors_that_it_holds(weak):
    engine, base = weak
    assert fitted_number(base, "gain_left") < 0.1
    best = Bank.on(engine, base).rank([registry()["tyre_scrub"]])[0]
    assert fitted_number(best.fit, "gain_left") == pytest.approx(0.72, rel=0.1)
    assert fitted_number(best.fit, "gain_right") == pytest.approx(0.69, rel=0.1)
    assert best.evidence > 500.0


def test_motors_are_tried_up_to_those_of_a_robot_that_is_as_fast_as_stated(weak):
    engine, base = weak
    now = 0.5 * (fitted_number(base, "gain_left") + fitted_number(base, "gain_right"))
    tried = motors_to_try(engine.simulators, base.values)
    assert tried[:2] == [2.0, 4.0]
    assert tried[-1] * now <= MOST * engine.simulators[0].full_speed < 2.0 * tried[-1] * now


def test_an_ordinary_robots_motors_are_not_doubted():
    engine = engine_of(recording())
    assert motors_to_try(engine.simulators, fit_base(engine).values) == []


def test_beside_an_effect_motors_may_be_weak(weak):
    engine, base = weak
    controlled = with_values(base.values, {"speed_controller.hold": 5.0})
    lifted = with_values(base.values, {"motor_deadband.offset": -0.8})
    assert motors_to_try(engine.simulators, controlled) == motors_to_try(engine.simulators, base.values)
    assert motors_to_try(engine.simulators, lifted) == []


def test_both_motors_and_the_strength_grow(weak):
    _, base = weak
    form = Hypothesis("tyre_scrub", ("moment",), closure="usual tread")
    tried = stronger(base.values, form, [{"tyre_scrub.moment": 0.01}], [4.0])
    gains = {fitted_number(base, f"gain_{side}") * 4.0 for side in ("left", "right")}
    place = parameter_table().place
    assert {float(v[0, place(f"gain_{side}")]) for v in tried for side in ("left", "right")} == gains
    sizes = [float(v[0, place("tyre_scrub.moment")]) for v in tried]
    assert sizes == pytest.approx([0.01, 0.02, 0.04, 0.08])
