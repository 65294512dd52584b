"""How the robot turned between readings, from all markers of all readings at once.

Reading i sees marker j at h_ij = e_j - theta_i + noise, with theta_i the robot's heading and e_j the
marker's own orientation error [rad], both against the common direction of the markers. The paper trusts e_j
= 0; here e_j is unknown with standard deviation `placement_sd`, and all e_j and theta_i follow from one
weighted least-squares fit. A marker that is seen before and after a drive then tells the turn without its
own error, and one that is seen in many drives is learnt.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.actions.notebook import MarkerReading
from fsm_calib.types import FloatArray, TagObservation

_ROBUST_ROUNDS = 3
_ROBUST_LIMIT = 2.5  # residuals beyond this many standard deviations lose weight [1]


@dataclass(frozen=True, eq=False)
class Headings:
    """Headings theta [rad] of all readings, shape (n,), and their covariance [rad^2], shape (n, n)."""

    theta: FloatArray
    covariance: FloatArray

    def turned(self, first: int, second: int) -> tuple[float, float]:
        """Return the turn from one reading to another, counter-clockwise [rad], and its standard
        deviation.
        """
        variance = (
            self.covariance[first, first]
            + self.covariance[second, second]
            - 2.0 * self.covariance[first, second]
        )
        return float(self.theta[second] - self.theta[first]), float(np.sqrt(max(variance, 0.0)))


def adjust_headings(
    readings: Sequence[MarkerReading],
    noise: Callable[[TagObservation], float],
    placement_sd: float,
    heading: Callable[[TagObservation], float] = lambda tag: tag.heading,
) -> Headings:
    """Return the headings of all readings.

    Parameters
    ----------
    readings : sequence of MarkerReading
        At least one; no reading is empty.
    noise : callable
        Standard deviation of a marker's measured heading [rad].
    placement_sd : float
        Standard deviation of the markers' orientation errors [rad].
    heading : callable
        The heading that counts [rad].
    """
    numbers = sorted({tag.tag_id for reading in readings for tag in reading.tags})
    column = {number: len(readings) + index for index, number in enumerate(numbers)}
    rows, values, weights = [], [], []
    for index, reading in enumerate(readings):
        origin = heading(reading.tags[0])
        for tag in reading.tags:
            rows.append((index, column[tag.tag_id]))
            values.append(origin + float(np.remainder(heading(tag) - origin + np.pi, 2.0 * np.pi) - np.pi))
            weights.append(1.0 / noise(tag))
    return _solve(
        np.array(rows), np.array(values), np.array(weights), len(readings), len(numbers), placement_sd
    )


def _solve(
    rows: FloatArray,
    values: FloatArray,
    weights: FloatArray,
    readings: int,
    markers: int,
    placement_sd: float,
) -> Headings:
    """Solve h = e - theta with the prior e ~ N(0, placement_sd^2); residuals beyond the limit lose weight."""
    design = np.zeros((len(values), readings + markers))
    design[np.arange(len(values)), rows[:, 0]] = -1.0
    design[np.arange(len(values)), rows[:, 1]] = 1.0
    prior = np.zeros(readings + markers)
    prior[readings:] = 1.0 / placement_sd**2
    robust = np.ones(len(values))
    for _ in range(_ROBUST_ROUNDS):
        scaled = design * (weights * robust)[:, None]
        covariance = np.linalg.inv(scaled.T @ scaled + np.diag(prior))
        solution = covariance @ (scaled.T @ (values * weights * robust))
        size = np.abs(design @ solution - values) * weights
        robust = np.sqrt(np.minimum(1.0, _ROBUST_LIMIT / np.maximum(size, 1e-9)))
    return Headings(solution[:readings].astype(float), covariance[:readings, :readings].astype(float))
