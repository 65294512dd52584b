"""One topic that a node listens to: a connection and a thread for each publisher."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterable

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.calls import TIMEOUT, Caller
from fsm_calib.robots.ros1.messages import MessageType
from fsm_calib.robots.ros1.wire import Closed, pack_header, read_block, unpack_header

Listener = Callable[[bytes], None]
PAUSES = (0.1, 0.3, 1.0, 3.0, 10.0)
"""Pauses after which a publisher that did not answer is asked again [s]: a loaded machine, a weak network."""


class _OtherTypeError(LinkLost):
    """The publisher's messages are of another type: asking again changes nothing."""


class Subscriber:
    """Receives messages as bytes and hands them on, in threads of its own.

    Parameters
    ----------
    node : str
        Our own name.
    topic : str
        The topic's full name.
    kind : MessageType
        Of its messages.
    listener : callable
        Gets the bytes of each message.
    lost : callable or None
        Is told when a publisher's connection ended.
    """

    def __init__(
        self,
        node: str,
        topic: str,
        kind: MessageType,
        listener: Listener,
        lost: Callable[[], None] | None = None,
    ) -> None:
        self.topic, self.kind = topic, kind
        self._node, self._listener, self._lost = node, listener, lost
        self._lock = threading.Lock()
        self._links: dict[str, socket.socket | None] = {}
        self._ended = threading.Event()
        self.refused = ""

    @property
    def connected(self) -> int:
        """How many publishers are connected."""
        with self._lock:
            return sum(link is not None for link in self._links.values())

    def update(self, publishers: Iterable[str]) -> None:
        """Connect to the publishers that are new."""
        with self._lock:
            new = [] if self._ended.is_set() else [uri for uri in publishers if uri not in self._links]
            self._links.update(dict.fromkeys(new))
        for uri in new:
            threading.Thread(target=self._listen, args=(uri,), daemon=True, name=self.topic).start()

    def _listen(self, uri: str) -> None:
        """Receive from one publisher until it ends."""
        try:
            link = self._reach(uri)
            while True:
                self._listener(read_block(link))
        except (OSError, Closed, LinkLost):
            pass  # an end as good as any: the listener is told below
        finally:
            with self._lock:
                gone = self._links.pop(uri, None)
            if gone is not None:
                gone.close()
                if not self._ended.is_set() and self._lost is not None:
                    self._lost()

    def _reach(self, uri: str) -> socket.socket:
        """Return a connection to a publisher; one that does not answer at once is asked again."""
        for pause in PAUSES:
            try:
                return self._connect(uri)
            except _OtherTypeError as error:
                self.refused = str(error)
                raise
            except (OSError, Closed, LinkLost):
                if self._ended.wait(pause):
                    raise
        return self._connect(uri)

    def _connect(self, uri: str) -> socket.socket:
        """Return a connection to a publisher that has accepted us."""
        protocol = Caller(uri, "a publisher").call("requestTopic", self._node, self.topic, [["TCPROS"]])
        link = socket.create_connection((protocol[1], int(protocol[2])), timeout=TIMEOUT)
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        ours = {"callerid": self._node, "topic": self.topic, "type": self.kind.name, "md5sum": self.kind.md5}
        link.sendall(pack_header(ours | {"tcp_nodelay": "1"}))
        theirs = unpack_header(read_block(link))
        if "error" in theirs or theirs.get("md5sum") not in (self.kind.md5, "*"):
            link.close()
            raise _OtherTypeError(
                f"{self.topic}: another type of messages ({theirs.get('error', theirs.get('type'))})"
            )
        link.settimeout(None)
        with self._lock:
            if self._ended.is_set():
                link.close()
                raise Closed
            self._links[uri] = link
        return link

    def close(self) -> None:
        """End every connection."""
        self._ended.set()
        with self._lock:
            for link in self._links.values():
                if link is not None:
                    link.shutdown(socket.SHUT_RDWR)
