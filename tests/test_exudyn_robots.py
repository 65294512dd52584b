"""Robots of foreign physics in Exudyn go straight, and turn by what their wheels roll."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("exudyn")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.exudyn_robots.checks import example, steady


@pytest.mark.parametrize("kind", ["turtle_like", "platform"])
def test_equal_motors_keep_it_straight(kind):
    x, y, theta = steady(example(kind, even=True), 0.6, 0.6, 4.0).pose[-1]
    assert x > 0.1
    assert abs(y) < 1e-6
    assert abs(theta) < 1e-6


def test_a_spin_turns_by_the_ways_of_the_wheels():
    setup = example("platform", even=True)
    truth = steady(setup, -0.5, 0.5, 4.0)
    left, right = truth.angle[-1]
    wheels = setup.par[0]
    assert truth.pose[-1, 2] == pytest.approx(
        (right - left) * wheels["radius"][0] / wheels["axle"], rel=0.015
    )
