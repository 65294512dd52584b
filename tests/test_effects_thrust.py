"""Gears that press on a washer one way: more dry friction of a motor that turns backwards, or a share of its torque;
and a transistor that has burnt: more resistance of the circuit one way.
"""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged

GAIN, LAG, RUB = 0.6, 0.15, 0.4
GRID = np.arange(0.0, 4.0, 0.005)
RIVALS = ("motor_reverse_asymmetry", "coulomb_friction", "motor_asymmetric_lag", "motor_gain_curve")
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=LAG)


def of_both(name, size):
    return {f"motor_reverse_asymmetry__{name}_{side}": size for side in ("left", "right")}


def time_constant(direction, **changes):
    """Return the time [s] in which 63 % of a speed are reached from rest."""
    speed = direction * speeds([0.0], [direction * 0.5], GRID, **changes)
    return float(np.interp((1.0 - np.exp(-1.0)) * speed[-1], speed, GRID))


def test_gears_that_rub_backwards_speed_up_later_that_way_alone():
    plain, rubbing = {}, of_both("rub", RUB)
    assert time_constant(1.0, **rubbing) == pytest.approx(time_constant(1.0, **plain), rel=1e-6)
    assert time_constant(-1.0, **rubbing) == pytest.approx(
        time_constant(-1.0, **plain) / (1.0 - RUB), rel=0.1
    )


def test_gears_that_rub_pass_nothing_at_a_steady_speed_and_lose_nothing():
    plain, rubbing = (speeds([0.0], [-0.5], GRID, **c)[-1] for c in ({}, of_both("rub", RUB)))
    assert rubbing == pytest.approx(plain, rel=5e-3)


def test_stiff_gears_take_backwards_what_dry_friction_takes_both_ways():
    stiff, dry = of_both("stiff", 0.004), {"coulomb_friction__friction": 0.004}
    ahead, back, plain = ([0.0], [0.5], GRID), ([0.0], [-0.5], GRID), {}
    assert speeds(*back, **stiff)[-1] == pytest.approx(speeds(*back, **dry)[-1], rel=1e-3)
    assert speeds(*ahead, **stiff)[-1] == pytest.approx(speeds(*ahead, **plain)[-1], rel=1e-6)
    assert abs(speeds(*back, **stiff)[-1]) < 0.97 * abs(speeds(*back, **plain)[-1])


def test_more_resistance_one_way_speeds_up_later_that_way_and_brakes_as_ever():
    plain, burnt = {}, of_both("ohm", 1.0)
    assert time_constant(1.0, **burnt) == pytest.approx(time_constant(1.0, **plain), rel=1e-6)
    assert time_constant(-1.0, **burnt) == pytest.approx(2.0 * time_constant(-1.0, **plain), rel=0.1)
    driven = ([0.0, 2.0], [-0.5, 0.0], GRID)
    braked = [speeds(*driven, **changes)[GRID >= 2.0] for changes in (plain, burnt)]
    assert braked[1] == pytest.approx(braked[0], abs=1e-3)


@pytest.mark.parametrize(
    ("name", "size", "closure"),
    [("rub", RUB, "rubbing gears"), ("stiff", 0.008, "stiff gears"), ("ohm", 1.0, "more resistance")],
)
def test_they_are_named_with_both_sizes(name, size, closure):
    decision = judged(RIVALS, **of_both(name, size))
    assert [belief.name for belief in decision.named] == ["motor_reverse_asymmetry"]
    assert decision.model.effects[0].hypothesis.closure == closure
    for side in ("left", "right"):
        found = fitted_number(decision.model.fit, f"motor_reverse_asymmetry.{name}_{side}")
        assert found == pytest.approx(size, rel=0.2)
