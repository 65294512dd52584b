"""Is there a higher hill beside the one that a fit stands on? Looked for along the fit's own ridge.

A threshold (a dead zone, a limit, friction that holds) either lets a command through or not, so that its likelihood
has a step wherever a drive has a level of command, and a hill on either side. No gradient leads across. So a fitted
strength is moved by shares of itself, the other free numbers with it as they go together,

    x'_i = x_i + C_is / C_ss (x'_s - x_s),     x'_s = null + (1 + share) (x_s - null)

C the covariance of the fit, s the strength, and each such point is simulated. Where one is higher, a fit goes on from
there. (Nine drives of a robot with a dead zone of 0.05: a fit at 0.0545, another at 0.0468, 500 units of evidence
higher; with the first alone the robot was said to have dry friction, 0.96 sure.)
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.newton import log_prior
from fsm_calib.diagnosis.fitting.slot import with_slots
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

SHARES = np.array([-0.4, -0.3, -0.2, -0.15, -0.1, -0.05, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4])  # of a strength
HIGHER = 3.0  # log-likelihood units that make another hill worth climbing


def beyond_the_ridge(engine: Engine, fit: Fit, effect: str) -> FloatArray | None:
    """Return the best parameters (R, p) along the ridges of an effect's strengths; None where none is higher."""
    points = _along(fit, effect)
    if not len(points):
        return None
    scores = _scores(engine, fit, points)
    best = int(np.argmax(scores))
    if not scores[best] > fit.score + HIGHER:
        return None
    return with_slots(fit.values, fit.slots, points[best])


def _along(fit: Fit, effect: str) -> FloatArray:
    """Return the free numbers (k, m) at every share along the ridge of every strength, inside their bounds."""
    table, here, points = parameter_table(), fit.slot_values(), []
    low, high = fit.slot_bounds()
    for s, slot in enumerate(fit.slots):
        variance = float(fit.covariance[s, s])
        is_strength = table.owner[slot.place] == effect and table.entries[slot.place].strength
        if not is_strength or not variance > 0.0:
            continue
        moved = SHARES * (here[s] - table.null[slot.place])
        kept = (here[s] + moved >= low[s]) & (here[s] + moved <= high[s])
        points.append(here + np.outer(moved[kept], fit.covariance[:, s] / variance))
    return np.clip(np.concatenate(points), low, high) if points else np.empty((0, len(here)))


def _scores(engine: Engine, fit: Fit, points: FloatArray) -> FloatArray:
    """Return the score (k,) of a fit's model with other numbers (k, m) in its slots."""
    values = np.array([with_slots(fit.values, fit.slots, point) for point in points])
    whiteners = engine.whiteners(fit.noise)
    likelihood = sum(
        engine.of_recording(run, whiteners, values[:, run]) for run in range(len(engine.simulators))
    )
    return np.asarray(likelihood + np.array([log_prior(fit.slots, point) for point in points]))
