"""The poses of a plane from its points, and what stands in where the plane-based solution is no number."""

import cv2
import numpy as np
import pytest

from fsm_calib.perception.ground import tag_corners, tag_poses
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.plane_poses import plane_poses
from fsm_calib.perception.rotations import rotation_from_vector
from fsm_calib.types import BoardSpec, TagDetection
from fsm_calib.world2d.fleet import nominal_camera

TURN, SHIFT = np.array([0.5, -0.3, 0.2]), np.array([0.03, -0.02, 0.4])
NO_NUMBER = (2, [np.full((3, 1), np.nan)] * 2, [np.full((3, 1), np.nan)] * 2, None)


def seen(points: np.ndarray) -> np.ndarray:
    """Return the points in the camera frame, shape (n, 3) [m]."""
    return points @ rotation_from_vector(TURN).T + SHIFT


def rays_of(points: np.ndarray) -> np.ndarray:
    camera_frame = seen(points)
    return camera_frame[:, :2] / camera_frame[:, 2:]


def test_the_better_pose_of_a_tilted_board_is_the_true_one() -> None:
    points = BoardSpec().points_board()
    first, second = plane_poses(points, rays_of(points))
    np.testing.assert_allclose(first[0].ravel(), TURN, atol=1e-6)
    np.testing.assert_allclose(first[1].ravel(), SHIFT, atol=1e-6)
    assert np.linalg.norm(second[0].ravel() - TURN) > 0.1


def test_one_good_pose_of_two_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    points = BoardSpec().points_board()
    good = (TURN[:, None], SHIFT[:, None])
    half = (2, [NO_NUMBER[1][0], good[0]], [NO_NUMBER[2][0], good[1]], None)
    monkeypatch.setattr(cv2, "solvePnPGeneric", lambda *_, **__: half)
    ((turn, shift),) = plane_poses(points, rays_of(points))
    assert (turn == good[0]).all()
    assert (shift == good[1]).all()


def test_a_tag_has_a_pose_where_the_plane_based_one_is_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = nominal_camera()
    corners = project(intrinsics_vector(camera), seen(tag_corners(0.065)))
    monkeypatch.setattr(cv2, "solvePnPGeneric", lambda *_, **__: NO_NUMBER)
    (pose,) = tag_poses(TagDetection(7, corners), camera, 0.065)
    np.testing.assert_allclose(pose.centre, SHIFT, atol=1e-4)
    np.testing.assert_allclose(pose.rotation, rotation_from_vector(TURN), atol=1e-3)
