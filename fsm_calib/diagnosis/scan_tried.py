"""What would a candidate of a scan win as it stands? Simulated, where a first-order column does not tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsm_calib.diagnosis.adequacy import Residual, winnings
from fsm_calib.diagnosis.fit import AT_A_TIME, Fit
from fsm_calib.diagnosis.likelihood import Whitener
from fsm_calib.diagnosis.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table


def tried_out(
    simulators: Sequence[Simulator],
    parent: Fit,
    residual: Residual,
    candidates: Sequence[Mapping[str, float]],
) -> FloatArray:
    """Return the log-likelihood (m,) that each candidate wins over `parent`; all set the same full names."""
    if not candidates:
        return np.empty(0)
    changes = [
        _changes(simulator, whitener, parent.values[run], parent.simulated[run], candidates)
        for run, (simulator, whitener) in enumerate(zip(simulators, residual.whiteners, strict=True))
    ]
    return winnings(residual, np.concatenate(changes))


def _changes(
    simulator: Simulator,
    whitener: Whitener,
    values: FloatArray,
    simulated: FloatArray,
    candidates: Sequence[Mapping[str, float]],
) -> FloatArray:
    """Return the whitened changes (N, m) of one recording, with the sign of whitened derivatives."""
    table = parameter_table()
    rows = np.repeat(values[None], len(candidates), axis=0)
    for name in candidates[0]:
        rows[:, table.place(name)] = [numbers[name] for numbers in candidates]
    parts = [
        whitener.columns(np.moveaxis(simulated - simulator.increments(rows[i : i + AT_A_TIME]), 0, 2))
        for i in range(0, len(rows), AT_A_TIME)
    ]
    return np.concatenate(parts, axis=1)
