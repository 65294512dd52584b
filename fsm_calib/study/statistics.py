"""Figures with intervals: percentile bootstrap, Wilson's interval for shares, Spearman's rank correlation.

Sources: Efron and Tibshirani, An Introduction to the Bootstrap, chapter 13 (percentile interval); Wilson,
J. Am. Stat. Assoc. 22, 209 (1927); Spearman, Am. J. Psychol. 15, 72 (1904). All intervals are of 95 %.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

from fsm_calib.types import FloatArray

RESAMPLES = 4000
"""Resamples of one bootstrap."""
TAIL = 2.5
"""Per cent of the resamples beyond either end of an interval."""
NORMAL_QUANTILE = 1.959964
"""97.5 % quantile of the standard normal distribution."""
FEWEST_FOR_INTERVAL = 3
"""Of fewer values no interval is told."""
FEWEST_FOR_CORRELATION = 8
"""Of fewer pairs the bootstrap of a rank correlation tells nothing: its resamples are mostly ties."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure, the ends of its 95 % interval (nan where there are too few values), and of how many values."""

    value: float
    low: float
    high: float
    count: int

    @property
    def excludes_zero(self) -> bool:
        """Tell whether the interval lies on one side of zero."""
        return bool(self.low > 0.0 or self.high < 0.0)


Statistic = Callable[[FloatArray], FloatArray]
"""Takes values of shape (..., n) to figures of shape (...)."""


def median_of(values: FloatArray) -> FloatArray:
    """Return the median along the last axis."""
    return np.asarray(np.median(values, axis=-1))


def mean_of(values: FloatArray) -> FloatArray:
    """Return the mean along the last axis."""
    return np.asarray(np.mean(values, axis=-1))


def estimate(values: FloatArray, statistic: Statistic, rng: np.random.Generator) -> Estimate:
    """Return a figure of independent values with its bootstrap interval.

    Parameters
    ----------
    values : array, shape (n,)
        Values that are nan are left out.
    statistic : callable
    rng : numpy.random.Generator
    """
    known = values[np.isfinite(values)]
    if known.size == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    value = float(statistic(known))
    if known.size < FEWEST_FOR_INTERVAL:
        return Estimate(value, math.nan, math.nan, known.size)
    picks = rng.integers(0, known.size, (RESAMPLES, known.size))
    low, high = np.percentile(statistic(known[picks]), [TAIL, 100.0 - TAIL])
    return Estimate(value, float(low), float(high), known.size)


def share(hits: int, count: int) -> Estimate:
    """Return the share `hits` of `count` with Wilson's interval [1]."""
    if count == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    z2, p = NORMAL_QUANTILE**2, hits / count
    middle = (p + z2 / (2.0 * count)) / (1.0 + z2 / count)
    half = NORMAL_QUANTILE * math.sqrt(p * (1.0 - p) / count + z2 / (4.0 * count**2)) / (1.0 + z2 / count)
    return Estimate(p, max(0.0, middle - half), min(1.0, middle + half), count)


def rank_correlation(x: FloatArray, y: FloatArray, rng: np.random.Generator) -> Estimate:
    """Return Spearman's rho of pairs with the bootstrap interval over pairs; pairs with a nan are left out.

    Parameters
    ----------
    x, y : array, shape (n,)
    rng : numpy.random.Generator
    """
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if x.size < FEWEST_FOR_CORRELATION or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return Estimate(math.nan, math.nan, math.nan, x.size)
    picks = rng.integers(0, x.size, (RESAMPLES, x.size))
    resampled = _spearman(x[picks], y[picks])
    low, high = np.nanpercentile(resampled, [TAIL, 100.0 - TAIL])
    return Estimate(float(_spearman(x[None], y[None])[0]), float(low), float(high), x.size)


def _spearman(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the correlation of the ranks of each row, shapes (m, n) to (m,); nan for a row of one value."""
    a, b = (rankdata(values, axis=1) for values in (x, y))
    a, b = (ranks - ranks.mean(axis=1, keepdims=True) for ranks in (a, b))
    spread = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((a * b).sum(axis=1) / spread)
