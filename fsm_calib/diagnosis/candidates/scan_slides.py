"""Where is it slippery? Spots of lost grip tried by simulation over the visited floor.

A slide has no useful derivative: to first order in the loss of grip nothing happens, until the tyres let go. So spots
are simulated. Their likelihood is flat in the centre (a robot that slides 0.1 m earlier ends up much alike) but steep
in the grip: a spot that is too slippery sends the robot far off and looks worse than none, one that is not slippery
enough wins part. So a firm and a loose grip are tried at a coarse pitch, more of both about the best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.scan_areas import Area
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.shapes.score_tests import Residual, winnings
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

RADIUS = 0.25  # m: half of a small robot's turn
RADII = (0.18, 0.3, 0.37)  # m, tried where a spot of the usual radius does best
FIRST_LOSSES = (0.5, 0.78)  # tried everywhere
LOSSES = (0.5, 0.65, 0.78, 0.88)  # grips of a half to an eighth, tried where the first promise most
APART = 0.18  # m between the centres of two spots that are kept
KEPT = 3
LOOKED_AT = 12  # centres whose neighbours are tried, too
PITCH = 0.12  # m between neighbours
REACH = 0.12  # m beyond a spot's edge at which a wheel may touch it

Spot = dict[str, float]


@dataclass(frozen=True, eq=False)
class Slides:
    """Spots tried over one parent fit; size : of the robot, as `robot_size` tells it."""

    parent: Fit
    residual: Residual
    effect: Effect
    passages: list[Passages]
    size: float = 1.0

    def best(self, centres: FloatArray) -> list[tuple[Spot, float]]:
        """Return the most promising spots about `centres` (m, 2) [m]: numbers by full name, and what they win."""
        cells = np.round(centres / (self.size * PITCH) - 0.5).astype(int)
        coarse: FloatArray = centres[cells.sum(axis=1) % 2 == 0]
        promise: FloatArray = np.array(
            [self.promises(at, self.size * RADIUS, FIRST_LOSSES).max() for at in coarse]
        )
        near = apart(promise, coarse, LOOKED_AT, self.size * APART)
        tried: FloatArray = np.unique(
            np.round(np.vstack([_about(coarse[i], self.size * PITCH) for i in near]), 6), axis=0
        )
        promises = np.array([self.promises(at, self.size * RADIUS, LOSSES) for at in tried])
        most: FloatArray = promises.max(axis=1)
        kept = apart(most, tried, KEPT, self.size * APART)
        return [
            self._of_best_radius(tried[i], LOSSES[int(np.argmax(promises[i]))], promises[i].max())
            for i in kept
        ]

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

    def _of_best_radius(self, at: FloatArray, loss: float, promise: float) -> tuple[Spot, float]:
        radii = [self.size * radius for radius in RADII]
        promises = [float(promise), *(float(self.promises(at, radius, (loss,))[0]) for radius in radii)]
        best = int(np.argmax(promises))
        return self._spot(at, (self.size * RADIUS, *radii)[best], loss), promises[best]

    def _spot(self, at: FloatArray, radius: float, loss: float) -> Spot:
        acting = {f"{self.effect.name}.spread": 0.0, f"{self.effect.name}.loss": loss}
        return Area(float(at[0]), float(at[1]), radius, radius).numbers(self.effect) | acting


def _about(at: FloatArray, pitch: float) -> FloatArray:
    """Return a centre (2,) [m] and its four neighbours at `pitch` [m], (5, 2)."""
    return at + pitch * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
