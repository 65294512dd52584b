"""The wheel-speed controller that some robots have of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from benchmarks.ode_robots.plant import Control

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Now

PERIOD = 0.01  # s


class Controller:
    """A feed-forward, proportional and integral controller at 100 Hz with limits."""

    def __init__(self, control: Control, step: float) -> None:
        """Begin with empty integrals."""
        self.control = control
        self.every = max(1, round(PERIOD / step))
        self.count = 0
        self.sums = [0.0, 0.0]
        self.held = [0.0, 0.0]

    def duty(self, now: Now) -> list[float]:
        """Return the duties that hold the commanded shares of full wheel speed."""
        if self.count % self.every == 0:
            for side in (0, 1):
                self.held[side] = self._one(side, now.command[side], now.rate[side])
        self.count += 1
        return self.held

    def _one(self, side: int, command: float, rate: float) -> float:
        c = self.control
        if command == 0.0 and abs(rate) < 0.01 * c.full:  # holds still without a fight with dry friction
            self.sums[side] = 0.0
            return 0.0
        error = command - rate / c.full
        duty = 0.85 * command + c.gain * error + self.sums[side]
        if abs(duty) < 1.0 or duty * error < 0.0:  # the integral waits while the duty is at its limit
            more = self.sums[side] + c.integral * error * PERIOD
            self.sums[side] = min(max(more, -c.most_integral), c.most_integral)
        return min(max(duty, -1.0), 1.0)
