"""What serves a simulated Duckiebot on any network: what arrives, the passing of time, and steps on request."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from fsm_calib.robots.served.duckiebot import Outlet, ServedDuckiebot
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.types import WheelCommand
from fsm_calib.world2d.robot import World

COMMAND_WAIT = 60.0
"""Longest wait for a command that a step says is on its way [s]: a loaded machine only takes longer."""
CHUNK = 0.002
"""In real time the world is moved on so often [s]."""
LARGEST_CHUNK = 0.05
"""And by no more at once [s]: what a machine cannot do in time is left out, so that commands do not wait for it."""


class Station:
    """A served robot between its world and its network.

    Parameters
    ----------
    world : World
        The simulated world.
    settings : ServeSettings
        Delays and losses.
    outlet : Outlet
        Where the robot publishes.
    lockstep : bool
        Time passes only when a client asks for it; else as on the wall, from `start` on.
    """

    def __init__(self, world: World, settings: ServeSettings, outlet: Outlet, lockstep: bool) -> None:
        self._changed = threading.Condition()
        self._received = 0
        self._client = ""
        self._closed = False
        self._lockstep = lockstep
        self.last_received = WheelCommand()
        self.robot = ServedDuckiebot(world, settings, outlet)
        self.robot.is_watched = not lockstep
        self._began = time.monotonic()
        self.stood = 0.0
        """How long the robot's time has stood still in all, because the machine let it starve [s]."""

    def start(self) -> None:
        """Let time pass as on the wall, unless it passes in steps."""
        if not self._lockstep:
            self._began = time.monotonic()
            threading.Thread(target=self._run, daemon=True, name="robot").start()

    def take(self, command: WheelCommand) -> None:
        """A wheel command arrives."""
        with self._changed:
            self.last_received = command
            self._received += 1
            self.robot.take(command)
            self._changed.notify_all()

    def stop(self, pressed: bool) -> None:
        """The emergency stop sets a flag: it acts at the next command, as on the robot."""
        with self._changed:
            self.robot.is_stopped = pressed

    def step(self, question: dict[str, Any], answer: Callable[[dict[str, Any]], None]) -> None:
        """Let time pass as a client in lockstep asks, and answer; see `robots.stepper`."""
        client, commands = question["client"], question["commands"]
        with self._changed:
            if commands == 0:
                self._client, self._received = client, 0  # a new client counts from nothing
                self._changed.notify_all()
            self._changed.wait_for(lambda: self._received >= commands or self._client != client, COMMAND_WAIT)
            if self._client != client:
                return  # of a client before, which has gone while its commands were on their way
            self.robot.is_watched = bool(question["look"])
            self.robot.run_until(question["until"])
            said = {
                "client": client,
                "number": question["number"],
                "time": self.robot.now,
                "step": self.robot.world.spec.settings.step,
                "frame": self.robot.last_frame,
                "taken": self.robot.taken,
                "executed": self.robot.applied,
            }
        answer(said)

    def _run(self) -> None:
        """Let time pass as on the wall."""
        while not self._closed:
            self.follow(time.monotonic() - self._began)
            time.sleep(CHUNK)

    def follow(self, wall: float) -> None:
        """Let the robot's time follow the wall's, `wall` [s] since the start, as far as the machine can."""
        with self._changed:
            behind = wall - self.stood - self.robot.now
            self.stood += max(behind - LARGEST_CHUNK, 0.0)
            self.robot.run_until(wall - self.stood)

    def close(self) -> None:
        """End the passing of time."""
        self._closed = True
