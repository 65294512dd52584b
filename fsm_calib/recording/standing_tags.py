"""Tags in images, lying on the floor or standing upright: both relative to the robot, told apart by their tilt.

A standing tag's print is vertical and its lower edge level, so that its x axis (to the right of who reads it) is
horizontal, as a lying tag's is. Seen from far away the two poses that explain the corners of a standing tag are both
upright and differ in heading: such a tag is left out unless the image itself prefers one clearly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fsm_calib.perception.ground import DEFAULT_TAGS, TagPose, observe_tags, tag_poses
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.types import CameraModel, CameraMount, FloatArray, TagDetection, TagObservation

TAG_SIZE = 0.065  # m, side of the black square of Duckietown's tags, on the floor and on signs alike
LARGEST_LEAN = math.radians(15.0)  # of a standing tag from the vertical: stands are bent paper


def observe_both(
    detections: Sequence[TagDetection], camera: CameraModel, mount: CameraMount, tag_size: float = TAG_SIZE
) -> tuple[TagObservation, ...]:
    """Return lying and standing tags of side `tag_size` [m] relative to the robot; those in doubt are left out."""
    lying = observe_tags(detections, camera, mount, tag_size)
    known = {tag.tag_id for tag in lying}
    turn, place = base_from_camera(mount)
    standing = []
    for detection in detections:
        if detection.tag_id in known:
            continue
        pose = _standing(tag_poses(detection, camera, tag_size), turn)
        if pose is not None:
            standing.append(_observed(detection.tag_id, pose, turn, place))
    return (*lying, *standing)


def lean(x_axis: FloatArray, z_axis: FloatArray) -> float:
    """Return how far a tag is from upright [rad]: its axes x and z, (3,) in `base`, are horizontal if it is."""
    return math.asin(min(max(abs(float(x_axis[2])), abs(float(z_axis[2]))), 1.0))


def _standing(poses: Sequence[TagPose], base_from_cam: FloatArray) -> TagPose | None:
    """Return the upright pose that the image clearly prefers; None for none."""
    upright = [p for p in poses if lean(*(base_from_cam @ p.rotation[:, [0, 2]]).T) <= LARGEST_LEAN]
    if not upright:
        return None
    first = upright[0]
    clear = all(p is first or p.error >= DEFAULT_TAGS.smallest_ratio * first.error for p in poses)
    return first if clear else None


def _observed(tag_id: int, pose: TagPose, turn: FloatArray, place: FloatArray) -> TagObservation:
    centre, along = turn @ pose.centre + place, turn @ pose.rotation[:, 0]
    heading, far = math.atan2(along[1], along[0]), float(np.linalg.norm(pose.centre))
    return TagObservation(tag_id, float(centre[0]), float(centre[1]), heading, far)
