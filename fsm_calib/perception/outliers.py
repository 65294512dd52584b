"""Corners and views that do not belong: found with the most flexible model, so that a stiff lens is not
to blame.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.perception.bundle import corner_distances, robust_sigma
from fsm_calib.perception.solve_settings import SolveSettings
from fsm_calib.types import FloatArray


def kept_corners(residual: FloatArray, kept: FloatArray, settings: SolveSettings) -> FloatArray:
    """Return which corners stay, (views, n) of 0 or 1: those within so many noise deviations of their
    prediction.
    """
    limit = max(settings.outlier_sigmas * robust_sigma(residual, kept), settings.smallest_outlier_px)
    return np.asarray(kept * (corner_distances(residual) <= limit))


def bad_views(
    residual: FloatArray, kept: FloatArray, settings: SolveSettings, seen: FloatArray | None = None
) -> dict[int, str]:
    """Return the views to drop and why: too many outliers among the corners `seen`, or far worse than the others."""
    shown = np.full(len(kept), kept.shape[1]) if seen is None else np.maximum(seen.sum(axis=1), 1.0)
    lost = 1.0 - kept.sum(axis=1) / shown
    squares = np.where(kept > 0.0, corner_distances(residual), 0.0) ** 2
    rms = np.sqrt(squares.sum(axis=1) / np.maximum(kept.sum(axis=1), 1.0))
    typical = float(np.median(rms))
    limit = max(settings.worst_ratio * typical, 2.0 * settings.smallest_outlier_px)
    reasons = {}
    for view in np.nonzero((lost > settings.worst_share) | (rms > limit))[0]:
        share, worse = 100.0 * lost[view], rms[view]
        reasons[int(view)] = (
            f"its corners do not fit the other views: {worse:.2f} px rms against {typical:.2f} px, "
            f"{share:.0f} % of them outliers"
        )
    return reasons
