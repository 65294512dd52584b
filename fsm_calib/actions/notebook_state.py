"""Views, cameras and arrays as plain JSON values, exact to the last bit, and back: what a checkpoint is made of."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import astuple
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.information import ScanProgress, rebuild_scan
from fsm_calib.types import BoardView, CameraModel, TagObservation


@lru_cache(maxsize=1024)
def view_state(view: BoardView) -> dict[str, Any]:
    """Return a view as plain values; kept, because a checkpoint after every event asks again."""
    return {"corners": pack(view.corners_image), "board": view.board, "source": view.source}


def view_from(state: Mapping[str, Any]) -> BoardView:
    """Return the view that `view_state` wrote."""
    return BoardView(unpack(state["corners"]), state["board"], state["source"])


@lru_cache(maxsize=1024)
def tags_state(tags: tuple[TagObservation, ...]) -> dict[str, Any] | None:
    """Return measured markers as plain values, a row of numbers each; kept like `view_state`'s."""
    return pack(np.array([astuple(tag) for tag in tags], dtype=float))


def tags_from(state: Mapping[str, Any]) -> tuple[TagObservation, ...]:
    """Return the markers that `tags_state` wrote."""
    return tuple(TagObservation(int(number), *rest) for number, *rest in unpack(state).tolist())


@lru_cache(maxsize=4)
def progress_state(progress: ScanProgress | None) -> dict[str, Any] | None:
    """Return what the scan knows as plain values; kept like `view_state`'s."""
    if progress is None:
        return None
    return {
        "camera": camera_state(progress.camera),
        "information": pack(progress.information),
        "noise_px": progress.noise_px,
        "repeated": pack(progress.repeated),
        "views_per_board": list(progress.views_per_board),
        "rms_px": None if math.isnan(progress.rms_px) else progress.rms_px,
    }


def progress_from(state: Mapping[str, Any] | None) -> ScanProgress | None:
    """Return the progress that `progress_state` wrote."""
    if state is None:
        return None
    return rebuild_scan(
        _camera(state["camera"]),
        unpack(state["information"]),
        state["noise_px"],
        unpack(state["repeated"]),
        tuple(state["views_per_board"]),
        math.nan if state["rms_px"] is None else state["rms_px"],
    )


def camera_state(camera: CameraModel | None) -> dict[str, Any] | None:
    """Return a camera as plain values."""
    if camera is None:
        return None
    return {
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "width": camera.width,
        "height": camera.height,
        "model": camera.model,
    }


def camera_from(state: Mapping[str, Any] | None) -> CameraModel | None:
    """Return the camera that `camera_state` wrote."""
    return None if state is None else _camera(state)


def _camera(state: Mapping[str, Any]) -> CameraModel:
    matrix, distortion = np.array(state["matrix"]), np.array(state["distortion"])
    return CameraModel(matrix, distortion, state["width"], state["height"], state["model"])


def pack(array: NDArray | None) -> dict[str, Any] | None:
    """Return an array as text: exact, and a hundred times faster to write than numbers."""
    if array is None:
        return None
    text = base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
    return {"dtype": array.dtype.str, "shape": list(array.shape), "data": text}


def unpack(state: Mapping[str, Any] | None) -> Any:
    """Return the array that `pack` wrote."""
    if state is None:
        return None
    content = base64.b64decode(state["data"])
    return np.frombuffer(content, dtype=state["dtype"]).reshape(state["shape"]).copy()
