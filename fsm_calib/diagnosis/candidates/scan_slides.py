"""Where is it slippery? Spots of lost grip tried by simulation over the visited floor.

A slide has no useful derivative: to first order in the loss of grip nothing happens, until the tyres let go. So spots
are simulated. Their likelihood is flat in the centre (a robot that slides 0.1 m earlier ends up much alike) but steep
in the grip: a spot that is too slippery sends the robot far off and looks worse than none, one that is not slippery
enough wins part. So grips are tried from firm to loose at a coarse pitch.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.scan_areas import Area
from fsm_calib.diagnosis.candidates.scan_tried import tried_out
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

RADIUS = 0.25  # m: half of a small robot's turn
RADII = (0.18, 0.3, 0.37)  # m, tried where a spot of the usual radius does best
LOSSES = (0.5, 0.65, 0.78, 0.88)  # grips of a half to an eighth
APART = 0.18  # m between the centres of two spots that are kept
KEPT = 3

Spot = dict[str, float]


def slides(parent: Fit, residual: Residual, centres: FloatArray, effect: Effect) -> list[tuple[Spot, float]]:
    """Return the most promising spots about `centres` (m, 2) [m]: numbers by full name, and what they win as such."""
    tried = [_spot(effect, x, y, RADIUS, loss) for (x, y), loss in product(centres.tolist(), LOSSES)]
    promise = tried_out(parent, residual, tried)
    kept = apart(promise, np.repeat(centres, len(LOSSES), axis=0), KEPT, APART)
    return [_of_best_radius(parent, residual, tried[i], float(promise[i]), effect) for i in kept]


def _of_best_radius(
    parent: Fit, residual: Residual, spot: Spot, promise: float, effect: Effect
) -> tuple[Spot, float]:
    x, y, loss = (spot[f"{effect.name}.{name}"] for name in ("x", "y", "loss"))
    tried = [_spot(effect, x, y, radius, loss) for radius in RADII]
    promises = [promise, *tried_out(parent, residual, tried).tolist()]
    best = int(np.argmax(promises))
    return [spot, *tried][best], promises[best]


def _spot(effect: Effect, x: float, y: float, radius: float, loss: float) -> Spot:
    acting = {f"{effect.name}.spread": 0.0, f"{effect.name}.loss": loss}
    return Area(x, y, radius, radius).numbers(effect) | acting
