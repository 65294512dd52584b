r"""Did somebody push the robot, or did the measured poses jump? A tracker that loses a robot may find it elsewhere.

A jump adds (dx, dy, dtheta) [m, m, rad] between two poses, a push takes the robot along for some frames, and its motors
bring it back to speed. So a jump at the likeliest frame about the push is fitted in its place, to the base robot as it
is linearised:

    evidence = max_k 2 (L_0 + g_k) - JUMP_NUMBERS ln N       in each recording that was pushed

L_0 [1] the base's log-likelihood, g_k what a jump before pose k wins, N innovations. Where frames are rare both look
alike, and no name can be said.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.jolts import AFTER, BEFORE
from fsm_calib.diagnosis.fitting.begins import begins_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.linear import Linear
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry

JUMP_NUMBERS = 4  # place, heading, time


def jumped(engine: Engine, bare: Linear, fit: Fit, effects: Sequence[str]) -> float:
    """Return the evidence of jumps of the poses at the times of the momentary ones of `effects`; -inf without one.

    bare : the model without `effects`, whitened by the fit's noise.
    """
    evidence, whiteners = -np.inf, engine.whiteners(fit.noise)
    numbers = 0
    for run, start in moments_of(fit, effects):
        events = _frames(engine.simulators[run].prepared, start)
        if not len(events):
            continue
        white = engine.white_columns(whiteners, _columns(engine, run, events))
        tried = [bare.with_columns(white[:, i : i + 3]) for i in range(0, white.shape[1], 3)]
        scores = [model.solved()[2] for model in tried]
        best = int(np.argmax(scores))
        bare, numbers = tried[best], numbers + JUMP_NUMBERS
        evidence = 2.0 * scores[best] - numbers * float(np.log(engine.count))
    return evidence


def moments_of(fit: Fit, effects: Sequence[str]) -> list[tuple[int, float]]:
    """Return recording and start [s] of every moment that a fit of some effects has, of each time that it came."""
    momentary = [name for name in effects if registry()[name].when == "moment"]
    return [
        (run, start) for name in momentary for run in fit.runs_of(name) for start in begins_of(fit, name, run)
    ]


def _frames(prepared: Prepared, start: float) -> np.ndarray:
    """Return the events with a scored pose about a time [s]."""
    near = (prepared.time > start - BEFORE) & (prepared.time < start + AFTER)
    return np.flatnonzero(near & prepared.scored[:, 2])


def _columns(engine: Engine, run: int, events: np.ndarray) -> list[FloatArray]:
    """Return increments (n, 5, 3 k) of all recordings by one unit of each coordinate before each of k events of one."""
    columns = [np.zeros((len(s.prepared.time), 5, 3 * len(events))) for s in engine.simulators]
    for i, event in enumerate(events):
        columns[run][event, :3, 3 * i : 3 * i + 3] = np.eye(3)
    return columns
