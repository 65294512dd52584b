"""Robots of foreign physics in DART go straight and as fast as their torque-speed line says."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dartpy")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.dart_robots.checks import Steady, equal, expected_rate
from benchmarks.dart_robots.robots import KINDS, draw_robot
from benchmarks.dart_robots.simulate import simulate
from benchmarks.dart_robots.truth import Moments


def driven(kind, command, seconds):
    """Return a robot with equal sides on a ball caster, and its drive by one command on both motors."""
    rng = np.random.default_rng(31)
    truth, _ = draw_robot(rng, kind, "duty")
    while truth.body.caster != "ball":
        truth, _ = draw_robot(rng, kind, "duty")
    same = equal(truth)
    return same, simulate(same, Steady(command, command), seconds, 0.001, Moments())


@pytest.mark.parametrize("kind", KINDS)
def test_equal_motors_keep_it_straight(kind):
    _, drive = driven(kind, 0.5, 3.0)
    assert drive.x[-1] > 0.05
    assert abs(drive.theta[-1]) < 1e-4
    assert abs(drive.y[-1]) < 1e-4


def test_it_reaches_the_speed_of_its_torque_speed_line():
    truth, drive = driven("burger", 1.0, 4.0)
    assert drive.left[-1] - drive.left[-251] == pytest.approx(expected_rate(truth), rel=0.01)
