"""Drivers that know few steps: how they round, and how many they know, which no derivative tells."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, judged, recording

from fsm_calib.diagnosis.candidates.hypotheses import hypotheses_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.searched import likeliest_values
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.pwm_steps import EFFECT, floor_to_step
from fsm_calib.world2d.parameters import parameter_table

RIVALS = ("pwm_steps", "motor_deadband", "motor_gain_curve", "coulomb_friction")
COMMANDS = np.linspace(-1.0, 1.0, 401)


def rounded(levels, nearest):
    return [floor_to_step(np.array([1.0, levels, nearest]), 0, u, 0) for u in COMMANDS]


def test_a_cast_to_an_integer_rounds_towards_zero():
    assert rounded(19.0, 0.0) == pytest.approx(np.trunc(19.0 * COMMANDS + 1e-9 * np.sign(COMMANDS)) / 19.0)


def test_a_timer_rounds_to_the_nearest_count():
    found = np.array(rounded(19.0, 1.0))
    assert np.abs(found - COMMANDS).max() <= 0.5 / 19.0 + 1e-9
    assert found == pytest.approx(-found[::-1])
    assert 19.0 * found == pytest.approx(np.round(19.0 * found))


def numbers_of(decision):
    table = parameter_table()
    values = decision.model.fit.values[0]
    return {p.name: float(values[table.place(f"pwm_steps.{p.name}")]) for p in EFFECT.parameters}


@pytest.mark.parametrize(("levels", "nearest"), [(23.4, 0.0), (15.0, 1.0)])
def test_few_steps_are_found_by_their_number_and_how_they_round(levels, nearest):
    numbers = {"share": 1.0, "levels": levels, "nearest": nearest}
    decision = judged(RIVALS, **{f"pwm_steps__{name}": value for name, value in numbers.items()})
    assert [belief.name for belief in decision.named] == ["pwm_steps"]
    assert numbers_of(decision) == pytest.approx(numbers, rel=0.03)


def test_where_no_driver_rounds_no_number_of_steps_has_evidence():
    engine = engine_of(*(recording(seed) for seed in (0, 1)))
    bank = Bank.on(engine, fit_base(engine))
    assert bank.best_of(registry()["pwm_steps"]).evidence < 14.0


def test_a_number_that_a_closure_holds_is_not_searched():
    engine = engine_of(recording())
    bank = Bank.on(engine, fit_base(engine))
    searched = {form.closure: likeliest_values(bank.prober, form) for form in hypotheses_of(EFFECT, 1)}
    assert searched["full"] == {}
    assert 4.0 <= searched["few steps"]["pwm_steps.levels"] <= 255.0


def test_a_usual_number_of_many_steps_is_found_to_the_step():
    engine = engine_of(
        *(recording(seed, noise=0.2, pwm_steps__share=1.0, pwm_steps__levels=100.0) for seed in (0, 1))
    )
    bank = Bank.on(engine, fit_base(engine))
    [form] = [form for form in hypotheses_of(EFFECT, 2) if form.closure == "few steps"]
    assert likeliest_values(bank.prober, form)["pwm_steps.levels"] == 100.0
