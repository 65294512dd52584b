"""The guard's rules, free of network and clock: what to send to the wheels now, and what ends a run.

Times are any monotonic clock's [s], commands [1]. Once stopped, the answer is zero for good.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from fsm_calib.robots.guard.pwm import Dither
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.types import STOP, WheelCommand

REMEMBERED = 2.0
"""An acknowledgement is ours when we sent the same command within this [s], or within `LinkSettings.echo`."""
SAME = 1e-4
"""Commands are the same within this [1]: they travel as 32 bit numbers."""
RELEASED = 0.25
"""A driver may release a wheel whose command is no larger than this [1]: ente's does up to 0.2."""
HUNG_CURE = "Close other programs; see that the computer does not sleep."
SILENT_CURE = "Check the network and that the wheel driver runs."
FOREIGN_CURE = "Stop the joystick, the virtual joystick and the lane following on the robot."


@dataclass(frozen=True, slots=True)
class Stopped:
    """Why the wheels were stopped: `kind` is a name of `errors` (LinkLost, EmergencyStopped)."""

    kind: str
    problem: str
    cure: str


class Rules:
    """What the guard knows and decides.

    Parameters
    ----------
    settings : LinkSettings
        Limits and times.
    fence : float
        Farthest from the start by dead reckoning [m].
    """

    def __init__(self, settings: LinkSettings, fence: float) -> None:
        self._settings, self._fence = settings, fence
        self._held, self._until, self._heard = STOP, math.inf, -math.inf
        self._remembered = max(REMEMBERED, settings.echo)
        self._sent: deque[tuple[float, WheelCommand]] = deque(maxlen=256)
        self._unanswered: float | None = None
        self._dither = (Dither(), Dither())
        self.stopped: Stopped | None = None

    @property
    def held(self) -> WheelCommand:
        """The command that is held now."""
        return self._held

    def hear(self, now: float) -> None:
        """The program lives."""
        self._heard = now

    def hold(self, command: WheelCommand, now: float, duration: float = math.inf) -> None:
        """Hold a command, for `duration` [s] or until the next one."""
        limit = self._settings.largest_command
        sides = (max(-limit, min(limit, side)) for side in (command.left, command.right))
        self._heard = now
        if self.stopped is None and math.isfinite(command.left) and math.isfinite(command.right):
            self._held, self._until = WheelCommand(*sides), now + duration

    def stop(self, kind: str, problem: str, cure: str) -> None:
        """Stop for good; the first reason counts."""
        self._held = STOP
        if self.stopped is None:
            self.stopped = Stopped(kind, problem, cure)

    def is_over(self, now: float) -> bool:
        """Tell whether a command's time is over at `now`."""
        return now >= self._until - 1e-9

    def end_run(self) -> None:
        """Set the wheels to zero because the command's time is over."""
        self._held, self._until = STOP, math.inf

    def next_look(self, now: float) -> float:
        """Return when to decide again [s]."""
        return min(now + self._settings.resend, self._until)

    def decide(self, now: float) -> WheelCommand:
        """Return the command to send at `now`."""
        if self.is_over(now):
            self.end_run()
        if self._held != STOP:
            self._check(now)
        command = self._held
        if self._settings.dither:
            command = WheelCommand(self._dither[0](command.left), self._dither[1](command.right))
        self._sent.append((now, command))
        if command != STOP and self._unanswered is None:
            self._unanswered = now
        return command

    def _check(self, now: float) -> None:
        """Stop when the program is silent, or the driver."""
        settings = self._settings
        if now - self._heard > settings.quiet:
            self.stop("LinkLost", f"The program was silent for {settings.quiet:g} s while driving", HUNG_CURE)
        elif self._unanswered is not None and now - self._unanswered > settings.echo:
            problem = f"The wheel driver acknowledged no command for {settings.echo:g} s"
            self.stop("LinkLost", problem, SILENT_CURE)

    def executed(self, command: WheelCommand, now: float) -> None:
        """The driver says that it applied a command: ours, or somebody else's."""
        ours = any(now - time <= self._remembered and _same(command, sent) for time, sent in self._sent)
        if ours:
            self._unanswered = None
        elif not _same(command, STOP):
            problem = f"Somebody else drives the wheels ({command.left:.3f}, {command.right:.3f})"
            self.stop("EmergencyStopped", problem, FOREIGN_CURE)

    def reckoned(self, x: float, y: float) -> None:
        """Dead reckoning says that the robot is at (x, y) [m] from its start."""
        if math.hypot(x, y) > self._fence:
            problem = f"The robot is {math.hypot(x, y):.1f} m from its start by dead reckoning"
            cure = f"The fence is at {self._fence:.1f} m (robot.link.fence). Carry the robot back."
            self.stop("EmergencyStopped", problem, cure)


def _same(executed: WheelCommand, sent: WheelCommand) -> bool:
    sides = ((executed.left, sent.left), (executed.right, sent.right))
    return all(abs(one - other) <= SAME or (one == 0.0 and abs(other) <= RELEASED) for one, other in sides)
