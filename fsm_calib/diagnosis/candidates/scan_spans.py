"""When did a motor fail? Spans of one recording in which one wheel's gain is lower, to first order.

A span is a sum of cells between neighbouring edges. All cells pass the whitening filter as columns, and the score and
power of every span are sums over theirs. Coarse edges over the whole drive find the span, fine ones about its begin
and end find these: a fit that starts a second off stays there, since the likelihood is bumpy in both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.shapes.score_tests import NO_POWER, Residual
from fsm_calib.types import FloatArray

COARSE, FINE = 0.75, 0.15  # s between edges
ABOUT = 1.2  # s about a coarse edge in which fine ones are tried
LOSSES = (0.005, 1.0)  # smallest and largest change of a gain that counts


@dataclass(frozen=True, slots=True)
class Span:
    """A weak motor from begin to end [s], the share of its gain that is lost, the log-likelihood that it promises."""

    begin: float
    end: float
    loss: float
    promise: float


Cells = Callable[[FloatArray], FloatArray]


def likely_span(residual: Residual, run: int, cells: Cells, sizes: tuple[float, float] = LOSSES) -> Span:
    """Return the most promising span of recording `run`.

    cells : edges (m + 1,) [s] to what acting in each cell between two of them changes in the recording's increments,
    (n, 5, m); sizes : smallest and largest multiple of that which counts.
    """
    time = residual.whiteners[run].prepared.time
    ends = [max(time[0], 0.0), time[-1]]
    found = _best(
        residual, run, cells, sizes, np.unique([*np.arange(ends[0], ends[1] - COARSE, COARSE), *ends])
    )
    about = [np.arange(at - ABOUT, at + ABOUT, FINE) for at in (found.begin, found.end)]
    fine = np.unique(np.clip(np.concatenate([*about, ends]), *ends))
    return max(found, _best(residual, run, cells, sizes, fine), key=lambda span: span.promise)


def _best(residual: Residual, run: int, cells: Cells, sizes: tuple[float, float], edges: FloatArray) -> Span:
    """Return the most promising span between two of `edges` [s]; what is fitted is taken off the cells' products."""
    white = residual.engine.white_columns((residual.whiteners[run],), (cells(edges),))
    rows = residual.rows(run)
    inside = residual.basis[rows].T @ white
    score = np.r_[0.0, np.cumsum(residual.psi[rows] @ white - residual.psi_inside @ inside)]
    gram = np.zeros((len(edges), len(edges)))
    gram[1:, 1:] = np.cumsum(np.cumsum(white.T @ white - inside.T @ inside, axis=0), axis=1)
    i, j = np.triu_indices(len(edges), 1)
    power = gram[j, j] - gram[i, j] - gram[j, i] + gram[i, i]
    amplitude = (score[j] - score[i]) / np.maximum(power, NO_POWER)
    counts = (np.abs(amplitude) > sizes[0]) & (np.abs(amplitude) < sizes[1])
    promise = np.where(counts, 0.5 * amplitude**2 * power, 0.0)
    best = int(np.argmax(promise))
    return Span(float(edges[i[best]]), float(edges[j[best]]), -float(amplitude[best]), float(promise[best]))


def gain_cells(residual: Residual, run: int, gain: FloatArray, edges: FloatArray) -> FloatArray:
    """Return the `gain` (n, 5) of a recording cut at `edges`, (n, 5, cells)."""
    time = residual.whiteners[run].prepared.time
    cells = np.zeros((*gain.shape, len(edges) - 1))
    index = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(edges) - 2)
    cells[np.arange(len(index)), :, index] = gain
    return cells
