"""A run's folder as one MCAP file for Foxglove and other viewers: frames, transforms, area, state, log.

Times are the run's own, from 0. Needs the extra ``[viz]`` (foxglove-sdk).
"""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.watch.follow import Follower

CURE = "pip install 'fsm-calib[viz]'"
STATE_SCHEMA = {
    "type": "object",
    "properties": {
        "time": {"type": "number"},
        "phase": {"type": "string"},
        "path": {"type": "string"},
        "dest": {"type": "string"},
        "trigger": {"type": "string"},
        "sentence": {"type": "string"},
        "wheel_ratio": {"type": "number"},
        "k_i": {"type": "number"},
    },
}
"""The channel ``/state``, one message an event; `FIGURES` where an event has them."""
THICKNESS = 0.01
"""Lines of the area's drawing [m]."""
KINDS = {"jpg": "jpeg", "jpeg": "jpeg", "png": "png"}
"""Formats of frames by the ends of their names."""


def write_mcap(directory: Path, path: Path) -> int:
    """Write the run in `directory` as the MCAP file `path`, which must not exist yet; return its number of messages.

    Channels: ``/camera`` (CompressedImage, kept frames), ``/tf`` (FrameTransform, `base` in `world` at every event),
    ``/area`` (SceneUpdate), ``/state`` (JSON), ``/log`` (Log).

    Raises
    ------
    InputError
        foxglove-sdk is not installed, the folder holds no run, or the file cannot be written.
    """
    foxglove, messages = _library("foxglove"), _library("foxglove.messages")
    follower = Follower(directory)
    events = follower.read()
    if not events:
        cure = "Give the --out folder of a run that has begun."
        raise InputError("holds no event of a run", where=str(directory), cure=cure)
    context = foxglove.Context()
    try:
        writer = foxglove.open_mcap(path, context=context)
    except (OSError, RuntimeError) as error:
        raise InputError(f"cannot be written: {error}", where=str(path), cure="Give a new file.") from error
    with writer:
        sink = _Sink(foxglove, messages, context)
        sink.area(follower.area().get("shapes", []))
        for time, write in sorted(
            [(float(event["time"]), _of_event(sink, event)) for event in events]
            + [(float(frame["time"]), _of_frame(sink, directory, frame)) for frame in follower.pictures()],
            key=lambda item: item[0],
        ):
            write(_nanoseconds(time))
    return sink.written


def _library(name: str) -> Any:
    """Return a module of foxglove-sdk.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError("an MCAP file needs foxglove-sdk", where="--mcap", cure=CURE) from error


def _of_event(sink: _Sink, event: dict[str, Any]) -> Callable[[int], None]:
    return lambda now: sink.event(event, now)


def _of_frame(sink: _Sink, directory: Path, frame: dict[str, Any]) -> Callable[[int], None]:
    return lambda now: sink.frame(directory / str(frame["file"]), now)


def _nanoseconds(time: float) -> int:
    return max(round(time * 1e9), 0)


class _Sink:
    """The channels of one file."""

    def __init__(self, foxglove: Any, messages: Any, context: Any) -> None:
        channels = _library("foxglove.channels")
        schema = foxglove.Schema(
            name="fsm_calib.State", encoding="jsonschema", data=json.dumps(STATE_SCHEMA).encode()
        )
        self._messages = messages
        self._state = foxglove.Channel("/state", schema=schema, message_encoding="json", context=context)
        self._camera = channels.CompressedImageChannel("/camera", context=context)
        self._tf = channels.FrameTransformChannel("/tf", context=context)
        self._area = channels.SceneUpdateChannel("/area", context=context)
        self._log = channels.LogChannel("/log", context=context)
        self.written = 0

    def _stamp(self, now: int) -> Any:
        seconds, rest = divmod(now, 1_000_000_000)
        return self._messages.Timestamp(sec=seconds, nsec=rest)

    def event(self, event: dict[str, Any], now: int) -> None:
        """Write an event's state, sentence and pose."""
        told = {name: event[name] for name in STATE_SCHEMA["properties"] if event.get(name) is not None}
        self._state.log(json.dumps(told).encode(), log_time=now)
        self._log.log(self._line(event, now), log_time=now)
        self._tf.log(self._transform(event["pose"], now), log_time=now)
        self.written += 3

    def _line(self, event: dict[str, Any], now: int) -> Any:
        has_failed = str(event.get("dest")).startswith(("failed", "aborted"))
        levels = self._messages.LogLevel
        return self._messages.Log(
            timestamp=self._stamp(now),
            level=levels.Error if has_failed else levels.Info,
            message=f"{event.get('path')} -> {event.get('dest')}: {event.get('sentence') or ''}",
            name=str(event.get("phase")),
        )

    def _transform(self, pose: list[float], now: int) -> Any:
        """Return `base` in `world` from [x, y, theta] [m, m, rad]."""
        x, y, theta = pose
        return self._messages.FrameTransform(
            timestamp=self._stamp(now),
            parent_frame_id="world",
            child_frame_id="base",
            translation=self._messages.Vector3(x=x, y=y, z=0.0),
            rotation=self._messages.Quaternion(
                x=0.0, y=0.0, z=math.sin(theta / 2.0), w=math.cos(theta / 2.0)
            ),
        )

    def frame(self, path: Path, now: int) -> None:
        """Write a kept frame; one whose file is gone is left out."""
        kind = KINDS.get(path.suffix.lstrip("."), "")
        if not kind or not path.exists():
            return
        image = self._messages.CompressedImage(
            timestamp=self._stamp(now), frame_id="camera", data=path.read_bytes(), format=kind
        )
        self._camera.log(image, log_time=now)
        self.written += 1

    def area(self, shapes: list[dict[str, Any]]) -> None:
        """Write the outlines of the area, as lines on the floor."""
        lines = [self._outline(shape["outline"]) for shape in shapes]
        entity = self._messages.SceneEntity(
            id="area", frame_id="world", timestamp=self._stamp(0), lines=lines
        )
        self._area.log(self._messages.SceneUpdate(entities=[entity]), log_time=0)
        self.written += 1

    def _outline(self, points: list[list[float]]) -> Any:
        types = self._messages
        return types.LinePrimitive(
            type=types.LinePrimitiveLineType.LineLoop,
            thickness=THICKNESS,
            scale_invariant=False,
            points=[types.Point3(x=x, y=y, z=0.0) for x, y in points],
            color=types.Color(r=0.4, g=0.4, b=0.4, a=1.0),
        )
