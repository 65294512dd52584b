"""A load beside the axle of a robot that is as wide as a vacuum cleaner."""

from dataclasses import replace

import pytest
from diagnosis_robots import decided, fitted_number, recording

AXLE = 0.25  # m
LOAD = {"payload_offset__x": 0.03, "payload_offset__y": 0.045}


def wide(seed):
    """Return a recording of a loaded robot whose sheet states its `AXLE`."""
    seen = recording(seed, axle_length=AXLE, **LOAD)
    return replace(seen, robot=replace(seen.robot, axle_length=AXLE))


def test_a_load_of_the_robots_own_mass_over_one_wheel_is_found_where_it_is():
    decision = decided([wide(0), wide(1)], ("payload_offset", "motor_deadband", "lateral_slip"))
    assert [belief.name for belief in decision.named] == ["payload_offset"]
    for name, true in LOAD.items():
        assert fitted_number(decision.model.fit, name) == pytest.approx(true, abs=0.002)
