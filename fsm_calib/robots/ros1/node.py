"""A ROS 1 node: publishes, listens, offers and calls services, sets parameters."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable
from urllib.parse import urlsplit

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.calls import TIMEOUT, Caller, CallServer, address_towards
from fsm_calib.robots.ros1.messages import ServiceType, message_type
from fsm_calib.robots.ros1.node_api import NodeApi
from fsm_calib.robots.ros1.publisher import Publisher
from fsm_calib.robots.ros1.subscriber import Listener, Subscriber
from fsm_calib.robots.ros1.wire import Closed, block, pack_header, read_block, read_exactly, unpack_header

Service = Callable[[bytes], bytes]
"""Takes a request's bytes and returns the answer's; `LinkLost` becomes a refusal."""


class Node:
    """A node, from `register` to `close`.

    Parameters
    ----------
    name : str
        Its full name, for instance ``/duckie/fsm_calib``.
    master : str
        The master's URL.
    host : str or None
        Our address as others reach it; by default ``ROS_IP``, or this machine's address on the way to the master.

    Raises
    ------
    LinkLost
        The master does not answer.
    """

    def __init__(self, name: str, master: str, host: str | None = None) -> None:
        self.name = name
        self.master = Caller(master, "the ROS master")
        self.host = host or os.environ.get("ROS_IP") or address_towards(master)
        self.publishers: dict[str, Publisher] = {}
        self.subscribers: dict[str, Subscriber] = {}
        self._services: dict[str, tuple[ServiceType, Service]] = {}
        self._data = socket.create_server((self.host, 0), backlog=32)
        self._server = CallServer(self.host, 0, NodeApi(self))
        self.uri = f"http://{self.host}:{self._server.port}/"
        self._closed = False
        threading.Thread(target=self._accept, daemon=True, name="tcpros").start()
        try:
            self.master.call("getPid", name)
        except LinkLost:
            self.close()
            raise

    @property
    def data_port(self) -> int:
        """Where messages and services are fetched."""
        return int(self._data.getsockname()[1])

    def publish(self, topic: str, kind: str, *, latch: bool = False) -> Publisher:
        """Begin to publish a topic."""
        publisher = Publisher(topic, message_type(kind), latch)
        self.publishers[topic] = publisher
        self.master.call("registerPublisher", self.name, topic, kind, self.uri)
        return publisher

    def subscribe(
        self, topic: str, kind: str, listener: Listener, lost: Callable[[], None] | None = None
    ) -> Subscriber:
        """Begin to listen to a topic; `listener` runs in a thread for each publisher."""
        subscriber = Subscriber(self.name, topic, message_type(kind), listener, lost)
        self.subscribers[topic] = subscriber
        subscriber.update(self.master.call("registerSubscriber", self.name, topic, kind, self.uri))
        return subscriber

    def offer(self, name: str, kind: ServiceType, service: Service) -> None:
        """Offer a service."""
        self._services[name] = (kind, service)
        uri = f"rosrpc://{self.host}:{self.data_port}"
        self.master.call("registerService", self.name, name, uri, self.uri)

    def call_service(self, name: str, kind: ServiceType, request: bytes) -> bytes:
        """Call a service and return its answer's bytes.

        Raises
        ------
        LinkLost
            Nobody offers it, or it refuses.
        """
        where = urlsplit(self.master.call("lookupService", self.name, name))
        try:
            with socket.create_connection((where.hostname, where.port), timeout=TIMEOUT) as link:
                link.sendall(pack_header({"callerid": self.name, "service": name, "md5sum": kind.md5}))
                answer = unpack_header(read_block(link))
                if "error" in answer:
                    raise LinkLost(f"the service {name} refuses: {answer['error']}")
                link.sendall(block(request))
                good, body = read_exactly(link, 1), read_block(link)
        except (OSError, Closed) as error:
            raise LinkLost(f"the service {name} does not answer ({error})") from error
        if good != b"\x01":
            raise LinkLost(f"the service {name} failed: {body.decode(errors='replace')}")
        return body

    def is_offered(self, name: str) -> bool:
        """Tell whether any node offers a service."""
        _, _, services = self.master.call("getSystemState", self.name)
        return any(offered == name for offered, _ in services)

    def publishers_of(self, topic: str) -> tuple[str, ...]:
        """Return the names of the nodes that publish a topic, as the master knows them."""
        published, _, _ = self.master.call("getSystemState", self.name)
        return tuple(name for where, names in published if where == topic for name in names)

    def is_alive(self, name: str) -> bool:
        """Tell whether a node answers: the master keeps the names of those that were killed."""
        try:
            Caller(self.master.call("lookupNode", self.name, name), name).call("getPid", self.name)
        except LinkLost:
            return False
        return True

    def _accept(self) -> None:
        """Take connections until the node is closed."""
        while True:
            try:
                link, _ = self._data.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(link,), daemon=True, name="tcpros").start()

    def _serve(self, link: socket.socket) -> None:
        """Answer one connection: a subscriber, or a service call."""
        try:
            link.settimeout(TIMEOUT)
            theirs = unpack_header(read_block(link))
            if "service" in theirs:
                self._answer(link, theirs)
            else:
                self._feed(link, theirs)
        except (OSError, Closed, LinkLost):
            link.close()

    def _feed(self, link: socket.socket, theirs: dict[str, str]) -> None:
        """Hand a subscriber to the publisher of its topic, and wait for its end."""
        publisher = self.publishers.get(theirs.get("topic", ""))
        if publisher is None or theirs.get("md5sum") not in (publisher.kind.md5, "*"):
            link.sendall(
                pack_header({"error": f"{theirs.get('topic')} is not published here with that type"})
            )
            link.close()
            return
        kind = publisher.kind
        ours = {"callerid": self.name, "type": kind.name, "md5sum": kind.md5, "topic": publisher.topic}
        extra = {"message_definition": kind.definition, "latching": "1" if publisher.latch else "0"}
        publisher.take(theirs.get("callerid", "?"), link, pack_header(ours | extra))

    def _answer(self, link: socket.socket, theirs: dict[str, str]) -> None:
        """Answer calls of one service over one connection."""
        kind, service = self._services.get(theirs["service"], (None, None))
        if kind is None or service is None or theirs.get("md5sum") not in (kind.md5, "*"):
            link.sendall(pack_header({"error": f"{theirs['service']} is not offered here with that type"}))
            link.close()
            return
        link.sendall(pack_header({"callerid": self.name, "type": kind.name, "md5sum": kind.md5}))
        if theirs.get("probe") == "1":
            link.close()
            return
        while True:
            request = read_block(link)
            try:
                link.sendall(b"\x01" + block(service(request)))
            except LinkLost as error:
                link.sendall(b"\x00" + block(str(error).encode()))
            if theirs.get("persistent") != "1":
                link.close()
                return

    def close(self) -> None:
        """Tell the master that the node ends, and end its connections; may be called twice."""
        if self._closed:
            return
        self._closed = True
        try:
            for topic in self.publishers:
                self.master.call("unregisterPublisher", self.name, topic, self.uri)
            for topic in self.subscribers:
                self.master.call("unregisterSubscriber", self.name, topic, self.uri)
            for name in self._services:
                uri = f"rosrpc://{self.host}:{self.data_port}"
                self.master.call("unregisterService", self.name, name, uri)
        except LinkLost:
            pass  # the master is gone: nobody is left to tell
        for subscriber in self.subscribers.values():
            subscriber.close()
        for publisher in self.publishers.values():
            publisher.close()
        self._server.close()
        self._data.close()
