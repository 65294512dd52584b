"""Poses from the camera images of a bag, one image at a time, so that a long bag needs no memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.perception.encoded import decode_image
from fsm_calib.recording.bag_reader import BagReader
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.duckietown_messages import typestore
from fsm_calib.recording.recording import Finding
from fsm_calib.recording.tag_poses import TagMap, poses_from_frames
from fsm_calib.types import CameraModel, Frame, LensModel

KINDS = ("CompressedImage", "CameraInfo")


def poses_from_bag_images(path: Path, tag_map: TagMap, start: float) -> tuple[PoseTrack | None, Finding]:
    """Return a pose for every image that shows a mapped tag, time [s] counted from `start` [s], and what was
    found.

    The camera comes from the bag's CameraInfo; images before the first one are not used.
    """
    camera: CameraModel | None = None
    images = 0
    tracks: list[PoseTrack] = []
    try:
        with BagReader([path], default_typestore=typestore()) as reader:
            wanted = [c for c in reader.connections if c.msgtype.split("/")[-1] in KINDS]
            for connection, stamp, raw in reader.messages(connections=wanted):
                message = reader.deserialize(raw, connection.msgtype)
                if connection.msgtype.endswith("CameraInfo"):
                    camera = camera or camera_of(message)
                    continue
                images += 1
                track = _pose_of(message, stamp, start, camera, tag_map)
                tracks += [] if track is None else [track]
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise InputError("the bag's images are damaged", where=f"{path}:1") from error
    sentence = f"{len(tracks)} poses from {images} images"
    if images and camera is None:
        sentence += ": the bag holds no CameraInfo"
    finding = Finding(
        "pose", "images", sentence, "dropped" if len(tracks) < images else "kept", images - len(tracks)
    )
    if not tracks:
        return None, finding
    columns = (
        np.concatenate([getattr(track, key) for track in tracks]) for key in ("time", "x", "y", "theta")
    )
    return PoseTrack(*columns), finding


def _pose_of(
    message: Any, stamp: int, start: float, camera: CameraModel | None, tag_map: TagMap
) -> PoseTrack | None:
    image = decode_image(message.data)
    if camera is None or image is None:
        return None
    header = message.header.stamp
    time = header.sec + header.nanosec * 1e-9 if header.sec or header.nanosec else stamp * 1e-9
    return poses_from_frames([Frame(image, time - start, 0)], camera, tag_map)


def camera_of(message: Any) -> CameraModel:
    """Return the camera of a CameraInfo of ROS 1 (fields K, D) or ROS 2 (k, d)."""
    matrix = message.K if hasattr(message, "K") else message.k
    distortion = np.asarray(message.D if hasattr(message, "D") else message.d, dtype=float)
    known = get_args(LensModel)
    model: LensModel = message.distortion_model if message.distortion_model in known else "plumb_bob"
    count = {"rational_polynomial": 8, "equidistant": 4}.get(model, 5)
    full = np.zeros(count)
    full[: min(count, len(distortion))] = distortion[:count]

    return CameraModel(np.asarray(matrix).reshape(3, 3), full, int(message.width), int(message.height), model)
