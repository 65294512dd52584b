"""A tracker that finds the robot elsewhere is no push, a push is no such jump."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import decided, recording

RATE = 30.0  # Hz
AT = 14.0  # s, of the jump and of the push
PUSH = {"external_push__impulse_x": 0.7, "external_push__impulse_y": 0.4, "external_push__start": AT}


def jumped(seen, at=AT):
    """Return a recording whose poses are 8 cm and 3 deg elsewhere after a time [s]."""
    pose = seen.pose
    later = pose.time > at
    moved = replace(pose, x=pose.x + 0.07 * later, y=pose.y - 0.04 * later, theta=pose.theta + 0.05 * later)
    return replace(seen, pose=moved)


def decided_with(first):
    return decided([first, recording(1, rate=RATE)], ("external_push", "floor_tilt", "payload_offset"))


@pytest.fixture(scope="module")
def of_a_jump():
    return decided_with(jumped(recording(0, rate=RATE)))


@pytest.fixture(scope="module")
def of_a_push():
    return decided_with(recording(0, rate=RATE, **PUSH))


def test_poses_that_jump_are_not_called_a_push(of_a_jump):
    assert of_a_jump.named == ()
    assert of_a_jump.outcome == "unexplained"
    assert "a jump of the measured poses does as well" in of_a_jump.reason


def test_poses_that_jump_twice_in_a_drive_are_not_called_pushes():
    decision = decided_with(jumped(jumped(recording(0, rate=RATE)), at=8.0))
    assert "external_push" not in [belief.name for belief in decision.named]
    assert decision.outcome == "unexplained"


def test_a_push_keeps_its_name(of_a_push):
    assert [belief.name for belief in of_a_push.named] == ["external_push"]
    assert of_a_push.named[0].probability > 0.9


def test_a_jump_explains_what_jumped_better_than_a_push_and_a_push_worse(of_a_jump, of_a_push):
    (jump,), (push,) = of_a_jump.model.supports, of_a_push.model.supports
    assert jump.forms.jump > 10.0
    assert push.forms.jump < -50.0


def test_only_a_moment_is_held_against_jumps():
    decision = decided_with(recording(0, rate=RATE, floor_tilt__slope_x=0.05))
    assert {s.name: s.forms.jump for s in decision.model.supports} == {"floor_tilt": -np.inf}
