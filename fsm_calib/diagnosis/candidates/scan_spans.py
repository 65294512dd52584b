"""When did a motor fail? Spans of one recording in which one wheel's gain is lower, to first order.

A span is a sum of cells between neighbouring edges. All cells pass the whitening filter as columns, and the score and
power of every span are sums over theirs. Coarse edges over the whole drive find the span, fine ones about its begin
and end find these: a fit that starts a second off stays there, since the likelihood is bumpy in both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.shapes.score_tests import NO_POWER, Residual
from fsm_calib.types import FloatArray

COARSE, FINE = 0.75, 0.15  # s between edges
ABOUT = 1.2  # s about a coarse edge in which fine ones are tried
LOSSES = (0.005, 1.0)  # smallest and largest change of a gain that counts
FINER = 0.15  # log of the ratio between losses that are tried: what a span promises hardly falls within it


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
    ends = _ends(residual, run)
    found = _best(residual, run, cells, sizes, _coarse_edges(ends))
    fine = _best(residual, run, cells, sizes, _edges_about(found, ends))
    return max(found, fine, key=lambda span: span.promise)


def alike_spans(residual: Residual, each: Sequence[Cells]) -> list[Span]:
    """Return a span of each recording by one loss that all share, which promise most together.

    each : the `cells` of every recording. For a loss x the best span of a recording is told by itself,
    max (x s - x^2 P / 2) of its score s and power P, so that x alone is sought (by ratios, then about the best).
    """
    ends = [_ends(residual, run) for run in range(len(each))]
    coarse = [_spans(residual, run, cells, _coarse_edges(ends[run])) for run, cells in enumerate(each)]
    sizes = np.geomspace(*LOSSES, round(np.log(LOSSES[1] / LOSSES[0]) / FINER))
    found = _most_together(coarse, [*-sizes, *sizes])
    fine = [
        _spans(residual, run, cells, _edges_about(span, ends[run]))
        for run, (cells, span) in enumerate(zip(each, found, strict=True))
    ]
    near = found[0].loss * np.linspace(0.5, 2.0, 31)
    return max(found, _most_together(fine, near), key=lambda spans: sum(span.promise for span in spans))


def _most_together(each: Sequence[_Spans], losses: Iterable[float]) -> list[Span]:
    """Return of each recording the best span by the loss that promises most in all."""
    tried = ([spans.best_with(float(loss)) for spans in each] for loss in losses)
    return max(tried, key=lambda found: sum(span.promise for span in found))


def _ends(residual: Residual, run: int) -> tuple[float, float]:
    """Return between which times [s] the spans of a recording lie."""
    time = residual.whiteners[run].prepared.time
    return max(float(time[0]), 0.0), float(time[-1])


def _coarse_edges(ends: tuple[float, float]) -> FloatArray:
    """Return edges [s] over the whole recording."""
    return np.unique([*np.arange(ends[0], ends[1] - COARSE, COARSE), *ends])


def _edges_about(span: Span, ends: tuple[float, float]) -> FloatArray:
    """Return fine edges [s] about begin and end of a span, and the recording's ends."""
    about = [np.arange(at - ABOUT, at + ABOUT, FINE) for at in (span.begin, span.end)]
    return np.unique(np.clip(np.concatenate([*about, ends]), *ends))


def _best(residual: Residual, run: int, cells: Cells, sizes: tuple[float, float], edges: FloatArray) -> Span:
    """Return the most promising span between two of `edges` [s]."""
    spans = _spans(residual, run, cells, edges)
    amplitude = spans.score / np.maximum(spans.power, NO_POWER)
    counts = (np.abs(amplitude) > sizes[0]) & (np.abs(amplitude) < sizes[1])
    promise = np.where(counts, 0.5 * amplitude**2 * spans.power, 0.0)
    best = int(np.argmax(promise))
    return spans.span(best, -float(amplitude[best]), float(promise[best]))


@dataclass(frozen=True, eq=False)
class _Spans:
    """All spans (c,) between two of some edges [s]: begins, ends, the score and the power of their columns."""

    begin: FloatArray
    end: FloatArray
    score: FloatArray
    power: FloatArray

    def span(self, number: int, loss: float, promise: float) -> Span:
        """Return one of them."""
        return Span(float(self.begin[number]), float(self.end[number]), loss, promise)

    def best_with(self, loss: float) -> Span:
        """Return the span that promises most where the motor loses so much [1]."""
        promise = -loss * self.score - 0.5 * loss * loss * self.power
        best = int(np.argmax(promise))
        return self.span(best, loss, float(promise[best]))


def _spans(residual: Residual, run: int, cells: Cells, edges: FloatArray) -> _Spans:
    """Return all spans between two of `edges` [s]; what is fitted is taken off the cells' products."""
    white = residual.engine.white_columns((residual.whiteners[run],), (cells(edges),))
    rows = residual.rows(run)
    inside = residual.basis[rows].T @ white
    score = np.r_[0.0, np.cumsum(residual.psi[rows] @ white - residual.psi_inside @ inside)]
    gram = np.zeros((len(edges), len(edges)))
    gram[1:, 1:] = np.cumsum(np.cumsum(white.T @ white - inside.T @ inside, axis=0), axis=1)
    i, j = np.triu_indices(len(edges), 1)
    power = gram[j, j] - gram[i, j] - gram[j, i] + gram[i, i]
    return _Spans(edges[i], edges[j], score[j] - score[i], power)


def gain_cells(residual: Residual, run: int, gain: FloatArray, edges: FloatArray) -> FloatArray:
    """Return the `gain` (n, 5) of a recording cut at `edges`, (n, 5, cells)."""
    time = residual.whiteners[run].prepared.time
    cells = np.zeros((*gain.shape, len(edges) - 1))
    index = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(edges) - 2)
    cells[np.arange(len(index)), :, index] = gain
    return cells
