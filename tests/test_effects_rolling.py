"""Tyres that roll hard, one more than the other, are one phenomenon: no dead zone of one motor mends the rest."""

import pytest
from diagnosis_robots import fitted_number, judged

RIVALS = ("coulomb_friction", "motor_deadband", "caster_drag", "motor_gain_curve")


def test_a_wheel_that_rolls_harder_is_told_with_both_sizes():
    decision = judged(RIVALS, coulomb_friction__rolling=0.2, coulomb_friction__rolling_difference=0.08)
    assert [belief.name for belief in decision.named] == ["coulomb_friction"]
    number = {
        name: fitted_number(decision.model.fit, f"coulomb_friction.{name}")
        for name in ("rolling", "rolling_difference", "friction", "difference")
    }
    closure = decision.model.effects[0].hypothesis.closure
    assert closure in ("each rolls its own", "each its own")  # without play in the gears both say the same
    more = number["rolling_difference"] or number["difference"] / 0.0318
    assert more == pytest.approx(0.08, rel=0.15)
