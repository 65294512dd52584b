"""A run served live to Foxglove while it runs, or from its files when it has ended.

The server reads the run's files as the page does, so that a viewer, however slow, can neither slow a run nor stop it.
"""

from __future__ import annotations

from pathlib import Path
from threading import Event
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.watch.channels import Channels, library, nanoseconds
from fsm_calib.watch.follow import Follower

PORT = 8765
"""Where Foxglove looks for a server."""
EVERY = 0.1
"""Pause between two looks for what is new [s]."""


class LiveView:
    """A Foxglove server of one run; `step` sends what is new, `serve` does so until it is told to end.

    Parameters
    ----------
    directory : Path
        The run's folder.
    port : int
        Where it listens, on this machine only; 0 for a port that is free.

    Raises
    ------
    InputError
        foxglove-sdk is not installed, the folder is missing, or the port is taken.
    """

    def __init__(self, directory: Path, port: int = PORT) -> None:
        foxglove = library("foxglove", "--foxglove")
        self._follower = Follower(directory)
        self._context = context = foxglove.Context()  # channels close with the last name of their context
        self._channels = Channels(context)
        self._joined = Event()
        self._events = self._frames = 0
        try:
            self._server = foxglove.start_server(
                name=f"fsm-calib {directory.name}",
                port=port,
                context=context,
                server_listener=_Joined(self._joined),
            )
        except (OSError, RuntimeError) as error:
            raise InputError(
                f"port {port} cannot be served: {error}", where="--foxglove", cure="Give another port."
            ) from error

    @property
    def address(self) -> str:
        """What a viewer connects to."""
        return f"ws://127.0.0.1:{self._server.port}"

    def step(self) -> int:
        """Send what is new, and to a viewer that has just come the area and the present state; return how many events
        the run has.
        """
        events, frames = self._follower.read(), self._follower.pictures()
        if self._joined.is_set():
            self._joined.clear()
            self._channels.area(self._follower.area().get("shapes", []))
            self._events = min(self._events, max(len(events) - 1, 0))
            self._frames = min(self._frames, max(len(frames) - 1, 0))
        for event in events[self._events :]:
            self._channels.event(event, nanoseconds(float(event["time"])))
        for frame in frames[self._frames :]:
            path = self._follower.directory / str(frame["file"])
            self._channels.frame(path, nanoseconds(float(frame["time"])))
        self._events, self._frames = len(events), len(frames)
        return len(events)

    def serve(self, ended: Event) -> None:
        """Send what is new until `ended` is set."""
        while not ended.wait(EVERY):
            self.step()

    def close(self) -> None:
        """End the server."""
        self._server.stop()


class _Joined:
    """Notes that a viewer has subscribed (`foxglove.websocket.ServerListener`)."""

    def __init__(self, joined: Event) -> None:
        self._joined = joined

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """A viewer wants a channel: it has seen nothing of the run yet."""
        self._joined.set()

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """A viewer has left a channel."""
