"""A simulated Duckiebot with everything between its ports and a network: a queue of events in its own time.

Commands act after a delay, floored to whole PWM numbers; frames are published after theirs, some never, some late;
encoders tick. Nothing here knows a network: what is published goes to an `Outlet`.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fsm_calib.robots.guard.pwm import floored
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.types import STOP, Pose2, WheelCommand
from fsm_calib.world2d.robot import World

RESOLUTION = 135
"""Ticks of one turn of a wheel (Duckietown's encoders)."""
SERVE_STREAM = 21
"""Which random stream of the seed delays and losses are drawn from."""
TRACKER_STREAM = 22
"""Which random stream of the seed the tracker's noise is drawn from."""


class Outlet(Protocol):
    """Where a served robot publishes."""

    def frame(self, number: int, stamp: float, image: NDArray[np.uint8]) -> None:
        """Publish frame `number`, stamped with the robot's time [s]."""
        ...

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        """Tell that a command, the `number`-th from 1 on, has been applied at `time` [s]."""
        ...

    def ticks(self, side: str, count: int, time: float) -> None:
        """Publish the count of a wheel's encoder at `time` [s]."""
        ...

    def tracked(self, pose: Pose2, time: float) -> None:
        """Publish where a camera over the area sees the robot at `time` [s], for recordings."""
        ...


@dataclass(eq=False)
class ServedDuckiebot:
    """The robot in its own time [s], from 0.

    Parameters
    ----------
    world : World
        The simulated world.
    settings : ServeSettings
        Delays and losses.
    outlet : Outlet
        Where it publishes.
    """

    world: World
    settings: ServeSettings
    outlet: Outlet

    def __post_init__(self) -> None:
        """Begin with the first exposure and the first ticks."""
        self._rng = np.random.default_rng([self.world.spec.seed, SERVE_STREAM])
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._exposed = self.taken = self.applied = 0
        self.last_frame = -1
        self._next_command = 0.0
        self._acting = STOP
        self._turned = self.world.truth.wheel_angles
        self._signs = [1.0, 1.0]
        self._counts = [0.0, 0.0]
        self.is_stopped = False
        self.is_watched = True
        self._later(0.0, self._expose)
        if self.settings.encoders:
            self._later(0.0, self._tick)
        self._tracker_rng = np.random.default_rng([self.world.spec.seed, TRACKER_STREAM])
        if self.settings.tracker > 0.0:
            self._later(0.0, self._track)

    @property
    def now(self) -> float:
        """The robot's time [s]."""
        return self.world.robot.now()

    def take(self, command: WheelCommand) -> None:
        """A command arrives; it acts after the driver's delay, and never before an earlier one."""
        settings = self.settings
        self.taken += 1
        delay = max(settings.command_latency + settings.command_jitter * self._rng.standard_normal(), 0.0)
        self._next_command = max(self.now + delay, self._next_command)
        self._later(self._next_command, lambda: self._apply(command))

    def run_until(self, time: float) -> None:
        """Let the time pass until `time` [s], with everything that happens on the way."""
        while self._events and self._events[0][0] <= time:
            at, _, event = heapq.heappop(self._events)
            self._advance(at)
            event()
        self._advance(time)

    def _later(self, time: float, event: Callable[[], None]) -> None:
        heapq.heappush(self._events, (time, next(self._order), event))

    def _advance(self, time: float) -> None:
        """Move the world on, in whole steps."""
        step = self.world.spec.settings.step
        ticks = round(time / step) - round(self.now / step)
        if ticks > 0:
            self.world.robot.wait(ticks * step)

    def _apply(self, command: WheelCommand) -> None:
        """The driver applies a command; a pressed stop makes it zero."""
        asked = STOP if self.is_stopped else command
        self._turn_wheels()
        acting = asked
        if self.settings.pwm_steps:
            least = self.settings.dead_zone
            acting = WheelCommand(floored(asked.left, least), floored(asked.right, least))
        self._signs = [-1.0 if value < 0.0 else 1.0 for value in (acting.left, acting.right)]
        if acting != self._acting:
            self.world.robot.command(acting)
            self._acting = acting
        self.applied += 1
        self.outlet.executed(asked, self.applied, self.now)

    def _expose(self) -> None:
        """Take a frame where somebody looks, and send it on its way."""
        number, settings = self._exposed, self.settings
        self._exposed += 1
        self._later(self._exposed / settings.rate, self._expose)
        latency = settings.camera_latency + settings.camera_jitter * self._rng.standard_normal()
        dropped, late = self._rng.random(2) < (settings.dropped, settings.late)
        if dropped or not self.is_watched:
            return
        frame = self.world.robot.capture()
        if frame is None:
            return
        stamp = self.now + max(latency, 0.0)
        arrival = stamp + (settings.late_by if late else 0.0)
        self._later(arrival, lambda: self._publish(number, stamp, frame.image))

    def _publish(self, number: int, stamp: float, image: NDArray[np.uint8]) -> None:
        self.last_frame = number
        self.outlet.frame(number, stamp + self.settings.clock_offset, image)

    def _tick(self) -> None:
        """Publish the encoders' counts."""
        self._turn_wheels()
        for side, name in enumerate(("left", "right")):
            self.outlet.ticks(name, int(self._counts[side]), self.now)
        self._later(self.now + 1.0 / self.settings.rate, self._tick)

    def _track(self) -> None:
        """Publish what a camera over the area measures: the true pose with white noise."""
        pose, noise = (
            self.world.truth.pose,
            self.settings.tracker_noise * self._tracker_rng.standard_normal(3),
        )
        self.outlet.tracked(
            Pose2(pose.x + noise[0], pose.y + noise[1], pose.theta + 5.0 * noise[2]), self.now
        )
        self._later(self.now + 1.0 / self.settings.tracker, self._track)

    def _turn_wheels(self) -> None:
        """Count the wheels' turns since the last time.

        They are signed as Duckietown's driver does: backward below zero, else forward, whichever way they roll.
        """
        before, self._turned = self._turned, self.world.truth.wheel_angles
        for side, (then, now) in enumerate(zip(before, self._turned, strict=True)):
            self._counts[side] += self._signs[side] * abs(now - then) / math.tau * RESOLUTION
