"""Gears lose a share of the torque that they pass: less speeds a wheel up, more slows it down."""

import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged, speeds

MESH = 0.3
GRID = np.arange(0.0, 8.0, 0.005)


def time_constants(**changes):
    """Return how long a straight at half command takes to come within 1/e of its speed, and to lose all but 1/e [s]."""
    speed = speeds([0.0, 4.0], [0.5, 0.0], GRID, **changes)
    full = speed[GRID < 4.0][-1]
    risen = GRID[np.argmax(speed > (1.0 - np.exp(-1.0)) * full)]
    fallen = GRID[np.argmax((GRID > 4.0) & (speed < np.exp(-1.0) * full))] - 4.0
    return risen, fallen


def test_a_wheel_speeds_up_later_and_slows_down_sooner():
    (up, down), (slower, sooner) = time_constants(), time_constants(coulomb_friction__mesh=MESH)
    assert slower == pytest.approx(up / (1.0 - MESH), rel=0.1)
    assert sooner == pytest.approx(down / (1.0 + MESH), rel=0.1)


def test_a_wheel_that_passes_nothing_loses_nothing():
    plain, meshed = (speeds([0.0], [0.5], GRID, **c)[-1] for c in ({}, {"coulomb_friction__mesh": MESH}))
    assert meshed == pytest.approx(plain, rel=2e-3)


def test_loaded_gears_are_named_dry_friction_with_both_sizes():
    hidden = {"coulomb_friction__friction": 0.004, "coulomb_friction__mesh": MESH}
    decision = judged(("coulomb_friction", "motor_asymmetric_lag", "caster_drag", "motor_deadband"), **hidden)
    assert [belief.name for belief in decision.named] == ["coulomb_friction"]
    assert decision.model.effects[0].hypothesis.closure == "of loaded gears"
    for name, size in hidden.items():
        found = fitted_number(decision.model.fit, name)
        assert found == pytest.approx(size, rel=0.25)
