"""A driver that ignores small commands and takes larger ones whole: a dead zone without an offset."""

import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged

from fsm_calib.world2d.effects.motor_deadband import EDGE, offset
from fsm_calib.world2d.parameters import parameter_table, parameters

PLACE = parameter_table().first["motor_deadband"]


def passed(command, threshold=0.1):
    return offset(parameters({"motor_deadband.threshold": threshold}), PLACE, command, 0)


def test_smaller_commands_do_nothing_and_larger_ones_act_whole():
    for sign in (1.0, -1.0):
        assert passed(sign * (0.1 - EDGE)) == 0.0
        assert passed(sign * (0.1 + EDGE)) == pytest.approx(sign * (0.1 + EDGE))


def test_across_the_edge_the_command_rises_steadily():
    u = np.linspace(0.09, 0.11, 50)
    assert np.all(np.diff([passed(x) for x in u]) >= 0.0)


def test_it_is_named_by_its_size():
    rivals = ("motor_deadband", "motor_gain_curve", "coulomb_friction", "command_saturation", "caster_drag")
    decision = judged(rivals, duration=40.0, motor_deadband__threshold=0.12)
    assert [belief.name for belief in decision.named] == ["motor_deadband"]
    assert decision.model.effects[0].hypothesis.closure == "ignored when small"
    found = fitted_number(decision.model.fit, "motor_deadband.threshold")
    assert found == pytest.approx(0.12, abs=EDGE)


def test_each_motors_driver_may_have_a_threshold_of_its_own():
    robot = parameters({"motor_deadband.threshold_left": 0.15, "motor_deadband.threshold_right": 0.05})
    assert [offset(robot, PLACE, 0.1, side) for side in (0, 1)] == [0.0, 0.1]


def test_thresholds_of_each_motor_are_found():
    rivals = ("motor_deadband", "motor_gain_curve", "coulomb_friction", "command_saturation", "caster_drag")
    sizes = {"motor_deadband__threshold_left": 0.16, "motor_deadband__threshold_right": 0.11}
    decision = judged(rivals, **sizes)
    assert [belief.name for belief in decision.named] == ["motor_deadband"]
    assert decision.model.effects[0].hypothesis.closure == "each ignored when small"
    for name, size in sizes.items():
        assert fitted_number(decision.model.fit, name) == pytest.approx(size, abs=1.5 * EDGE)
