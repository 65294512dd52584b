"""A run's folder as one MCAP file; see `channels`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.watch.channels import Channels, library, nanoseconds
from fsm_calib.watch.follow import Follower


def write_mcap(directory: Path, path: Path) -> int:
    """Write the run in `directory` as the MCAP file `path`, which must not exist yet; return its number of messages.

    Channels: ``/camera`` (CompressedImage, kept frames), ``/tf`` (FrameTransform, `base` in `world` at every event),
    ``/area`` (SceneUpdate), ``/state`` (JSON), ``/log`` (Log).

    Raises
    ------
    InputError
        foxglove-sdk is not installed, the folder holds no run, or the file cannot be written.
    """
    foxglove = library("foxglove")
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
        sink = Channels(context)
        sink.area(follower.area().get("shapes", []))
        for time, write in sorted(
            [(float(event["time"]), _of_event(sink, event)) for event in events]
            + [(float(frame["time"]), _of_frame(sink, directory, frame)) for frame in follower.pictures()],
            key=lambda item: item[0],
        ):
            write(nanoseconds(time))
    return sink.written


def _of_event(sink: Channels, event: dict[str, Any]) -> Callable[[int], None]:
    return lambda now: sink.event(event, now)


def _of_frame(sink: Channels, directory: Path, frame: dict[str, Any]) -> Callable[[int], None]:
    return lambda now: sink.frame(directory / str(frame["file"]), now)
