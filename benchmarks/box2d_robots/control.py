"""The wheel-speed controller of some robots: an incremental PI with a ramp and feed-forward.

The velocity form (Astrom and Hagglund, PID Controllers, 1995, ch. 3) cannot wind up, since the clipped duty
is its memory.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from benchmarks.box2d_robots.parts import Control

if TYPE_CHECKING:
    from benchmarks.box2d_robots.machine import Now


class Controller:
    """Holds the commanded shares of the full wheel rate, with encoders read at its own period."""

    def __init__(self, control: Control, step: float) -> None:
        """Begin at rest."""
        self.control = control
        self.every, self.count = max(1, round(control.period / step)), 0
        self.goal, self.held = [0.0, 0.0], [0.0, 0.0]
        self.error, self.angle, self.rate = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]

    def duty(self, now: Now) -> list[float]:
        """Return the duties of left and right motor."""
        if self.count % self.every == 0:
            for side in (0, 1):
                self._one(side, now.command[side], float(now.turned[side]))
        self.count += 1
        return self.held

    def _one(self, side: int, command: float, angle: float) -> None:
        c = self.control
        fresh = (angle - self.angle[side]) / c.period
        self.angle[side] = angle
        self.rate[side] += 0.5 * (fresh - self.rate[side])
        step = c.ramp * c.period
        goal = min(max(command, self.goal[side] - step), self.goal[side] + step)
        feed = c.feed * (goal - self.goal[side])
        self.goal[side] = goal
        if goal == 0.0 and abs(self.rate[side]) < 0.02 * c.full:  # lets go at rest
            self.held[side] = self.error[side] = 0.0
            return
        error = goal - self.rate[side] / c.full
        more = feed + c.gain * (error - self.error[side]) + c.integral * error * c.period
        self.error[side] = error
        self.held[side] = min(max(self.held[side] + more, -1.0), 1.0)
