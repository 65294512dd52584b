"""An operator with a plan: straights, spins, arcs, slaloms, stop-and-go, rests; comes back and visits the place.

The operator sees where the robot is between two moves only, as somebody at a joystick does, and knows the data sheet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from foreign.setup import Array, Place

Move = list[tuple[float, float, float]]  # seconds, duty left, duty right


@dataclass
class Pilot:
    """Chooses moves; `top` [m/s] and `axle` [m] by the data sheet, `reach` [m] of the arena."""

    rng: np.random.Generator
    top: float
    axle: float
    reach: float
    place: Place | None
    levels: Array
    since: int = 0

    def next(self, state: Array) -> Move:
        """Return the next move from the state (x, y, theta, ...)."""
        self.since += 1
        far = float(np.hypot(state[0], state[1]))
        if self.place is not None and self.since >= 3:
            self.since = 0
            return [*self.head_for(state, self.place.x, self.place.y, 1.0), *self.within()]
        if far > 0.75 * self.reach:
            x, y = self.rng.normal(0.0, 0.3 * self.reach, 2)
            return self.head_for(state, x, y, 0.8)
        return self.free()

    def level(self) -> float:
        """Draw a duty."""
        return float(self.rng.choice(self.levels))

    def head_for(self, state: Array, x: float, y: float, share: float) -> Move:
        """Turn to a point, forward or backward, and drive there."""
        way = np.arctan2(y - state[1], x - state[0]) - state[2]
        sign = 1.0 if self.rng.random() < 0.7 else -1.0
        turn = float(np.angle(np.exp(1j * (way if sign > 0 else way + np.pi))))
        far = float(np.hypot(x - state[0], y - state[1])) * share
        spin, go = max(self.level() * 0.6, 0.2), max(self.level(), 0.3)
        moves = [
            (
                max(abs(turn) * self.axle / (2 * spin * self.top), 0.05) + 0.08,
                -np.sign(turn) * spin,
                np.sign(turn) * spin,
            )
        ]
        if self.rng.random() < 0.4:
            moves.append((0.4, 0.0, 0.0))
        moves.append((min(far / (go * self.top) + 0.1, 6.0), sign * go, sign * go))
        return moves

    def within(self) -> Move:
        """What is done in the place: a turn, a start, a stop, or nothing at all."""
        kind = self.rng.integers(4)
        if kind == 0:
            return self.spin()
        if kind == 1:
            return self.stop_and_go()
        if kind == 2:
            return self.arc()
        return [(0.3, 0.0, 0.0)]

    def free(self) -> Move:
        """A move of any kind."""
        return [self.straight, self.spin, self.arc, self.slalom, self.stop_and_go, self.rest, self.straight][
            int(self.rng.integers(7))
        ]()

    def straight(self) -> Move:
        go = self.level() * self.sign()
        return [(float(self.rng.uniform(0.8, 3.0)), go, go)]

    def spin(self) -> Move:
        go = self.level() * (1 if self.rng.random() < 0.5 else -1) * 0.7
        return [(float(self.rng.uniform(0.6, 2.5)), -go, go)]

    def arc(self) -> Move:
        go, less = self.level() * self.sign(), float(self.rng.uniform(-0.1, 0.85))
        pair = (go, go * less) if self.rng.random() < 0.5 else (go * less, go)
        return [(float(self.rng.uniform(1.0, 3.5)), *pair)]

    def slalom(self) -> Move:
        go, period, sway = (
            self.level() * self.sign(),
            float(self.rng.uniform(1.2, 3.0)),
            float(self.rng.uniform(0.15, 0.45)),
        )
        times = np.arange(0, float(self.rng.integers(1, 3)) * period, 0.1)
        return [
            (0.1, go * (1 - sway * np.sin(a)), go * (1 + sway * np.sin(a)))
            for a in 2 * np.pi * times / period
        ]

    def stop_and_go(self) -> Move:
        go, moves = self.level() * self.sign(), []
        for _ in range(int(self.rng.integers(2, 5))):
            moves += [
                (float(self.rng.uniform(0.3, 0.9)), go, go),
                (float(self.rng.uniform(0.2, 0.8)), 0.0, 0.0),
            ]
            go = -go if self.rng.random() < 0.4 else go
        return moves

    def rest(self) -> Move:
        return [(float(self.rng.uniform(0.5, 1.5)), 0.0, 0.0)]

    def sign(self) -> float:
        return 1.0 if self.rng.random() < 0.65 else -1.0


def clipped(moves: Move) -> Move:
    """Keep duties in -1 to 1."""
    return [(t, float(np.clip(a, -1, 1)), float(np.clip(b, -1, 1))) for t, a, b in moves]
