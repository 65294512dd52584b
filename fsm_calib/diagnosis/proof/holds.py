r"""Does a match hold on recordings that took no part in the fit? Its tail is asked, in blocks, not its median.

For every block of a few seconds the median over its prediction windows of r = error / floor, position and heading; the
floor is the median error that the noise alone would give, so that for normal errors

    P(r > x) = 2^(-x^2)  of a position (Rayleigh),     2 (1 - Phi(NORMAL_MEDIAN x))  of a heading

A block speaks against the match where P < ALPHA / number of tests (Bonferroni). Assumes that the errors within a block
are one and the same (windows of 2 s that start every quarter of a second nearly are). Clean robots reach 2 to 2.2 of
the noise in position, a tether that is taut in one corner 5.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from fsm_calib.diagnosis.proof.windows import NORMAL_MEDIAN, Windows
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.shapes.score_tests import ALPHA
from fsm_calib.types import FloatArray

BLOCK = 2.0  # s: the horizon of a prediction
FEWEST = 3  # windows in a block: fewer, and one bad frame decides


@dataclass(frozen=True, slots=True)
class Breach:
    """Where a match does not hold: number of the recording, span [s], middle and radius [m] of the path in its worst
    block, error over noise.
    """

    recording: int
    start: float
    end: float
    x: float
    y: float
    radius: float
    ratio: float


def breach_of(windows: Sequence[Windows], simulators: Sequence[Simulator]) -> Breach | None:
    """Return the worst stretch of recordings that a model does not predict; None where it holds.

    windows : the model's prediction errors on each recording; simulators : of the same recordings.
    """
    blocks = [_blocks(w) for w in windows]
    limits = _limits(sum(len(ratios) for _, ratios in blocks))
    worst: Breach | None = None
    for run, (times, ratios) in enumerate(blocks):
        over = np.nanmax(ratios / limits, axis=1, initial=0.0) if len(ratios) else np.zeros(0)
        if len(over) and over.max() > 1.0:
            at = int(np.argmax(over))
            first, last = _stretch(over > 1.0, at)
            ratio = float(np.nanmax(ratios[at]))
            if worst is None or ratio > worst.ratio:
                place = _place(simulators[run], times[at], times[at] + BLOCK)
                worst = Breach(run, float(times[first]), float(times[last] + BLOCK), *place, ratio)
    return worst


def _ratios(windows: Windows) -> FloatArray:
    """Return the errors over their floors, position and heading, shape (w, 2)."""
    size = np.column_stack([np.hypot(windows.error[:, 0], windows.error[:, 1]), np.abs(windows.error[:, 2])])
    return size / np.maximum(windows.floor, 1e-12)


def _blocks(windows: Windows) -> tuple[FloatArray, FloatArray]:
    """Return the beginnings (b,) [s] of the blocks, and the medians of their ratios (b, 2)."""
    if not len(windows.time):
        return np.zeros(0), np.zeros((0, 2))
    ratios, block = _ratios(windows), np.floor(windows.time / BLOCK).astype(int)
    kept = [b for b in np.unique(block) if np.sum(block == b) >= FEWEST]
    medians = np.array([np.median(ratios[block == b], axis=0) for b in kept]).reshape(-1, 2)
    return BLOCK * np.array(kept, dtype=float), medians


def _limits(blocks: int) -> FloatArray:
    """Return the ratios that chance exceeds once in `1 / ALPHA` robots, position and heading."""
    alpha = ALPHA / max(2 * blocks, 1)
    return np.array([np.sqrt(-np.log2(alpha)), -ndtri(0.5 * alpha) / NORMAL_MEDIAN])


def _stretch(over: np.ndarray, at: int) -> tuple[int, int]:
    """Return the first and the last of the blocks around `at` that are over their limit without a break."""
    first = last = at
    while first > 0 and over[first - 1]:
        first -= 1
    while last + 1 < len(over) and over[last + 1]:
        last += 1
    return first, last


def _place(simulator: Simulator, start: float, end: float) -> tuple[float, float, float]:
    """Return where the robot was between two times [s]: middle x, y and radius [m]."""
    p = simulator.prepared
    path = p.reference[(p.time >= start) & (p.time <= end), :2]
    x, y = path.mean(axis=0)
    return float(x), float(y), float(np.hypot(path[:, 0] - x, path[:, 1] - y).max())
