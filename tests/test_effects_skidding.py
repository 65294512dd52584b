"""Tyres that hold along and slide across: their side force has an end."""

import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged, twist_in_an_arc

from fsm_calib.world2d.slots import GRAVITY

SKID = 40.0


@pytest.mark.parametrize("skid", [1.0, 3.0, 6.0])
def test_the_nearer_a_curve_is_to_what_the_tyres_hold_the_more_they_slide(skid):
    """The centripetal force S = l / (1/k + skid l / (m g / 2)) asks for l = (S / k) / (1 - skid v omega / g)."""
    v, l, omega = twist_in_an_arc(0.3, lateral_slip__skid=skid)
    v0, gripping, omega0 = twist_in_an_arc(0.3)
    part = skid * v * omega / GRAVITY
    assert part < 0.9
    assert l / (v * omega) == pytest.approx(gripping / (v0 * omega0) / (1.0 - part), rel=0.1)


def test_on_a_curve_that_asks_for_more_than_they_hold_tyres_slide_far():
    v, l, omega = twist_in_an_arc(0.8, lateral_slip__skid=40.0)
    held = np.hypot(v, l) * omega
    assert held > GRAVITY / 40.0
    assert abs(l) > 0.2 * v


def test_skidding_tyres_are_named_and_measured():
    hidden = {"lateral_slip__skid": SKID}
    decision = judged(("lateral_slip", "sensor_offset", "sensor_yaw", "payload_offset"), **hidden)
    assert [belief.name for belief in decision.named] == ["lateral_slip"]
    assert decision.model.effects[0].hypothesis.closure == "skidding tyres"
    assert fitted_number(decision.model.fit, "lateral_slip.skid") == pytest.approx(SKID, rel=0.1)
