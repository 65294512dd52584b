"""When did a motor lose contact, again and again? Short spans of one recording that stand out together.

A loose plug opens for a moment, ten times a drive: no span of it lasts, and each alone is a push as well. So spans of
up to LONGEST are fitted each by itself in the seconds in which it shows, by reweighted least squares as pushes are
(`scan_pushes.py`: of what is an outlier a score test sees no more than its weight), the best that do not overlap are
kept, and what stands out of these together (`outstanding.py`) is one effect with one loss. One alone is offered where
its motor loses much: a fit that starts from a long span of a small loss does not find a short one of all of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsm_calib.diagnosis.candidates.outstanding import MOMENTS, by_chance, standing_out
from fsm_calib.diagnosis.candidates.scan_pushes import APART, GAP, SEEN, innovations_of
from fsm_calib.diagnosis.likelihood.robust import SWEEPS
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray

STEP = 0.25  # s between edges
LONGEST = 3.0  # s: what lasts longer is one span (`scan_spans.py`)
LOSSES = (
    0.005,
    1.5,
)  # smallest and largest loss that counts: to first order a dead motor may lose more than all
FEWEST = 2  # of less than this many each is a span, or a push
ALONE = 0.25  # loss over at least STEP from which one may be a plug that opened once (`plausible.py`)

Cells = Callable[[FloatArray], FloatArray]
Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Blinks:
    """Spans (k, 2) of begin and end [s], most first, the loss that they share [1], what they win, and by which
    chance so much more than the next ones.
    """

    spans: FloatArray
    loss: float
    won: float
    chance: float


def blinks(residual: Residual, run: int, cells: Cells, worth: float, most: int) -> Blinks | None:
    """Return the spans of recording `run` that stand out together; None where none does, or one of a small loss.

    cells : edges (m + 1,) [s] to what acting in each cell between two of them changes in the recording's increments,
    (n, 5, m); worth : log-likelihood that the numbers of one span cost; most : spans at most.
    """
    time = residual.whiteners[run].prepared.time
    edges = np.arange(max(float(time[0]), 0.0), float(time[-1]) - 1.0, STEP)
    if len(edges) < 2:
        return None
    first, last = np.triu_indices(len(edges), 1)
    short = last - first <= round(LONGEST / STEP)
    first, last = first[short], last[short]
    won, loss = _each(residual, run, cells(edges), edges, (first, last))
    chosen = list(_apart(first, last, won, most + MOMENTS))
    size = standing_out([float(won[i]) for i in chosen], worth, most)
    best = chosen[:size]
    if size < FEWEST and not any(loss[i] >= ALONE for i in best):
        return None
    spans = np.column_stack([edges[first[best]], edges[last[best]]])
    shared = float(np.average(loss[best], weights=won[best]))
    return Blinks(spans, shared, float(won[best].sum()), by_chance(won[chosen].tolist(), size))


def _each(
    residual: Residual, run: int, cells: FloatArray, edges: FloatArray, spans: tuple[Places, Places]
) -> tuple[FloatArray, FloatArray]:
    """Return what each span, from its first to its last edge (c,), wins (c,) and by which loss (c,) [1]."""
    period = int(np.ceil((LONGEST + SEEN + GAP) / STEP))
    trains = np.stack([cells[:, :, k::period].sum(axis=2) for k in range(period)], axis=2)
    white = residual.engine.white_columns((residual.whiteners[run],), (trains,))
    times, before = innovations_of(residual, run)
    left = residual.white[before : before + len(times)]
    first, last = spans
    rows = np.searchsorted(times, np.column_stack([edges[first], edges[last] + SEEN]))
    won, amplitude = _fitted(white, left, rows, first, last, residual.engine.nu)
    counts = (amplitude < -LOSSES[0]) & (amplitude > -LOSSES[1])
    return np.where(counts, won, 0.0), -amplitude


@njit(cache=True)
def _fitted(white, left, rows, first, last, nu):  # type: ignore[no-untyped-def]
    """Return what each span wins (c,) and its amplitude (c,), of cells whose columns are white (n, period)."""
    won, amplitudes = np.zeros(len(first)), np.zeros(len(first))
    period = white.shape[1]
    for c in range(len(first)):
        begin, end = rows[c]
        column = np.zeros(end - begin)
        for cell in range(first[c], last[c]):
            column += white[begin:end, cell % period]
        size = 0.0
        for sweep in range(SWEEPS):
            score, power = 0.0, 1e-12
            for k in range(end - begin):
                rest = left[begin + k] - size * column[k]
                weight = (nu + 1.0) / (nu - 2.0 + rest * rest) if sweep else 1.0
                score += weight * column[k] * left[begin + k]
                power += weight * column[k] * column[k]
            size = score / power
        for k in range(end - begin):
            was, rest = left[begin + k], left[begin + k] - size * column[k]
            won[c] += 0.5 * (nu + 1.0) * np.log((nu - 2.0 + was * was) / (nu - 2.0 + rest * rest))
        amplitudes[c] = size
    return won, amplitudes


def _apart(first: Places, last: Places, won: FloatArray, count: int) -> Iterator[int]:
    """Yield the spans that win most, at most `count`, each well apart from those before: one shows for a while."""
    near = round(APART / STEP)
    taken: list[int] = []
    for i in np.argsort(-won).tolist():
        if len(taken) == count or won[i] <= 0.0:
            return
        if all(last[i] + near < first[k] or first[i] > last[k] + near for k in taken):
            taken.append(i)
            yield i
