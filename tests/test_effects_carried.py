"""A carpet's pile carries a driving robot by a share of its way."""

import numpy as np
import pytest
from diagnosis_robots import START, drive, fitted_number, judged, robot

from fsm_calib.world2d.observation import predict

CARRIED = {"carpet_nap__carried_x": 0.03, "carpet_nap__carried_y": -0.02}


def test_the_robot_is_carried_by_a_share_of_its_way_and_turns_as_without():
    commands, stamps = drive(np.random.default_rng(3), 20.0), np.arange(0.0, 20.0, 0.02)
    plain, carried = (predict(robot(**c), commands, stamps, START).poses for c in ({}, CARRIED))
    steps = np.diff(plain[:, :2], axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    np.testing.assert_allclose(carried[:, 0] - plain[:, 0], 0.03 * way, atol=1e-3)
    np.testing.assert_allclose(carried[:, 1] - plain[:, 1], -0.02 * way, atol=1e-3)
    np.testing.assert_allclose(carried[:, 2], plain[:, 2], atol=1e-9)


def test_a_robot_at_rest_is_not_carried():
    commands = drive(np.random.default_rng(3), 0.6)
    stamps = np.arange(0.0, 0.4, 0.02)  # the first command is at 0.5 s
    poses = predict(robot(**CARRIED), commands, stamps, START).poses
    np.testing.assert_array_equal(poses, np.tile(START, (len(stamps), 1)))


def test_a_pile_that_carries_is_found_by_its_size():
    decision = judged(("carpet_nap", "floor_tilt", "sensor_offset", "lateral_slip"), **CARRIED)
    assert [belief.name for belief in decision.named] == ["carpet_nap"]
    assert decision.model.effects[0].hypothesis.closure == "carried along the pile"
    for name, share in CARRIED.items():
        found = fitted_number(decision.model.fit, name)
        assert found == pytest.approx(share, abs=0.004)
