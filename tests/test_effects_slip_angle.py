"""A rolling tyre creeps sideways by an angle that grows with its side force."""

import numpy as np
import pytest
from diagnosis_robots import START, fitted_number, judged, robot, twist_in_an_arc

from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

ANGLE = 0.06
CREEPING = {"lateral_slip__slip_angle": ANGLE}
STAMPS = np.arange(0.0, 6.0, 0.02)


@pytest.mark.parametrize("command", [0.3, 0.8])
def test_the_angle_of_a_steady_arc_is_that_of_its_centripetal_acceleration(command):
    v, l, omega = twist_in_an_arc(command, **CREEPING)
    _, rolling_on, _ = twist_in_an_arc(command)
    assert (l - rolling_on) / v == pytest.approx(-ANGLE * v * omega, rel=0.06)


def test_a_robot_that_spins_on_the_spot_does_not_creep():
    commands = Drive(np.array([0.0]), np.array([-0.4]), np.array([0.4]))
    spins = [predict(robot(**c), commands, STAMPS, START).poses for c in ({}, CREEPING)]
    np.testing.assert_allclose(spins[0], spins[1], atol=5e-4)


def test_creeping_tyres_are_named_by_the_angle():
    decision = judged(("lateral_slip", "sensor_offset", "sensor_yaw", "payload_offset"), **CREEPING)
    assert [belief.name for belief in decision.named] == ["lateral_slip"]
    assert decision.model.effects[0].hypothesis.closure == "slip angle"
    found = fitted_number(decision.model.fit, "lateral_slip.slip_angle")
    assert found == pytest.approx(ANGLE, rel=0.1)
