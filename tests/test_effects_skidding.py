"""Tyres that hold along and slide across: their side force has an end."""

import numpy as np
import pytest
from diagnosis_robots import START, fitted_number, judged, robot

from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive
from fsm_calib.world2d.slots import GRAVITY

SKID = 40.0
STAMPS = np.arange(0.0, 6.0, 0.02)


def twist(command, **changes):
    """Return speed ahead, speed to the left [m/s] and yaw rate [rad/s] at the end of a steady arc to the left."""
    commands = Drive(np.array([0.0]), np.array([0.7 * command]), np.array([command]))
    x, y, theta = predict(robot(**changes), commands, STAMPS, START).poses[-2:].T
    middle, step = theta.mean(), STAMPS[1]
    ahead, left = np.diff(x)[0] / step, np.diff(y)[0] / step
    c, s = np.cos(middle), np.sin(middle)
    return c * ahead + s * left, c * left - s * ahead, np.diff(theta)[0] / step


@pytest.mark.parametrize("skid", [1.0, 3.0, 6.0])
def test_the_nearer_a_curve_is_to_what_the_tyres_hold_the_more_they_slide(skid):
    """The centripetal force S = l / (1/k + skid l / (m g / 2)) asks for l = (S / k) / (1 - skid v omega / g)."""
    v, l, omega = twist(0.3, lateral_slip__skid=skid)
    v0, gripping, omega0 = twist(0.3)
    part = skid * v * omega / GRAVITY
    assert part < 0.9
    assert l / (v * omega) == pytest.approx(gripping / (v0 * omega0) / (1.0 - part), rel=0.1)


def test_side_forces_end_at_the_load_over_the_skid():
    """On a curve that asks for more the robot is carried on: its way turns by no more than the tyres hold."""
    v, l, omega = twist(0.8, lateral_slip__skid=40.0)
    held = np.hypot(v, l) * omega
    assert held > GRAVITY / 40.0
    assert abs(l) > 0.2 * v


def test_skidding_tyres_are_named_and_measured():
    hidden = {"lateral_slip__skid": SKID}
    decision = judged(("lateral_slip", "sensor_offset", "sensor_yaw", "payload_offset"), **hidden)
    assert [belief.name for belief in decision.named] == ["lateral_slip"]
    assert decision.model.effects[0].hypothesis.closure == "skidding tyres"
    assert fitted_number(decision.model.fit, "lateral_slip.skid") == pytest.approx(SKID, rel=0.1)
