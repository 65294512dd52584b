"""A small ROS master, for a served robot where no other master runs: a Duckiebot brings its own, too.

It keeps who publishes, listens and offers what, and the parameters, in memory (ROS/Master_API, ROS/Parameter
Server API). Without: parameter subscriptions (none here uses them) and the log topic.
"""

from __future__ import annotations

import os
import threading
from collections import defaultdict
from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.calls import Caller, CallServer

Answer = list[Any]
Table = defaultdict[str, dict[str, str]]
"""By topic or service: names of nodes and their addresses."""


class Master:
    """A master that listens from its making on; `url` tells where.

    Parameters
    ----------
    host, port : str, int
        Where to listen; port 0 takes a free one.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        self._server = CallServer(host, port, MasterApi())
        self.url = f"http://{host}:{self._server.port}/"

    def close(self) -> None:
        """End it."""
        self._server.close()


class MasterApi:
    """The master's calls; names are the protocol's. Each returns [code, message, value], code 1 for yes."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._publishers: Table = defaultdict(dict)
        self._subscribers: Table = defaultdict(dict)
        self._services: Table = defaultdict(dict)
        self._types: dict[str, str] = {}
        self._uris: dict[str, str] = {}
        self._parameters: dict[str, Any] = {}

    def registerPublisher(self, caller: str, topic: str, kind: str, uri: str) -> Answer:
        """Take a publisher, and tell those who listen."""
        with self._lock:
            self._uris[caller] = uri
            self._types[topic] = kind
            self._publishers[topic][caller] = uri
            self._tell(topic)
            return [1, "", list(self._subscribers[topic].values())]

    def unregisterPublisher(self, caller: str, topic: str, uri: str) -> Answer:
        """Forget a publisher, and tell those who listen."""
        with self._lock:
            gone = self._publishers[topic].pop(caller, None)
            self._tell(topic)
            return [1, "", int(gone is not None)]

    def registerSubscriber(self, caller: str, topic: str, kind: str, uri: str) -> Answer:
        """Take a subscriber and tell it who publishes."""
        with self._lock:
            self._uris[caller] = uri
            self._types.setdefault(topic, kind)
            self._subscribers[topic][caller] = uri
            return [1, "", list(self._publishers[topic].values())]

    def unregisterSubscriber(self, caller: str, topic: str, uri: str) -> Answer:
        """Forget a subscriber."""
        with self._lock:
            return [1, "", int(self._subscribers[topic].pop(caller, None) is not None)]

    def registerService(self, caller: str, service: str, address: str, uri: str) -> Answer:
        """Take a service."""
        with self._lock:
            self._uris[caller] = uri
            self._services[service] = {caller: address}
            return [1, "", 1]

    def unregisterService(self, caller: str, service: str, address: str) -> Answer:
        """Forget a service."""
        with self._lock:
            return [1, "", int(self._services.pop(service, None) is not None)]

    def lookupService(self, caller: str, service: str) -> Answer:
        """Tell where a service is offered."""
        with self._lock:
            for address in self._services.get(service, {}).values():
                return [1, "", address]
            return [-1, f"no provider of {service}", ""]

    def lookupNode(self, caller: str, name: str) -> Answer:
        """Tell where a node listens."""
        with self._lock:
            uri = self._uris.get(name)
            return [1, "", uri] if uri else [-1, f"unknown node {name}", ""]

    def getSystemState(self, caller: str) -> Answer:
        """Return who publishes, listens and offers what."""
        with self._lock:
            tables = (self._publishers, self._subscribers, self._services)
            return [
                1,
                "",
                [[[key, list(names)] for key, names in table.items() if names] for table in tables],
            ]

    def getPublishedTopics(self, caller: str, below: str = "") -> Answer:
        """Return the topics that are published, with their types."""
        with self._lock:
            rows = [[topic, self._types[topic]] for topic, names in self._publishers.items() if names]
            return [1, "", [row for row in rows if row[0].startswith(below)]]

    def getTopicTypes(self, caller: str) -> Answer:
        """Return the types of all topics."""
        with self._lock:
            return [1, "", [[topic, kind] for topic, kind in self._types.items()]]

    def setParam(self, caller: str, key: str, value: Any) -> Answer:
        """Set a parameter."""
        with self._lock:
            self._parameters[_full(key)] = value
            return [1, "", 0]

    def getParam(self, caller: str, key: str) -> Answer:
        """Return a parameter."""
        with self._lock:
            known = _full(key) in self._parameters
            return [1, "", self._parameters[_full(key)]] if known else [-1, f"{key} is not set", 0]

    def hasParam(self, caller: str, key: str) -> Answer:
        """Tell whether a parameter is set."""
        with self._lock:
            return [1, _full(key), _full(key) in self._parameters]

    def deleteParam(self, caller: str, key: str) -> Answer:
        """Forget a parameter."""
        with self._lock:
            known = self._parameters.pop(_full(key), None) is not None
            return [1, "", 0] if known else [-1, f"{key} is not set", 0]

    def getParamNames(self, caller: str) -> Answer:
        """Return the names of all parameters."""
        with self._lock:
            return [1, "", sorted(self._parameters)]

    def searchParam(self, caller: str, key: str) -> Answer:
        """Return the full name of a parameter; only full names are known here."""
        return [1, "", _full(key)]

    def subscribeParam(self, caller: str, uri: str, key: str) -> Answer:
        """Return a parameter; its changes are not told."""
        with self._lock:
            return [1, "", self._parameters.get(_full(key), {})]

    def getPid(self, caller: str) -> Answer:
        """Return the process's number."""
        return [1, "", os.getpid()]

    def getUri(self, caller: str) -> Answer:
        """Decline: a node knows where it asks."""
        return [-1, "not known", ""]

    def _tell(self, topic: str) -> None:
        """Tell those who listen to a topic who publishes it now."""
        publishers = list(self._publishers[topic].values())
        for uri in self._subscribers[topic].values():
            threading.Thread(target=_update, args=(uri, topic, publishers), daemon=True).start()


def _full(key: str) -> str:
    """Return a parameter's full name."""
    return key if key.startswith("/") else f"/{key}"


def _update(uri: str, topic: str, publishers: list[str]) -> None:
    """Tell one node; one that is gone is no error."""
    try:
        Caller(uri, "a node").call("publisherUpdate", "/master", topic, publishers)
    except LinkLost:
        return
