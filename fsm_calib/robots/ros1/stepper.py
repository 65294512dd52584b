"""Lockstep with a served robot: its time passes only when it is asked to, and waits for every command on its way.

The question, on ``fsm_calib/step``: ``{"until": time, "commands": count, "look": bool}``. The robot waits until it has
received `count` commands, runs to `until`, and answers on ``fsm_calib/stepped``: ``{"time", "step", "frame": number of
the last frame sent, "executed": count}``. Frames are drawn only while somebody looks.
"""

from __future__ import annotations

import json
import threading
import time
from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.messages import TEXT, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.topics import Topics

ANSWER = 60.0
"""Longest wait for a step [s]: a robot that draws many frames on a loaded machine."""


class Stepper:
    """Asks a served robot to let its time pass.

    Raises
    ------
    LinkLost
        Nobody serves steps.
    """

    def __init__(self, node: Node, topics: Topics) -> None:
        self._changed = threading.Condition()
        self.said: dict[str, Any] = {"time": 0.0, "step": 0.002, "frame": -1, "executed": 0}
        self._count = 0
        node.subscribe(topics.stepped, TEXT, self._hear)
        self._publisher = node.publish(topics.step, TEXT)
        end = time.monotonic() + ANSWER / 4
        while not (self._publisher.listeners and node.subscribers[topics.stepped].connected):
            if time.monotonic() > end:
                raise LinkLost(
                    "the robot serves no steps", cure="Start it with: fsm-calib robot serve --lockstep"
                )
            time.sleep(0.01)

    def _hear(self, body: bytes) -> None:
        with self._changed:
            self.said = json.loads(message_type(TEXT).decode(body).data)
            self._count += 1
            self._changed.notify_all()

    def step(self, until: float, commands: int, look: bool) -> float:
        """Let the time pass until `until` [s], after that many commands; return the time then.

        Raises
        ------
        LinkLost
            No answer.
        """
        with self._changed:
            before = self._count
            question = {"until": until, "commands": commands, "look": look}
            self._publisher.publish(message_type(TEXT).make(data=json.dumps(question)))
            if not self._changed.wait_for(lambda: self._count > before, ANSWER):
                raise LinkLost(f"the served robot did not step to {until:g} s within {ANSWER:g} s")
            return float(self.said["time"])
