"""From image points to the floor, and floor tags relative to the robot.

A pixel's undistorted ray (x, y, 1), turned into `base` by the mount, meets the floor z = 0 at
p = o - o_z / d_z d with o the camera's position [m] and d the ray's direction in `base`.

A tag's heading is read in the floor frame. The angle about the optical axis, which the paper's program reads,
is only sin(pitch) of it for a tag on the floor; it is kept as `heading_camera` for comparison.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from fsm_calib.perception.lens import intrinsics_vector, unproject
from fsm_calib.perception.plane_poses import plane_poses
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.types import (
    CameraModel,
    CameraMount,
    FloatArray,
    TagDetection,
    TagObservation,
)


@dataclass(frozen=True, slots=True)
class TagSettings:
    """When a tag's pose is refused.

    Parameters
    ----------
    largest_tilt : float
        Between the tag and the floor [rad]: 10 deg; a flipped pose shows more.
    smallest_ratio : float
        Reprojection error of the second pose over the first [1]; below it the two cannot be told apart by the
        image, and the tilt must decide alone (see `largest_clear_tilt`).
    largest_clear_tilt : float
        A pose with an ambiguous ratio is still taken when it lies this flat [rad] and its rival does not
        pass.
    """

    largest_tilt: float = math.radians(10.0)
    smallest_ratio: float = 2.0
    largest_clear_tilt: float = math.radians(5.0)


DEFAULT_TAGS = TagSettings()


@dataclass(frozen=True, eq=False)
class TagPose:
    """A tag in the camera frame: rotation (3, 3), centre (3,) [m], root mean square reprojection error
    [px].
    """

    rotation: FloatArray
    centre: FloatArray
    error: float


def floor_points(image_points: FloatArray, camera: CameraModel, mount: CameraMount) -> FloatArray:
    """Return where image points, shape (n, 2) [px], lie on the floor in `base`, shape (n, 2) [m].

    Points on or above the horizon are nan.
    """
    rays = unproject(intrinsics_vector(camera), np.asarray(image_points, dtype=float).reshape(-1, 2))
    rotation, position = base_from_camera(mount)
    direction = np.column_stack([rays, np.ones(len(rays))]) @ rotation.T
    below = direction[:, 2] < -1e-6
    reach = np.where(below, -position[2] / np.where(below, direction[:, 2], -1.0), np.nan)
    return position[:2] + reach[:, None] * direction[:, :2]


def tag_corners(tag_size: float) -> FloatArray:
    """Return the corners of a tag of side `tag_size` [m] in its own frame, shape (4, 3) [m], library
    order.
    """
    half = tag_size / 2.0
    return np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])


def tag_poses(detection: TagDetection, camera: CameraModel, tag_size: float) -> tuple[TagPose, ...]:
    """Return the two poses that explain a tag's corners, the better first (`plane_poses`, refined).

    OpenCV's IPPE_SQUARE wants top left, top right, bottom right, bottom left.
    """
    rays = unproject(intrinsics_vector(camera), detection.corners_image)
    return _poses_of_rays(rays, camera, tag_size)


def _poses_of_rays(rays: FloatArray, camera: CameraModel, tag_size: float) -> tuple[TagPose, ...]:
    """Return the two poses, the better first, from the rays of a tag's corners, shape (4, 2) [1]."""
    order = [3, 2, 1, 0]
    corners, found = np.ascontiguousarray(tag_corners(tag_size)[order]), np.ascontiguousarray(rays[order])
    scale = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    poses = [
        _refined(corners, found, turn, centre, scale)
        for turn, centre in plane_poses(corners, found, cv2.SOLVEPNP_IPPE_SQUARE)
    ]
    return tuple(sorted(poses, key=lambda pose: pose.error))


def _refined(
    corners: FloatArray, rays: FloatArray, turn: FloatArray, centre: FloatArray, scale: float
) -> TagPose:
    """Return the pose after a least-squares refinement: the closed form is up to 2.5 deg off for a tag
    seen head on.
    """
    better, place = cv2.solvePnPRefineLM(corners, rays, np.eye(3), None, turn.copy(), centre.copy())
    predicted, _ = cv2.projectPoints(corners, better, place, np.eye(3), None)
    error = float(np.sqrt(np.mean(np.sum((predicted[:, 0] - rays) ** 2, axis=1))))
    return TagPose(np.asarray(cv2.Rodrigues(better)[0], float), np.ravel(place), error * scale)


def observe_tags(
    detections: Sequence[TagDetection],
    camera: CameraModel,
    mount: CameraMount,
    tag_size: float = 0.065,
    settings: TagSettings = DEFAULT_TAGS,
) -> tuple[TagObservation, ...]:
    """Return the floor tags relative to the robot, the nearest first; tags whose pose is in doubt are left
    out.

    Parameters
    ----------
    detections : sequence of TagDetection
    camera, mount : the calibrated camera and where it sits
    tag_size : float
        Side of the black square [m]; Duckietown's floor tags are 0.065 m.
    """
    if not detections:
        return ()
    rotation, position = base_from_camera(mount)
    corners = np.stack([detection.corners_image for detection in detections])
    observed = []
    for detection, rays in zip(detections, unproject(intrinsics_vector(camera), corners), strict=True):
        pose = _floor_pose(_poses_of_rays(rays, camera, tag_size), rotation, settings)
        if pose is not None:
            observed.append(_observation(detection.tag_id, pose, rotation, position))
    return tuple(sorted(observed, key=lambda tag: tag.distance))


def _tilt(pose: TagPose, base_from_cam: FloatArray) -> float:
    upward = float((base_from_cam @ pose.rotation[:, 2])[2])
    return math.acos(min(max(upward, -1.0), 1.0))


def _floor_pose(poses: Sequence[TagPose], base_from_cam: FloatArray, settings: TagSettings) -> TagPose | None:
    """Return the pose that lies on the floor, or None when none does or two might."""
    flat = [pose for pose in poses if _tilt(pose, base_from_cam) <= settings.largest_tilt]
    if not flat:
        return None
    first = flat[0]
    rivals = [pose for pose in poses if pose is not first]
    clear = all(rival.error >= settings.smallest_ratio * first.error for rival in rivals)
    alone = len(flat) == 1 and _tilt(first, base_from_cam) <= settings.largest_clear_tilt
    return first if clear or alone else None


def _observation(
    tag_id: int, pose: TagPose, base_from_cam: FloatArray, position: FloatArray
) -> TagObservation:
    centre = base_from_cam @ pose.centre + position
    along = base_from_cam @ pose.rotation[:, 0]
    return TagObservation(
        tag_id=tag_id,
        x=float(centre[0]),
        y=float(centre[1]),
        heading=math.atan2(along[1], along[0]),
        distance=float(np.linalg.norm(pose.centre)),
        heading_camera=_camera_heading(pose.rotation),
    )


def _camera_heading(rotation: FloatArray) -> float:
    """Return the paper's reading [rad]: the tag's turn about the optical axis, as Euler angles give it.

    It is the angle in the image of the tag's right side (-y of the tag, to the right for a robot that stands along
    the tags), counter-clockwise: atan2(sin(pitch) sin(heading), cos(heading)) for a tag on the floor.
    """
    right = -rotation[:, 1]
    return math.atan2(-right[1], right[0])
