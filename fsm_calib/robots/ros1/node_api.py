"""What the master and other nodes may ask a node (ROS/Slave_API); names are the protocol's."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fsm_calib.robots.ros1.node import Node


class NodeApi:
    """The node's XML-RPC interface: every method returns [code, message, value], code 1 for yes."""

    def __init__(self, node: Node) -> None:
        self._node = node

    def requestTopic(self, caller: str, topic: str, protocols: list[Any]) -> list[Any]:
        """Tell a subscriber where to fetch a topic."""
        if topic not in self._node.publishers:
            return [0, f"{topic} is not published here", 0]
        return [1, "", ["TCPROS", self._node.host, self._node.data_port]]

    def publisherUpdate(self, caller: str, topic: str, publishers: list[str]) -> list[Any]:
        """Hear who publishes a topic now."""
        subscriber = self._node.subscribers.get(topic)
        if subscriber is not None:
            subscriber.update(publishers)
        return [1, "", 0]

    def paramUpdate(self, caller: str, key: str, value: Any) -> list[Any]:
        """Hear that a parameter changed; ours are asked for when they are needed."""
        return [1, "", 0]

    def getPid(self, caller: str) -> list[Any]:
        """Return the process's number."""
        return [1, "", os.getpid()]

    def getMasterUri(self, caller: str) -> list[Any]:
        """Return the master's address."""
        return [1, "", self._node.master.url]

    def getBusInfo(self, caller: str) -> list[Any]:
        """Return the connections."""
        rows = [
            [number, name, "o", "TCPROS", topic, True]
            for topic, publisher in self._node.publishers.items()
            for number, name in enumerate(publisher.listeners)
        ]
        return [1, "", rows]

    def getBusStats(self, caller: str) -> list[Any]:
        """Return no statistics."""
        return [1, "", [[], [], []]]

    def getSubscriptions(self, caller: str) -> list[Any]:
        """Return the topics that the node listens to."""
        return [1, "", [[topic, item.kind.name] for topic, item in self._node.subscribers.items()]]

    def getPublications(self, caller: str) -> list[Any]:
        """Return the topics that the node publishes."""
        return [1, "", [[topic, item.kind.name] for topic, item in self._node.publishers.items()]]

    def shutdown(self, caller: str, reason: str = "") -> list[Any]:
        """Decline to end: the run decides when."""
        return [1, "", 0]
