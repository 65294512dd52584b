"""Lockstep with a served robot: its time passes only when it is asked to, and waits for every command on its way.

The question, on ``fsm_calib/step``: ``{"client": name, "number": n, "until": time, "commands": count, "look": bool}``.
The robot waits until it has received `count` commands, runs to `until`, and answers on ``fsm_calib/stepped``:
``{"client", "number", "time", "step", "frame": number of the last frame sent, "taken": count, "executed": count}``: how
many commands it has taken, and applied. Frames are drawn only while somebody looks. A client that asks for the first
time, with no command sent, is the one that is served from then on: what another asked before and still waits is
dropped, and a client leaves answers aside that are not its own.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from typing import Any

from fsm_calib.errors import LinkLost

ANSWER = 60.0
"""Longest wait for a step [s]: a robot that draws many frames on a loaded machine."""


class Stepper:
    """Asks a served robot to let its time pass.

    Parameters
    ----------
    ask : callable
        Sends a question to the robot; its answers come to `hear`.
    """

    def __init__(self, ask: Callable[[str], None]) -> None:
        self._changed = threading.Condition()
        self.said: dict[str, Any] = {"time": 0.0, "step": 0.002, "frame": -1, "taken": 0, "executed": 0}
        self._client, self._number, self._heard = f"{os.getpid()}-{id(self)}", 0, 0
        self._ask = ask

    def hear(self, text: str) -> None:
        """Take an answer; one to another client's question is left aside."""
        said = json.loads(text)
        with self._changed:
            if (said["client"], said["number"]) == (self._client, self._number):
                self.said, self._heard = said, self._number
                self._changed.notify_all()

    def step(self, until: float, commands: int, look: bool) -> float:
        """Let the time pass until `until` [s], after that many commands; return the time then.

        Raises
        ------
        LinkLost
            No answer.
        """
        with self._changed:
            self._number += 1
        question = {"client": self._client, "number": self._number}
        self._ask(json.dumps(question | {"until": until, "commands": commands, "look": look}))
        with self._changed:
            if not self._changed.wait_for(lambda: self._heard == self._number, ANSWER):
                raise LinkLost(f"the served robot did not step to {until:g} s within {ANSWER:g} s")
            return float(self.said["time"])
