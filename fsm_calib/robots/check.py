"""An owner's first test of a robot on a network: does what this project needs work, and how fast?

The robot turns its wheels a little, for less than a second at a time. Every figure comes from the robot's own messages.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import RobotLost
from fsm_calib.robots.camera import Decode
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.subject import open_subject
from fsm_calib.types import STOP, WheelCommand

WATCH = 3.0
"""How long the camera is watched at rest [s]."""
PUSH, PUSH_SECONDS = 0.3, 0.3
"""Command [1] and duration [s] of a push that is seen in the picture: some 10 degrees."""
SWEEP = (0.02, 0.04, 0.06, 0.08, 0.10, 0.14, 0.18, 0.22, 0.26, 0.30)
"""Commands of the sweep [1]; each is held for `PUSH_SECONDS`."""
MOVED = 4.0
"""The picture has changed when it differs by so many times what it differs by at rest [1]."""
LONG_LAG = 0.3
"""The scan's margin [s]: a frame this late is still taken at rest."""
LEAST_RATE = 10.0
"""Frames a second below which following a lane is not worth trying [Hz]."""


@dataclass(frozen=True)
class Finding:
    """One figure of the check, its sentence, and whether it is good."""

    name: str
    value: float | None
    sentence: str
    good: bool


class Check:
    """The test of one robot.

    Parameters
    ----------
    setup : GuardSetup
        The robot and the guard's rules.
    decode : callable
        Returns the image of JPEG bytes, or None.

    Raises
    ------
    InputError
        It speaks DTPS, and Duckietown's library is not installed.
    RobotLost
        The robot does not answer, or must not be driven.
    """

    def __init__(self, setup: GuardSetup, decode: Decode) -> None:
        self._subject = open_subject(setup, decode)
        self._robot, self._heard = self._subject.robot, self._subject.heard

    def findings(self) -> Iterator[Finding]:
        """Yield one figure after the other; the emergency stop is the last."""
        yield self._camera()
        yield from self._push()
        yield self._sweep()
        yield self._stop()

    def _camera(self) -> Finding:
        """Watch the camera at rest."""
        self._heard.frames.clear()
        self._robot.wait(WATCH)
        times = [arrival for arrival, _ in self._heard.frames]
        rate = len(times) / WATCH
        gap = max(np.diff(times), default=math.nan) if len(times) > 1 else math.nan
        words = f"The camera delivers {rate:.1f} frames a second; the longest gap is {1e3 * gap:.0f} ms."
        cure = "" if rate >= LEAST_RATE else " Look for other load on the robot or the network."
        return Finding("camera_hz", rate, words + cure, rate >= LEAST_RATE)

    def _push(self) -> Iterator[Finding]:
        """Turn a wheel, and see when the driver says so and when the picture does."""
        still = [image for _, image in self._heard.frames[-10:]]
        self._heard.executed.clear()
        began = time.monotonic()
        self._robot.run(WheelCommand(PUSH, 0.0), PUSH_SECONDS)
        self._robot.wait(1.0)
        echo = next((at - began for at, command in self._heard.executed if command.left > 0.0), None)
        words = (
            "The wheel driver acknowledges no command."
            if echo is None
            else (f"A command is acknowledged after {1e3 * echo:.0f} ms.")
        )
        yield Finding("echo_s", echo, words, echo is not None)
        lag = self._seen_after(still, began)
        if lag is None:
            words = "The picture did not change when the left wheel turned: is the camera the robot's own?"
        else:
            words = f"A turning wheel is seen after {1e3 * lag:.0f} ms, the motor's own delay included."
        yield Finding("latency_s", lag, words, lag is not None and lag < LONG_LAG + PUSH_SECONDS)

    def _seen_after(self, still: list[NDArray[np.uint8]], began: float) -> float | None:
        """Return when the picture changed [s after `began`]."""
        if len(still) < 2:
            return None
        noise = max(_difference(one, still[-1]) for one in still[:-1])
        for arrival, image in self._heard.frames:
            if arrival > began and _difference(image, still[-1]) > MOVED * noise:
                return arrival - began
        return None

    def _sweep(self) -> Finding:
        """Find the least command at which the encoders count, forward and back in turn."""
        for number, value in enumerate(SWEEP):
            before = dict(self._heard.ticks)
            signed = value if number % 2 == 0 else -value
            self._robot.run(WheelCommand(signed, signed), PUSH_SECONDS)
            self._robot.wait(0.3)
            if before and all(abs(self._heard.ticks[side] - count) >= 2 for side, count in before.items()):
                words = f"Both wheels turn from a command of {value:.2f} on."
                return Finding("least_command", value, words, value <= self._subject.least_command)
        if not self._heard.ticks:
            return Finding(
                "least_command", None, "No encoders: dead reckoning counts commands instead, to 10 %.", True
            )
        words = f"Not both wheels turn, up to a command of {SWEEP[-1]:.2f}: check motors, cables and battery."
        return Finding("least_command", None, words, False)

    def _stop(self) -> Finding:
        """Press the emergency stop while the robot turns."""
        slow = self._subject.turning
        self._robot.command(WheelCommand(slow, -slow))
        self._robot.wait(0.3)
        pressed = threading.Event()
        began = time.monotonic()
        self._subject.press_stop()
        try:
            self._robot.wait(1.0)
        except RobotLost:
            pressed.set()
        end = time.monotonic() + 0.5
        while time.monotonic() < end and not self._stopped_at(began):
            time.sleep(0.01)
        after = self._stopped_at(began)
        if after is None or not pressed.is_set():
            return Finding(
                "stop_s", after, "The emergency stop did not stop the wheels. Do not run it.", False
            )
        words = f"The emergency stop put the wheels to zero after {1e3 * after:.0f} ms."
        return Finding("stop_s", after, words, after < 0.3)

    def _stopped_at(self, began: float) -> float | None:
        """Return when the driver acknowledged zero after `began` [s after it]."""
        return next(
            (at - began for at, command in self._heard.executed if at > began and command == STOP), None
        )

    def close(self) -> None:
        """Stop the wheels and end the connections."""
        self._subject.close()


def _difference(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> float:
    """Return the mean absolute difference of two images [grey levels]."""
    return float(np.abs(one.astype(np.int16) - other).mean())
