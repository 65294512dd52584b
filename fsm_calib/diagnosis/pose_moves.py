"""How poses move from step to step, and a robust linear fit of it: what readings of the wheels are told apart by."""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.likelihood.robust import log_density, robust_weights
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.types import FloatArray

FEWEST_STEPS = 50  # steps between poses, to tell two readings apart
FREEDOM = 4.0  # degrees of freedom of the residuals' Student distribution
REWEIGHTED = 6  # rounds of iteratively reweighted least squares; four suffice


def moves_between(pose: PoseTrack, least: float) -> tuple[FloatArray, FloatArray] | None:
    """Return (n, 2) start and end [s] of steps of `least` [s] and more between poses and what was measured over them,
    (n, 1 or 2): the turn [rad] and, where places were measured, the way forward [m]; None where there are too few.
    """
    known = np.flatnonzero(np.isfinite(pose.theta))
    if len(known) < 2:
        return None
    every = max(1, round(least / float(np.median(np.diff(pose.time[known])))))
    track = pose.rows(known).rows(slice(None, None, every))
    time, theta = track.time, np.unwrap(track.theta)
    if len(time) <= FEWEST_STEPS:
        return None
    whole = np.diff(time) < 3.0 * float(np.median(np.diff(time)))
    if whole.sum() < FEWEST_STEPS:
        return None
    turn, middle = np.diff(theta), 0.5 * (theta[1:] + theta[:-1])
    ahead = np.cos(middle) * np.diff(track.x) + np.sin(middle) * np.diff(track.y)
    columns = [turn, ahead] if np.isfinite(ahead).all() else [turn]
    return np.column_stack([time[:-1], time[1:]])[whole], np.column_stack(columns)[whole]


def student_fit(design: FloatArray, target: FloatArray) -> tuple[FloatArray, float]:
    """Return coefficients (p,) and scale of `target` (n,) given `design` (n, p), by reweighted least squares."""
    weight, scale = np.ones(len(target)), 1.0
    found: FloatArray = np.zeros(design.shape[1])
    for _ in range(REWEIGHTED):
        root = np.sqrt(weight)
        found = np.asarray(np.linalg.lstsq(design * root[:, None], target * root, rcond=None)[0])
        left = target - design @ found
        scale = float(np.sqrt(np.mean(weight * left**2))) + 1e-12
        weight = robust_weights(left / scale, FREEDOM)
    return found, scale


def log_densities(left: FloatArray, scale: float) -> FloatArray:
    """Return the log density of each residual in `left` (..., n) by the Student distribution of a scale."""
    return log_density(left / scale, np.full(left.shape[-1], -np.log(scale)), FREEDOM)


def log_likelihood_of(moved: FloatArray, design: FloatArray) -> float:
    """Return the log-likelihood of the columns of `moved` (n, c) given `design` (n, p), each column fitted alone."""
    fits = [(column, *student_fit(design, column)) for column in moved.T]
    return sum(float(log_densities(column - design @ found, scale).sum()) for column, found, scale in fits)
