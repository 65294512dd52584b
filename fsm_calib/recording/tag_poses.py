"""Poses of the robot from tags with known places: detections of a bag, or images.

A tag's pose in the camera, with the camera's place on the robot, gives the tag's centre and heading on the
floor relative to the robot; with the tag's place in the world follows the robot's,

    world_T_base = world_T_tag (base_T_tag)^-1.

Several tags in one frame are combined by least squares in the plane with weights 1 / distance^2 (a tag's pose
error grows with its distance): heading by the mean direction, then the position.

A tag may lie on the floor or stand upright. Its heading is that of its x axis, which runs along its lower edge to the
right of who reads it; a standing tag may be given by where it faces in its place, a quarter turn less.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.perception.tags import find_tags
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Finding
from fsm_calib.recording.standing_tags import TAG_SIZE, observe_both
from fsm_calib.recording.yaml_places import PlacedYaml, read_yaml
from fsm_calib.types import CameraModel, CameraMount, Frame, Pose2, TagObservation


@dataclass(frozen=True)
class TagMap:
    """Places of tags, x axis and centre, in the world; where the camera sits on the robot; side of a tag [m]."""

    tags: Mapping[int, Pose2]
    mount: CameraMount = field(default_factory=CameraMount)
    size: float = TAG_SIZE


@dataclass(frozen=True, slots=True)
class TagRow:
    """One detection: time [s], tag number, its observation on the floor relative to a camera not yet placed.

    translation (x right, y down, z forward) [m] and quaternion (x, y, z, w) of the tag in the camera.
    """

    time: float
    tag_id: int
    translation: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


def read_tag_map(path: Path) -> TagMap:
    """Read a YAML file ``tags: {NUMBER: {x, y, theta}}``, or ``{x, y, faces}`` of a standing tag, with an optional
    ``size`` and ``mount: {forward, left, height, ...}``.
    """
    placed = read_yaml(path)
    data = placed.data if isinstance(placed.data, dict) else {}
    try:
        tags = {int(key): _place(value) for key, value in data["tags"].items()}
        mount = CameraMount(**{key: float(value) for key, value in (data.get("mount") or {}).items()})
        size = float(data.get("size", TAG_SIZE))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise _no_map(placed) from error
    numbers = [size, *(n for tag in tags.values() for n in (tag.x, tag.y, tag.theta))]
    if not np.isfinite(numbers).all() or size <= 0.0:
        raise _no_map(placed)
    return TagMap(tags, mount, size)


def _place(value: Mapping[str, Any]) -> Pose2:
    """Return a tag's centre and the heading of its x axis; a print that faces a reader has it to the left of that."""
    theta = float(value["theta"]) if "theta" in value else float(value["faces"]) + math.pi / 2.0
    return Pose2(float(value["x"]), float(value["y"]), theta)


def _no_map(placed: PlacedYaml) -> InputError:
    return InputError(
        "not a map of tags",
        where=placed.place(("tags",)),
        cure="Write: tags: {300: {x: 0.0, y: 0.0, theta: 0.0}}; a tag that stands may have faces for theta.",
    )


def rows_of_message(time: float, message: Any) -> list[TagRow]:
    """Return the detections of any of the three messages that are called AprilTagDetectionArray.

    Current duckietown_msgs: `transform`, `tag_id`; old duckietown_msgs: `id`, `pose`; apriltags2_ros: `id[]`,
    `pose.pose.pose`. They are told apart by their fields.
    """
    rows = []
    for detection in message.detections:
        if hasattr(detection, "transform"):
            number, place, turn = (
                detection.tag_id,
                detection.transform.translation,
                detection.transform.rotation,
            )
        else:
            pose = detection.pose.pose
            pose = getattr(pose, "pose", pose)
            place, turn = pose.position, pose.orientation
            number = detection.id[0] if np.ndim(detection.id) else detection.id
        rows.append(TagRow(time, int(number), (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)))
    return rows


def observation(row: TagRow, mount: CameraMount) -> TagObservation:
    """Return the tag on the floor relative to the robot.

    The heading is that of the tag's x axis, which all three messages let point to the tag's right.
    """
    turn, place = base_from_camera(mount)
    centre = turn @ np.array(row.translation) + place
    x, y, z, w = np.array(row.quaternion) / max(float(np.linalg.norm(row.quaternion)), 1e-12)
    axis = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
    along = turn @ axis
    return TagObservation(
        row.tag_id,
        float(centre[0]),
        float(centre[1]),
        math.atan2(along[1], along[0]),
        float(np.linalg.norm(row.translation)),
    )


def poses_from_tags(rows: Sequence[TagRow], tag_map: TagMap) -> tuple[PoseTrack | None, Finding]:
    """Return the robot's pose at every time at which a mapped tag was seen, and what was left out."""
    by_time: dict[float, list[TagObservation]] = {}
    unknown = 0
    for row in rows:
        if row.tag_id in tag_map.tags:
            by_time.setdefault(row.time, []).append(observation(row, tag_map.mount))
        else:
            unknown += 1
    poses = [(time, pose_from_observations(seen, tag_map.tags)) for time, seen in sorted(by_time.items())]
    sentence = f"{len(poses)} poses from tags; {unknown} of {len(rows)} detections are of tags not on the map"
    finding = Finding("pose", "tags", sentence, "dropped" if unknown else "kept", unknown)
    return (_track(poses) if poses else None), finding


def pose_from_observations(seen: Sequence[TagObservation], tags: Mapping[int, Pose2]) -> Pose2:
    """Return the robot's pose from one frame's tags, all of them on the map; raise InputError for none."""
    known = [tag for tag in seen if tag.tag_id in tags]
    if not known:
        raise InputError("no tag of the frame is on the map")
    weight = np.array([max(tag.distance, 0.05) ** -2.0 for tag in known])
    heading = [tags[tag.tag_id].theta - tag.heading for tag in known]
    direction = complex(np.sum(weight * np.exp(1j * np.array(heading))))
    theta = math.atan2(direction.imag, direction.real)
    turn = complex(math.cos(theta), math.sin(theta))
    places = [complex(tags[tag.tag_id].x, tags[tag.tag_id].y) - turn * complex(tag.x, tag.y) for tag in known]
    place = complex(np.sum(weight * np.array(places)) / weight.sum())
    return Pose2(place.real, place.imag, theta)


def poses_from_frames(frames: Sequence[Frame], camera: CameraModel, tag_map: TagMap) -> PoseTrack | None:
    """Return the robot's pose in every image that shows a mapped tag; None where none does."""
    poses = []
    for frame in frames:
        seen = observe_both(find_tags(frame.image), camera, tag_map.mount, tag_map.size)
        known = [tag for tag in seen if tag.tag_id in tag_map.tags]
        if known:
            poses.append((frame.time, pose_from_observations(known, tag_map.tags)))
    return _track(poses) if poses else None


def _track(poses: Sequence[tuple[float, Pose2]]) -> PoseTrack:
    table = np.array([(time, pose.x, pose.y, pose.theta) for time, pose in poses])
    return PoseTrack(*table.T)
