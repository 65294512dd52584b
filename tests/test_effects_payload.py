"""A load beside the axle of a robot that is as wide as a vacuum cleaner."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording

from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.verdict.decide import Judge
from fsm_calib.world2d.effects import registry

AXLE = 0.25  # m
LOAD = {"payload_offset__x": 0.03, "payload_offset__y": 0.045}


def wide(seed):
    """Return a recording of a loaded robot whose sheet states its `AXLE`."""
    seen = recording(seed, axle_length=AXLE, **LOAD)
    return replace(seen, robot=replace(seen.robot, axle_length=AXLE))


def test_a_load_of_the_robots_own_mass_over_one_wheel_is_found_where_it_is():
    effects = [registry()[name] for name in ("payload_offset", "motor_deadband", "lateral_slip")]
    engine = engine_of(wide(0), wide(1))
    decision = Judge(engine, effects, DEFAULT_GATES, lambda part: None, np.random.default_rng(0)).decide()
    assert [belief.name for belief in decision.named] == ["payload_offset"]
    for name, true in LOAD.items():
        assert fitted_number(decision.model.fit, name) == pytest.approx(true, abs=0.002)
