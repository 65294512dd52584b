"""A connection to a DTPS switchboard: the library's event loop in a thread of its own, behind plain calls."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import threading
from collections.abc import Callable, Coroutine
from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.dtps.library import load, message

PATIENCE = 10.0
"""Longest wait for the switchboard when a connection is made [s]."""
SEND = 1.0
"""Longest wait for a message to be taken, where a robot waits for it [s]."""
SERVED_SEND = 60.0
"""The same of a served robot, and of its client in lockstep [s]: a loaded machine only takes longer."""
WAITING = 1000
"""Messages of a topic that may wait for their listener [1]: the library drops the oldest of more, by itself at 10."""
CURE = "Check that the robot is on and that both are in one network; its switchboard may listen on 11511 or 11911."
OWN = "create:"
"""Before the URL of a switchboard that is made here."""
OWN_CURE = "Give another --port, or end what listens there."

Send = Callable[[Any], None]
"""Publishes one message."""


class DtpsLink:
    """One switchboard, and the topics below a vehicle's name.

    Parameters
    ----------
    url : str
        The switchboard's; ``create:`` before it makes one.
    vehicle : str
        What topics begin with.
    send_timeout : float
        Longest wait for a message to be taken [s].

    Raises
    ------
    InputError
        The library is not installed.
    LinkLost
        The switchboard does not answer.
    """

    def __init__(self, url: str, vehicle: str, send_timeout: float = SEND) -> None:
        dtps = load("dtps")
        self._url, self._send_timeout = url.removeprefix(OWN), send_timeout
        self._cure = OWN_CURE if url.startswith(OWN) else CURE
        self._posted: list[concurrent.futures.Future[None]] = []
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True, name="dtps")
        self._thread.start()
        self._closed = False
        try:
            self._top = self.do(dtps.context("calibration", urls=[url]), PATIENCE)
        except LinkLost:
            self._end_loop()
            raise
        self._root = self._top / vehicle

    def do(self, work: Coroutine[Any, Any, Any], timeout: float) -> Any:
        """Return what the library's coroutine returns.

        Raises
        ------
        LinkLost
            It fails, or does not end within `timeout` [s].
        """
        future = asyncio.run_coroutine_threadsafe(work, self._loop)
        try:
            return future.result(timeout)
        except Exception as error:  # the library raises bare ones; whatever it says, the link is of no use
            future.cancel()
            raise LinkLost(self._problem(error, timeout), cure=self._cure) from error

    def _problem(self, error: BaseException, timeout: float) -> str:
        """Return what an error says of the link."""
        if isinstance(error, TimeoutError):
            return f"{self._url} did not answer within {timeout:g} s"
        return f"{self._url}: {str(error) or type(error).__name__}"

    def exists(self, topic: str) -> bool:
        """Tell whether a topic is there.

        Raises
        ------
        LinkLost
            The switchboard does not answer.
        """
        return bool(self.do((self._root / topic).exists(), PATIENCE))

    def create(self, topic: str, length: int) -> None:
        """Create a topic that keeps `length` messages."""
        bounds = load("dtps_http").Bounds.max_length(length)
        self.do((self._root / topic).queue_create(bounds=bounds), PATIENCE)

    def subscribe(self, topic: str, kind: str, listener: Callable[[Any], None]) -> None:
        """Hand every message of a topic to `listener`, in the library's thread."""
        decode = message(kind).from_rawdata

        async def hear(raw: Any) -> None:
            listener(decode(raw))

        self.do((self._root / topic).subscribe(hear, queue_size=WAITING), PATIENCE)

    def publisher(self, topic: str) -> Send:
        """Return what publishes on a topic and waits until the message was taken; it raises `LinkLost`."""
        publisher = self.do((self._root / topic).publisher(), PATIENCE)

        def send(item: Any) -> None:
            self.do(publisher.publish(item.to_rawdata()), self._send_timeout)

        return send

    def poster(self, topic: str, lost: Callable[[str], None]) -> Send:
        """Return what publishes on a topic without waiting; `lost` hears why a message was not taken in time.

        Messages keep their order, and those on their way have left when the link is closed.
        """
        publisher, timeout = self.do((self._root / topic).publisher(), PATIENCE), self._send_timeout

        def settled(posted: concurrent.futures.Future[None]) -> None:
            error = None if posted.cancelled() else posted.exception()
            if error is not None:
                lost(self._problem(error, timeout))

        def post(item: Any) -> None:
            work = asyncio.wait_for(publisher.publish(item.to_rawdata()), timeout)
            posted = asyncio.run_coroutine_threadsafe(work, self._loop)
            self._posted = [earlier for earlier in self._posted if not earlier.done()] + [posted]
            posted.add_done_callback(settled)

        return post

    def close(self) -> None:
        """End the connection when what was posted has left; may be called twice."""
        if self._closed:
            return
        self._closed = True
        concurrent.futures.wait(self._posted, self._send_timeout)
        with contextlib.suppress(LinkLost):  # nobody may be left at the other end
            self.do(self._top.aclose(), PATIENCE)
        self._end_loop()

    def _end_loop(self) -> None:
        """End the library's thread, and before it whatever the library left running."""
        rest = asyncio.run_coroutine_threadsafe(_end_others(), self._loop)
        with contextlib.suppress(concurrent.futures.TimeoutError):
            rest.result(PATIENCE)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE)


async def _end_others() -> None:
    """Cancel every other task of the loop and wait for its end: one that is dropped as it is warns, or crashes."""
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    if others:
        await asyncio.wait(others, timeout=SEND)
