"""A cell's inner resistance: the supply dips by the current that the motors draw, not by what they are told."""

import numpy as np
import pytest
from diagnosis_robots import judged, speeds

from fsm_calib.world2d.parameters import parameter_table

GAIN = 0.636  # m/s


def speed(command, inner, seconds=6.0, friction=0.0):
    """Return the robot's speed [m/s] over time on a straight at one command."""
    effects = {"battery_sag__inner": inner, "coulomb_friction__friction": friction}
    grid = np.arange(0.0, seconds, 0.01)
    return speeds([0.0], [command], grid, gain_left=GAIN, gain_right=GAIN, **effects)


def test_motors_that_run_free_lose_nothing():
    assert speed(0.8, 0.5)[-1] == pytest.approx(speed(0.8, 0.0)[-1], rel=1e-3)


def test_a_start_is_weaker_by_the_current_of_both_stalled_motors():
    """At rest the cell lies in series with two bridges that each draw u of the stall current: 1 / (1 + 2 r u^2)."""
    for command in (0.4, 0.8):
        share = speed(command, 0.5)[2] / speed(command, 0.0)[2]
        assert share == pytest.approx(1.0 / (1.0 + 2.0 * 0.5 * command**2), rel=0.05)


def test_friction_costs_more_speed_where_the_cell_is_weak():
    lost = speed(0.8, 0.0, friction=0.01)[-1] - speed(0.8, 0.5, friction=0.01)[-1]
    assert lost > 0.02 * speed(0.8, 0.0)[-1]


def test_it_is_named_by_its_size():
    rivals = ("battery_sag", "motor_asymmetric_lag", "motor_warmup", "command_saturation", "motor_gain_curve")
    decision = judged(rivals, battery_sag__inner=0.4)
    assert [belief.name for belief in decision.named] == ["battery_sag"]
    assert decision.model.effects[0].hypothesis.closure == "inner resistance"
    place = parameter_table().place("battery_sag.inner")
    assert decision.model.fit.values[0, place] == pytest.approx(0.4, rel=0.1)
