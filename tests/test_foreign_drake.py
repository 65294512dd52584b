"""Robots of foreign physics in Drake: straight, at the planar speed, the same twice; loads come off as they went on."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pydrake")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from foreign.drake_engine import KINDS, Drake, draw_mass, trunk
from foreign.drive import Planar
from foreign.robots import build, draw_robot
from foreign.setup import Setup, add_mass


def setup(number: int) -> Setup:
    """Return a robot of a kind, with equal motors and nothing else about it."""
    rng = np.random.default_rng(number)
    robot = draw_robot(rng, "r", "drake", (), draw_mass(rng, number))
    out = build(robot, None, None, 1, 0.0, "drake")
    for motor in (out.left, out.right):
        motor["gain"] = 1.0
    return out


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_a_robot_drives_straight_and_as_fast_as_in_the_plane(number: int) -> None:
    duty = np.full((4000, 2), 0.6)
    rows = Drake(setup(number), np.zeros(3)).forward(duty)
    plane = Planar(setup(number), np.zeros(3)).forward(duty)
    assert rows.shape == plane.shape == (200, 8)
    assert abs(rows[-1, 1]) < 1e-4
    assert abs(rows[-1, 2]) < 1e-4
    assert rows[-1, 3] == pytest.approx(plane[-1, 3], rel=0.02)
    assert np.array_equal(rows, Drake(setup(number), np.zeros(3)).forward(duty))


def test_a_load_comes_off_as_it_went_on() -> None:
    loaded, bare = setup(1), setup(1)
    add_mass(loaded, 2.0, -0.1, 0.05)
    add_mass(loaded, 1.0, 0.1, 0.0)
    assert trunk(loaded).mass == pytest.approx(bare.body["mass"])
    assert trunk(loaded).x == pytest.approx(bare.body["com_x"])
    assert trunk(loaded).y == pytest.approx(0.0, abs=1e-12)
    assert trunk(loaded).inertia == pytest.approx(bare.body["inertia"])


def test_a_friction_that_falls_under_both_wheels_lets_them_spin() -> None:
    slippery = setup(0)
    slippery.hooks.append(lambda _t, _state, hook: hook.__setitem__(slice(3, 5), 0.02))
    duty = np.full((1000, 2), 0.9)
    assert (
        Drake(slippery, np.zeros(3)).forward(duty)[-1, 0]
        < 0.5 * Drake(setup(0), np.zeros(3)).forward(duty)[-1, 0]
    )
