"""The camera's tilt, told by floor tags of all frames together."""

import dataclasses
import math

import numpy as np
import pytest
from test_floor_pose import CAMERA, DRAWN, MOUNT, seen_from

from fsm_calib.perception.floor_map import adjusted_poses
from fsm_calib.perception.floor_pose import floor_pose
from fsm_calib.perception.levelled import levelled
from fsm_calib.types import Pose2

SIZE = 0.065
TILTED = dataclasses.replace(MOUNT, pitch=MOUNT.pitch + 0.003, roll=MOUNT.roll - 0.002)
ROUND = [Pose2(0.3 + 0.15 * math.cos(a), 0.3 + 0.1 * math.sin(a), 1.7 * a) for a in np.linspace(0.0, 6.0, 60)]


def frames(mount, noise=0.0):
    """Return what a camera that is taken to look as `mount` tells of the tags on a round."""
    rng = np.random.default_rng(0)
    told = [floor_pose(seen_from(p, noise=noise, rng=rng), CAMERA, mount, DRAWN) for p in ROUND]
    return [pose.seen for pose in told]


def off(seen):
    """Return how far the poses of frames scatter about the robot's, as seen from it: x, y [m], heading [rad]."""
    poses, _ = adjusted_poses(seen, DRAWN, SIZE)
    errors = [robot.inverse().then(Pose2(*pose)) for robot, pose in zip(ROUND, poses, strict=True)]
    return np.std([(e.x, e.y, math.remainder(e.theta, math.tau)) for e in errors], axis=0)


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_poses_of_a_tilted_camera_no_longer_scatter(noise):
    seen = frames(TILTED, noise)
    before, after = off(seen), off(levelled(seen, DRAWN, TILTED, SIZE))
    assert np.linalg.norm(after[:2]) < 0.5 * np.linalg.norm(before[:2])
    assert after[2] < before[2]


def test_tags_of_a_level_camera_stay_where_they_are():
    seen = frames(MOUNT)
    moved = np.array([tag[1:4] for frame in levelled(seen, DRAWN, MOUNT, SIZE) for tag in frame])
    assert np.abs(moved - [tag[1:4] for frame in seen for tag in frame]).max() < 2e-4


def test_every_tag_keeps_its_number_and_its_spread():
    seen = frames(TILTED)
    now = levelled(seen, DRAWN, TILTED, SIZE)
    assert [[(tag[0], tag[4]) for tag in frame] for frame in now] == [
        [(tag[0], pytest.approx(tag[4])) for tag in frame] for frame in seen
    ]


def test_nothing_seen_tells_nothing():
    assert levelled([], DRAWN, MOUNT, SIZE) == []
