"""Steps made at once, while nothing is near, are those made one by one in pymunk, to the last bit."""

import math

import numpy as np
import pymunk
import pytest

from fsm_calib.types import STOP, Pose2, WheelCommand
from fsm_calib.world2d import motion
from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.clearance import MARGIN, OUTLINE_REACH, free_room
from fsm_calib.world2d.deviation import straight_track
from fsm_calib.world2d.obstacles import make_space, robot_outline
from fsm_calib.world2d.parameters import null_parameters
from fsm_calib.world2d.robot import World, make_world
from fsm_calib.world2d.rollout import Drive, simulate
from fsm_calib.world2d.spec import WorldSpec


def random_drive(seed: int, forward: float) -> tuple[World, int]:
    """Return a world after 40 held random commands, and at how many of their ends the robot touched something."""
    world, rng, touched = make_world(WorldSpec(seed=seed)), np.random.default_rng(seed), 0
    for _ in range(40):
        world.robot.command(WheelCommand(*rng.uniform(forward - 0.6, forward + 0.6, 2)))
        world.robot.wait(float(rng.uniform(0.01, 1.5)))
        world.robot.command(STOP)
        world.robot.wait(0.05)
        touched += world.truth.is_touching
    return world, touched


@pytest.mark.parametrize(("seed", "forward", "touches"), [(3, 0.0, False), (0, 0.3, True)])
def test_steps_at_once_equal_steps_one_by_one_to_the_last_bit(monkeypatch, seed, forward, touches):
    at_once, touched = random_drive(seed, forward)
    monkeypatch.setattr(motion, "_LEAST_AT_ONCE", math.inf)
    one_by_one, _ = random_drive(seed, forward)
    assert (touched > 0) == touches
    assert np.array_equal(at_once.truth.trace, one_by_one.truth.trace)
    assert at_once.truth.odometer == one_by_one.truth.odometer
    assert at_once.truth.twist == one_by_one.truth.twist


def test_a_ride_ends_where_its_room_ends():
    robot = RobotBody(pymunk.Space(), null_parameters())
    poses = robot.ride_free(np.full((1000, 2), 0.5), 0.002, 0.1)
    assert 0.09 < math.hypot(*poses[-1, :2]) <= 0.1
    assert (robot.pose.x, robot.pose.y, robot.pose.theta) == tuple(poses[-1])
    assert robot.time == pytest.approx(0.002 * len(poses))


def test_room_is_measured_from_the_outline_to_the_nearest_shape_and_not_to_the_robot_itself():
    space = make_space()
    robot = RobotBody(space, null_parameters(), Pose2(0.2, 0.0, 1.0))
    space.add(robot_outline(robot.body))
    space.add(pymunk.Segment(space.static_body, (1.0, -1.0), (1.0, 1.0), 0.01))
    assert free_room(space, (0.2, 0.0)) == pytest.approx(0.79 - OUTLINE_REACH - MARGIN)


def test_a_test_drive_in_the_world_is_that_of_the_rollout():
    track = straight_track(null_parameters(), (0.23, 0.24), 3.0)
    drive, times = Drive([0.0], [0.23], [0.24]), np.linspace(0.0, 3.0, 1501)
    assert np.abs(track - simulate(null_parameters(), drive, times, (0, 0, 0), dt=0.002)[:, :3]).max() < 1e-9
