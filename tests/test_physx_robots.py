"""Robots of foreign physics in PhysX go straight, and turn by what their wheels roll."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("sapien")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.physx_robots.checks import kind_of, steady

TYRES = ["engine", "brush"]  # the engine's own contact, and a tyre model on top of it


@pytest.mark.parametrize("tyre", TYRES)
def test_equal_motors_keep_it_straight(tyre):
    drive = steady(kind_of("kobuki", tyre), 0.6, 0.6, 2.0)
    ahead = drive.x[-1] - drive.x[0]
    assert ahead > 0.1
    assert abs(drive.y[-1] - drive.y[0]) < 0.005 * ahead


@pytest.mark.parametrize("tyre", TYRES)
def test_the_same_drive_twice_is_equal(tyre):
    robot = kind_of("kobuki", tyre)
    once, again = (steady(robot, 0.5, -0.2, 1.0) for _ in range(2))
    assert list(once.x) == list(again.x)
    assert list(once.yaw) == list(again.yaw)
