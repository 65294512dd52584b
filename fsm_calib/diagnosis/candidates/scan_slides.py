"""Where is it slippery? Spots of lost grip tried by simulation over the visited floor.

A slide has no useful derivative: to first order in the loss of grip nothing happens, until the tyres let go. So spots
are simulated. Their likelihood is flat in the centre (a robot that slides 0.1 m earlier ends up much alike) but steep
in the grip: a spot that is too slippery sends the robot far off and looks worse than none, one that is not slippery
enough wins part. So a firm and a loose grip are tried at a coarse pitch, more of both about the best, in a spot of half
a turn and in one like a puddle: where the grip of the whole floor has given way to a spot of 0.13 m, all larger ones
win 7 units of log-likelihood at most, one of 0.09 m 14, and the fit from there 49. And a grip is tried that
is just too little for what the robot asks of its tyres there, g mu = max |a| over a passage, since a slide of heavy
robots is worth 200 units of log-likelihood at 0.85 of it, 10 at 1.5 of it and minus 300 at 0.65 (spots of 0.6 m under
carts of another engine). A robot whose wheels stand further apart than a spot reaches has one wheel in it at a time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.scan_areas import Area
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.shapes.score_tests import Residual, winnings
from fsm_calib.types import FloatArray
from fsm_calib.world2d.dynamics import AXLE, FRICTION
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.slots import GRAVITY

RADIUS = 0.25  # m: half of a small robot's turn
SMALL = 0.09  # m: a puddle that both wheels of a small robot hardly pass at once
RADII = (0.13, 0.18, 0.3, 0.37)  # m, tried where a spot of one of the two above does best
FIRST_LOSSES = (0.15, 0.5, 0.78)  # tried everywhere
FIRST_SMALL = (0.3, 0.65)  # the same in small spots
LOSSES = (0.15, 0.3, 0.5, 0.65, 0.78, 0.88)  # grips to an eighth, tried where the first promise most
FIRST_SHARES, SHARES = (0.87,), (0.97, 0.87, 0.75)  # the same of what the tyres are asked for there
LARGE = 1.2  # size from which on a spot is felt under each wheel
APART = 0.18  # m between the centres of two spots that are kept
KEPT = 3
LOOKED_AT = 12  # centres whose neighbours are tried, too
PITCH = 0.12  # m between neighbours
PACE = 0.05  # s between speeds, whose changes tell what the tyres are asked for
REACH = 0.12  # m beyond a spot's edge at which a wheel may touch it

Spot = dict[str, float]


@dataclass(frozen=True, slots=True)
class _Tried:
    """A spot's radius [m] and loss of grip [1], and the log-likelihood that it wins."""

    radius: float
    loss: float
    promise: float


