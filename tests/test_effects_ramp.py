"""Drivers that follow late: limits of acceleration and deceleration, and filters of what they are told."""

import numpy as np
import pytest
from diagnosis_robots import GAIN_LEFT, judged, speeds

from fsm_calib.world2d.effects.motor_asymmetric_lag import ramped
from fsm_calib.world2d.parameters import parameter_table


def by_small_steps(before, wanted, up, down, step, pieces=20_000):
    """Return mean and last output of a limited driver by many small steps, each with the slope that holds there."""
    value, total, dt = before, 0.0, step / pieces
    for _ in range(pieces):
        shrinks = value * wanted < 0.0 or abs(wanted) < abs(value)
        ramp = down if shrinks else up
        most = np.inf if ramp == 0.0 else dt / ramp
        after = value + np.clip(wanted - value, -most, most)
        if value * after < 0.0 and up != down:
            after = 0.0  # from here on it grows
        total += 0.5 * (value + after) * dt
        value = after
    return total / step, value


@pytest.mark.parametrize(("up", "down"), [(0.8, 0.0), (0.0, 0.8), (0.8, 0.8), (1.5, 0.3)])
@pytest.mark.parametrize(
    ("before", "wanted"), [(0.0, 0.3), (0.3, 0.1), (0.02, -0.3), (-0.3, 0.05), (0.2, 0.2)]
)
def test_a_step_of_a_limited_driver_is_that_of_many_small_ones(before, wanted, up, down):
    for step in (0.01, 0.1, 0.6):
        assert ramped(before, wanted, up, down, step) == pytest.approx(
            by_small_steps(before, wanted, up, down, step), abs=2e-4
        )


def test_a_limit_delays_a_start_by_its_time_for_each_metre_a_second():
    mean, after = ramped(0.0, 0.4, 0.5, 0.0, 0.5)
    assert after == 0.4
    assert mean * 0.5 == pytest.approx(0.4 * (0.5 - 0.5 * 0.5 * 0.4))  # half of the ramp's 0.2 s are lost


def test_a_controller_of_speed_follows_a_limited_set_point():
    controller = {"speed_controller__hold": 6.0, "speed_controller__weight": 0.3}
    ramp, grid, fine = 0.9, np.arange(0.0, 2.5, 0.1), 0.002
    steps = np.arange(0.0, 1.0, fine)
    limited = np.minimum(0.4, (steps + 0.5 * fine) / (ramp * GAIN_LEFT))  # a step to 0.4
    stepwise = speeds(steps, limited, grid, gain_right=GAIN_LEFT, **controller)
    found = speeds([0.0], [0.4], grid, gain_right=GAIN_LEFT, motor_asymmetric_lag__ramp_up=ramp, **controller)
    assert found == pytest.approx(stepwise, abs=1e-3)
    assert max(found) > 1.02 * 0.4 * GAIN_LEFT  # it overshoots


def number(decision, name):
    place = parameter_table().place(f"motor_asymmetric_lag.{name}")
    return float(decision.model.fit.values[0, place])


RIVALS = ("motor_asymmetric_lag", "command_delay", "motor_deadband", "coulomb_friction")


def test_an_acceleration_limit_is_found_by_its_size():
    decision = judged(RIVALS, motor_asymmetric_lag__ramp_up=0.8)
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert decision.model.effects[0].hypothesis.closure == "limited up"
    assert number(decision, "ramp_up") == pytest.approx(0.8, rel=0.05)


def test_limits_both_ways_are_found_by_their_sizes():
    decision = judged(RIVALS, motor_asymmetric_lag__ramp_up=0.9, motor_asymmetric_lag__ramp_down=0.4)
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert number(decision, "ramp_up") == pytest.approx(0.9, rel=0.1)
    assert number(decision, "ramp_down") == pytest.approx(0.4, rel=0.1)


def test_a_limit_of_one_motor_is_found_on_its_side():
    numbers = {"motor_asymmetric_lag__ramp_down": 0.6, "motor_asymmetric_lag__ramp_side": 1.0}
    decision = judged(RIVALS, **numbers)
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert number(decision, "ramp_side") == 1.0
    assert number(decision, "ramp_down") == pytest.approx(0.6, rel=0.05)


def test_a_filter_both_ways_makes_a_start_one_of_two_lags():
    slow, own = 0.2, 0.08
    grid = np.arange(0.0, 2.0, 0.1)
    found = speeds(
        [0.0],
        [0.4],
        grid,
        gain_right=GAIN_LEFT,
        tau_forward=own,
        tau_turn=own,
        motor_asymmetric_lag__rise=slow,
        motor_asymmetric_lag__fall=slow,
    )
    lags = (slow * np.exp(-grid / slow) - own * np.exp(-grid / own)) / (slow - own)
    assert found == pytest.approx(0.4 * GAIN_LEFT * (1.0 - lags), abs=2e-3)


def test_a_filter_both_ways_is_found_by_its_sizes_and_not_taken_for_a_delay():
    decision = judged(RIVALS, motor_asymmetric_lag__rise=0.25, motor_asymmetric_lag__fall=0.25)
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert decision.model.effects[0].hypothesis.closure == "slow both ways"
    turn = float(decision.model.fit.values[0, parameter_table().place("tau_turn")])
    assert number(decision, "rise") == pytest.approx(number(decision, "fall"), rel=0.05)
    # lags in a row commute: either may be found as the motor's own
    assert number(decision, "rise") + turn == pytest.approx(0.25 + 0.15, rel=0.05)


def test_a_filter_of_one_motor_is_found_on_its_side():
    numbers = {f"motor_asymmetric_lag__{name}": value for name, value in (("rise", 0.2), ("ramp_side", -1.0))}
    decision = judged(RIVALS, **numbers)
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert number(decision, "ramp_side") == -1.0
    assert number(decision, "rise") == pytest.approx(0.2, rel=0.05)


def test_filters_of_each_side_are_found_by_their_sizes_and_not_taken_for_the_motors_own_lag():
    decision = judged(
        RIVALS,
        tau_forward=0.06,
        tau_turn=0.06,
        motor_asymmetric_lag__lag_left=0.2,
        motor_asymmetric_lag__lag_right=0.27,
    )
    assert [belief.name for belief in decision.named] == ["motor_asymmetric_lag"]
    assert decision.model.effects[0].hypothesis.closure == "each its filter"
    assert number(decision, "lag_left") == pytest.approx(0.2, rel=0.05)
    assert number(decision, "lag_right") == pytest.approx(0.27, rel=0.05)
