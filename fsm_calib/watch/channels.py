"""A run as messages for Foxglove and other viewers: frames, transforms, area, state, log.

Times are the run's own, from 0. Needs the extra ``[viz]`` (foxglove-sdk).
"""

from __future__ import annotations

import importlib
import json
import math
from pathlib import Path
from typing import Any

from fsm_calib.errors import InputError

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


def library(name: str, where: str = "--mcap") -> Any:
    """Return a module of foxglove-sdk; `where` is the option that asks for it.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError("viewers are served by foxglove-sdk", where=where, cure=CURE) from error


def nanoseconds(time: float) -> int:
    """Return a run's time [s] as a log's [ns]."""
    return max(round(time * 1e9), 0)


class Channels:
    """The channels of one file or server: those of a `context` of foxglove-sdk."""

    def __init__(self, context: Any) -> None:
        foxglove, channels = library("foxglove"), library("foxglove.channels")
        schema = foxglove.Schema(
            name="fsm_calib.State", encoding="jsonschema", data=json.dumps(STATE_SCHEMA).encode()
        )
        self._messages = library("foxglove.messages")
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