@dataclass(frozen=True, eq=False)
class Slides:
    """Spots tried over one parent fit; size : of the robot, as `robot_size` tells it."""

    parent: Fit
    residual: Residual
    effect: Effect
    passages: list[Passages]
    size: float = 1.0

    @cached_property
    def demand(self) -> list[FloatArray]:
        """Friction coefficient (n,) [1] that the parent's motion asks of its tyres at each event of each recording."""
        half = 0.5 * float(self.parent.values[0, AXLE])
        pairs = zip(self.passages, self.parent.simulated, strict=True)
        return [_demand(p.simulator.prepared.time, increments, half) for p, increments in pairs]

    @cached_property
    def grip(self) -> float:
        """Friction coefficient [1] of the parent's tyres."""
        return float(self.parent.values[0, FRICTION])

    @property
    def growth(self) -> float:
        """How much larger spots are that matter to a robot of this size [1]: larger, but not in proportion."""
        return math.sqrt(self.size)

    @property
    def radius(self) -> float:
        """The usual radius of a spot [m]."""
        return RADIUS * self.growth

    def best(self, centres: FloatArray) -> list[tuple[Spot, float]]:
        """Return the most promising spots about `centres` (m, 2) [m]: numbers by full name, and what they win."""
        cells = np.round(centres / (self.size * PITCH) - 0.5).astype(int)
        coarse: FloatArray = centres[cells.sum(axis=1) % 2 == 0]
        first = [
            self._best_at(at, self._losses(at, FIRST_LOSSES, FIRST_SHARES), FIRST_SMALL) for at in coarse
        ]
        promise: FloatArray = np.array([found.promise for found in first])
        near = apart(promise, coarse, LOOKED_AT, self.size * APART)
        tried: FloatArray = np.unique(
            np.round(np.vstack([_about(coarse[i], self.size * PITCH) for i in near]), 6), axis=0
        )
        second = [self._best_at(at, self._losses(at, LOSSES, SHARES), LOSSES) for at in tried]
        most: FloatArray = np.array([found.promise for found in second])
        kept = apart(most, tried, KEPT, self.size * APART)
        return [self._of_best_radius(tried[i], second[i]) for i in kept]

    def _best_at(self, at: FloatArray, usual: Sequence[float], small: Sequence[float]) -> _Tried:
        """Return what promises most at a place, of losses of grip in a spot of the usual radius and in a small one."""
        tried = [(self.radius, usual), (self.growth * SMALL, small)]
        found = [
            _Tried(radius, loss, float(promise))
            for radius, losses in tried
            for loss, promise in zip(losses, self.promises(at, radius, losses), strict=True)
        ]
        return max(found, key=lambda one: one.promise)

    def _losses(self, at: FloatArray, firm: Sequence[float], shares: Sequence[float]) -> list[float]:
        """Return losses of grip to be tried at a place: some for all, some by what is asked of the tyres there."""
        asked = max(
            float(demand[p.inside(float(at[0]), float(at[1]), self.radius)].max(initial=0.0))
            for p, demand in zip(self.passages, self.demand, strict=True)
        )
        return [*firm, *(max(0.0, 1.0 - share * asked / self.grip) for share in shares)]

    def promises(self, at: FloatArray, radius: float, losses: Sequence[float]) -> FloatArray:
        """Return the log-likelihood (m,) that a spot wins with each loss of grip."""
        spots = [self._spot(at, radius, loss) for loss in losses]
        columns = [
            p.changes(
                np.vstack([with_values(p.values[None], spot) for spot in spots]),
                p.near(float(at[0]), float(at[1]), radius + REACH),
            )
            for p in self.passages
        ]
        return winnings(self.residual, self.residual.engine.white_columns(self.residual.whiteners, columns))

    def _of_best_radius(self, at: FloatArray, found: _Tried) -> tuple[Spot, float]:
        """Return a spot at a place with the loss of grip that was found and the radius that promises most."""
        radii = [self.growth * radius for radius in RADII]
        others = [
            replace(found, radius=r, promise=float(self.promises(at, r, (found.loss,))[0])) for r in radii
        ]
        best = max([found, *others], key=lambda one: one.promise)
        return self._spot(at, best.radius, best.loss), best.promise

    def _spot(self, at: FloatArray, radius: float, loss: float) -> Spot:
        spread = 1.0 if self.size > LARGE else 0.0
        acting = {f"{self.effect.name}.spread": spread, f"{self.effect.name}.loss": loss}
        return Area(float(at[0]), float(at[1]), radius, radius).numbers(self.effect) | acting


def _demand(time: FloatArray, increments: FloatArray, half: float) -> FloatArray:
    """Return what the tyres are asked for (n,) [1]: the larger acceleration of both axle ends over that of gravity.

    Taken from the way rolled, at an even pace: events of poses and wheels may come at once. time : (n,) [s];
    increments : (n, 5), ahead, aside and turned first; half : of the axle [m].
    """
    ways = np.cumsum(increments, axis=0)
    grid = np.arange(time[0], time[-1] + 2.0 * PACE, PACE)
    speed, rate = (np.gradient(np.interp(grid, time, ways[:, i]), PACE) for i in (0, 2))
    asked = np.hypot(np.abs(np.gradient(speed, PACE)) + half * np.abs(np.gradient(rate, PACE)), speed * rate)
    at_events: FloatArray = np.interp(time, grid, asked / GRAVITY)
    return at_events


def _about(at: FloatArray, pitch: float) -> FloatArray:
    """Return a centre (2,) [m] and its four neighbours at `pitch` [m], (5, 2)."""
    return at + pitch * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
