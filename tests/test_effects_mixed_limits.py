"""Limits of both commands at once: a largest rate of turning, and a mixer that keeps the curve."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import HEADING_NOISE, POSITION_NOISE, START, decided, fitted_number, recording, robot

from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive, simulate

GRID = np.arange(0.0, 6.0, 0.02)
RIVALS = ("command_saturation", "motor_gain_curve", "tyre_scrub", "lateral_slip")
"""What a robot that turns too little could be said to have."""


def turning_cut(left, right, most=0.2):
    """Return commands of which half the difference is at most `most`."""
    mean, half = 0.5 * (left + right), np.clip(0.5 * (right - left), -most, most)
    return mean - half, mean + half


def curve_kept(left, right, limit=0.3):
    """Return commands that are scaled down alike where one is beyond `limit`."""
    scale = limit / np.maximum(np.maximum(np.abs(left), np.abs(right)), limit)
    return left * scale, right * scale


CUTS = [
    (turning_cut, {"command_saturation__turn": 0.2}, "turn limit"),
    (curve_kept, {"command_saturation__limit": 0.3, "command_saturation__together": 1.0}, "curve kept"),
]


def cut_by_the_base(seed, cut):
    """Return a drive whose commands were cut by the base, which the recording does not tell."""
    told = recording(seed)
    command = told.command
    driven = Drive(command.time, *cut(command.left, command.right))
    poses = predict(robot(), driven, told.pose.time, START).poses
    rng = np.random.default_rng((seed, 9))
    x, y, theta = (poses + rng.normal(size=poses.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE]).T
    return replace(told, pose=replace(told.pose, x=x, y=y, theta=theta))


@pytest.mark.parametrize(("cut", "numbers", "closure"), CUTS)
@pytest.mark.parametrize(("left", "right"), [(0.5, 0.1), (-0.4, 0.4), (0.2, 0.25), (-0.5, -0.1), (0.6, 0.6)])
def test_the_robot_drives_as_one_that_is_told_the_cut_commands(cut, numbers, closure, left, right):
    told = Drive(np.array([0.0]), np.array([left]), np.array([right]))
    acted = Drive(np.array([0.0]), *(np.array([float(u)]) for u in cut(left, right)))
    cut_inside = simulate(robot(**numbers), told, GRID, START)
    np.testing.assert_allclose(cut_inside, simulate(robot(), acted, GRID, START), atol=1e-9)


@pytest.mark.parametrize(("cut", "numbers", "closure"), CUTS)
def test_it_is_named_by_its_own_closure_with_its_size(cut, numbers, closure):
    decision = decided([cut_by_the_base(seed, cut) for seed in (0, 1)], RIVALS)
    assert [belief.name for belief in decision.named] == ["command_saturation"]
    (effect,) = decision.model.effects
    assert effect.hypothesis.closure == closure
    name, size = next((n, x) for n, x in numbers.items() if x < 1.0)
    assert fitted_number(effect.fit, name) == pytest.approx(size, abs=0.01)


def test_a_robot_that_turns_as_told_has_no_such_limit():
    decision = decided([recording(seed) for seed in (0, 1)], RIVALS)
    assert decision.named == ()
