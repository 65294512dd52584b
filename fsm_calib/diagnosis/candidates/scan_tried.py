"""What would a candidate of a scan win as it stands? Simulated, where a first-order column does not tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsm_calib.diagnosis.fitting.fit import AT_A_TIME, Engine, Fit
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.shapes.score_tests import Residual, winnings
from fsm_calib.types import FloatArray


def responses(parent: Fit, engine: Engine, candidates: Sequence[Mapping[str, float]]) -> list[FloatArray]:
    """Return what each candidate changes in the increments of each recording, (n, 5, m); full names to values."""
    return [
        np.moveaxis(simulator.increments(_rows(values, candidates)) - before, 0, 2)
        for simulator, values, before in zip(engine.simulators, parent.values, parent.simulated, strict=True)
    ]


def tried_out(parent: Fit, residual: Residual, candidates: Sequence[Mapping[str, float]]) -> FloatArray:
    """Return the log-likelihood (m,) that each candidate wins over `parent`; full names to values."""
    engine = residual.engine
    won = [np.empty(0)]
    for first in range(0, len(candidates), AT_A_TIME):
        some = candidates[first : first + AT_A_TIME]
        columns = responses(parent, engine, some)
        won.append(winnings(residual, engine.white_columns(residual.whiteners, columns)))
    return np.concatenate(won)


def _rows(values: FloatArray, candidates: Sequence[Mapping[str, float]]) -> FloatArray:
    """Return the parameters (m, p) of each candidate on top of `values` (p,)."""
    return np.vstack([with_values(values[None], changes) for changes in candidates])
