"""k_i of one drive (paper, Eq. 3), as corrected and as published, and the combination of many drives.

Corrected: with v_l, v_r the wheels' true speeds over a path of length s [m], the robot turns by
Delta = (v_r - v_l) / L * s / v [rad, counter-clockwise], so the relative mismatch is e = (v_r - v_l) / v =
Delta L / s,
and the right command must change by::

    k_i - 1 = -Delta L / s

s comes from the markers, so neither the wheel radius nor the unit of the command matters, and Delta = 0
gives k_i = 1 whatever k is in use.

Published (text and program): k_i = (w1 + Delta_m L / (t R)) / w2 with w1 the left command taken as rad/s, w2
= k w1, R = 0.066 m (the diameter) and Delta_m the change of the marker's angle about the optical axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.heading_adjustment import Headings, adjust_headings
from fsm_calib.actions.markers import heading_sd
from fsm_calib.actions.notebook import MarkerReading, WheelRun
from fsm_calib.types import FloatArray, TagObservation, wrap_angle

_LEAST_SD = 1e-4  # rad; no heading is better
_SCATTER_ROUNDS = 3
_SCATTER_PRIOR = 4.0  # drives that the prior on the scatter counts for [1]
_GAIN_PRIOR = 1.0 / 0.2**2  # weight of the prior loop gain 1 +- 0.2: axles differ by less [1]


def run_from_readings(bench: Bench, distance: float) -> WheelRun:
    """Return the drive between the last two readings of the notebook, `distance` [m] long."""
    notebook, settings = bench.notebook, bench.settings.ratio
    if bench.settings.marker.heading == "camera" or bench.settings.marker.nearest == "last":
        before, after = notebook.readings[-2:]
        turned, sd = -wrap_angle(after.heading - before.heading), bench.settings.marker.heading_sd
    else:
        turned, sd = turn_of(bench, notebook.readings)
    if settings.equation == "published":
        k_i = published_k(bench, turned, notebook.last_ratio, notebook.last_duration)
    else:
        k_i = 1.0 - turned * settings.axle_length / distance
    return WheelRun(notebook.last_ratio, notebook.last_duration, distance, turned, max(sd, _LEAST_SD), k_i)


def turn_of(bench: Bench, readings: Sequence[MarkerReading]) -> tuple[float, float]:
    """Return the turn between the last two readings [rad] and its standard deviation, all readings adjusted
    at once.
    """
    headings = adjusted(bench, readings)
    return headings.turned(len(readings) - 2, len(readings) - 1)


def adjusted(bench: Bench, readings: Sequence[MarkerReading]) -> Headings:
    """Return the headings of all readings, adjusted at once with the settings' noise."""

    def noise(tag: TagObservation) -> float:
        return heading_sd(bench, tag)

    return adjust_headings(readings, noise, bench.settings.marker.placement_sd)


def published_k(bench: Bench, turned: float, ratio: float, duration: float) -> float:
    """Return k_i by the published equation: (w1 + Delta_m L / (t R)) / (k w1), Delta_m = -turned."""
    settings = bench.settings.ratio
    left = bench.notebook.drive_command or bench.settings.drive.command
    rate = -turned * settings.axle_length / (duration * settings.published_radius)
    return (left + rate) / (ratio * left)


@dataclass(frozen=True, slots=True)
class Combined:
    """k from all drives together and its standard error [1]."""

    ratio: float
    error: float


def combined_ratio(bench: Bench) -> Combined:
    """Return k from all drives together by weighted least squares.

    Drive i with ratio k_i' and residual r_i = k_i - 1 says k = k_i' + r_i / g with g the gain of the loop,
    estimated from the drives at different k (1 when they do not tell; between a half and two). The variance
    of r_i has two parts: the heading's, (sd(turned) L / s)^2, and that of the drive itself, q^2 / s, because
    wheels never repeat a drive exactly; q is estimated from the scatter of the drives, beginning at
    `run_scatter`. All turns are adjusted again with every reading known so far.
    """
    notebook, settings = bench.notebook, bench.settings.ratio
    headings = adjusted(bench, notebook.readings)
    rows = []
    for index, run in enumerate(notebook.runs):
        turned, sd = headings.turned(2 * index, 2 * index + 1)
        scale = settings.axle_length / run.distance
        if abs(turned * scale) <= settings.combine_within:
            rows.append((run.wheel_ratio, -turned * scale, max(sd, _LEAST_SD) * scale, run.distance))
    if not rows:
        return Combined(notebook.wheel_ratio, math.inf)
    ratio, residual, sd, distance = np.array(rows).T
    scatter = settings.run_scatter**2
    for _ in range(_SCATTER_ROUNDS):
        weight = 1.0 / (sd**2 + scatter / distance)
        values = corrected(ratio, residual / _loop_gain(ratio, residual, weight))
        mean = float(np.average(values, weights=weight))
        scatter = drive_scatter(values - mean, sd, distance, settings.run_scatter)
    return Combined(mean, float(np.sqrt(1.0 / weight.sum())))


def drive_scatter(apart: FloatArray, sd: FloatArray, distance: FloatArray, prior: float) -> float:
    """Return q^2, the variance of k over 1 m that the drives themselves make [m]: wheels never repeat one exactly.

    What the drives lie `apart` from their mean [1] beyond the headings' `sd` [1], over their distances [m]; it begins
    at `prior`^2, which counts for some drives.
    """
    excess = float(np.sum(distance * (apart**2 - sd**2)))
    return (_SCATTER_PRIOR * prior**2 + max(excess, 0.0)) / (_SCATTER_PRIOR + len(apart) - 1)


def corrected(ratio: FloatArray, residual: FloatArray) -> FloatArray:
    """Return the k that drives straight, from a drive with `ratio` and its residual k_i - 1 [1].

    With e = 1 - k_i = (v_r - v_l) / v the wheels' speeds are in the ratio v_r / v_l = (2 + e) / (2 - e),
    which k must undo: k (2 - e) / (2 + e). The paper's k + (k_i - 1) is its first order at k = 1; it halves
    the step and repeats, so it may be off by the factor k, a single correction may not.
    """
    return np.asarray(ratio * (2.0 + residual) / (2.0 - residual))


def _loop_gain(ratio: FloatArray, residual: FloatArray, weight: FloatArray) -> float:
    """Return g of r = g (k - k') with a prior of 1 +- 0.2 from the nominal axle."""
    mean_ratio = np.average(ratio, weights=weight)
    mean_residual = np.average(residual, weights=weight)
    spread = float(np.sum(weight * (ratio - mean_ratio) ** 2))
    slope = -float(np.sum(weight * (ratio - mean_ratio) * (residual - mean_residual)))
    return float(np.clip((slope + _GAIN_PRIOR) / (spread + _GAIN_PRIOR), 0.5, 2.0))
