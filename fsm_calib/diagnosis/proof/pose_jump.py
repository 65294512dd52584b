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

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.linear import Linear
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

JUMP_NUMBERS = 4  # place, heading, time
BEFORE, AFTER = (
    0.2,
    0.4,
)  # s from a push's start: what the fit may be off by, and what a motor needs to answer


def jumped(engine: Engine, bare: Linear, fit: Fit, effects: Sequence[str]) -> float:
    """Return the evidence of jumps of the poses at the times of the momentary ones of `effects`; -inf without one.

    bare : the model without `effects`, whitened by the fit's noise.
    """
    evidence, whiteners = -np.inf, engine.whiteners(fit.noise)
    for name in effects:
        if registry()[name].when != "moment":
            continue
        count = 0
        for run in fit.runs_of(name):
            start = float(fit.values[run, parameter_table().place(f"{name}.start")])
            tried = [
                bare.with_columns(engine.white_columns(whiteners, _columns(engine, run, k)))
                for k in _frames(engine.simulators[run].prepared, start)
            ]
            if tried:
                bare = max(tried, key=lambda model: model.solved()[2])
                count += 1
        if count:
            evidence = 2.0 * bare.solved()[2] - JUMP_NUMBERS * count * float(np.log(engine.count))
    return evidence


def _frames(prepared: Prepared, start: float) -> np.ndarray:
    """Return the events with a scored pose about a time [s]."""
    near = (prepared.time > start - BEFORE) & (prepared.time < start + AFTER)
    return np.flatnonzero(near & prepared.scored[:, 2])


def _columns(engine: Engine, run: int, event: int) -> list[FloatArray]:
    """Return increments (n, 5, 3) of all recordings by one unit of each coordinate before an event of one."""
    columns = [np.zeros((len(s.prepared.time), 5, 3)) for s in engine.simulators]
    columns[run][event, :3] = np.eye(3)
    return columns
