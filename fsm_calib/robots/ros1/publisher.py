"""One topic that a node publishes: its connections, and the last message where it is latched."""

from __future__ import annotations

import socket
import threading
from typing import Any

from fsm_calib.robots.ros1.messages import MessageType
from fsm_calib.robots.ros1.wire import block

SEND_TIMEOUT = 1.0
"""A subscriber that takes nothing for this long is dropped [s]."""


class Publisher:
    """Sends messages to everybody who listens.

    Parameters
    ----------
    topic : str
        The topic's full name.
    kind : MessageType
        Of its messages.
    latch : bool
        Keep the last message for whoever comes later.
    """

    def __init__(self, topic: str, kind: MessageType, latch: bool) -> None:
        self.topic, self.kind, self.latch = topic, kind, latch
        self._links: list[tuple[str, socket.socket]] = []
        self._last: bytes | None = None
        self._lock = threading.Lock()
        self._count = 0

    @property
    def listeners(self) -> tuple[str, ...]:
        """Names of the nodes that listen."""
        with self._lock:
            return tuple(name for name, _ in self._links)

    @property
    def sent(self) -> int:
        """Messages published so far."""
        return self._count

    def take(self, name: str, link: socket.socket, greeting: bytes) -> None:
        """Add a subscriber's connection and greet it: what is published after the greeting reaches it."""
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        link.settimeout(SEND_TIMEOUT)
        with self._lock:
            link.sendall(greeting)
            self._links.append((name, link))
            if self.latch and self._last is not None:
                self._send(name, link, self._last)

    def drop(self, link: socket.socket) -> None:
        """Forget a connection that ended."""
        with self._lock:
            self._links = [item for item in self._links if item[1] is not link]

    def publish(self, message: Any) -> int:
        """Send a message; return how many nodes it went to."""
        body = block(self.kind.encode(message))
        with self._lock:
            self._last = body
            self._count += 1
            return sum(self._send(name, link, body) for name, link in list(self._links))

    def _send(self, name: str, link: socket.socket, body: bytes) -> bool:
        """Send to one subscriber; one that is gone or takes nothing is dropped."""
        try:
            link.sendall(body)
        except OSError:
            self._links.remove((name, link))
            link.close()
            return False
        return True

    def close(self) -> None:
        """End every connection."""
        with self._lock:
            for _, link in self._links:
                link.close()
            self._links.clear()
