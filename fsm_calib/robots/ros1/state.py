"""What a run says of itself on the robot's network: its state as JSON, and Duckietown's mode, both latched."""

from __future__ import annotations

import json
import time
from typing import Any

from fsm_calib.robots.ros1.messages import MODE, TEXT, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.topics import Topics

COMPUTING = "scan/solving"
"""The state in which the robot stands and computes."""


class StateTeller:
    """Publishes ``fsm_calib/state`` (std_msgs/String, JSON) and ``fsm_calib/mode`` (duckietown_msgs/FSMState)."""

    def __init__(self, node: Node, topics: Topics) -> None:
        self._state = node.publish(topics.state, TEXT, latch=True)
        self._mode = node.publish(topics.mode, MODE, latch=True)
        self._seq = 0

    def tell(self, event: dict[str, Any]) -> None:
        """Publish an event."""
        self._seq += 1
        self._state.publish(message_type(TEXT).make(data=json.dumps(event)))
        mode = "CALIBRATING_CALC" if event["path"] == COMPUTING else "CALIBRATING"
        self._mode.publish(message_type(MODE).stamped(time.time(), self._seq, state=mode))
