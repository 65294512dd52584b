"""Robust maximum likelihood for rows of one to three numbers: Student-t noise, iteratively re-weighted least
squares.

Model: y_k = f_k(p) + e_k, e_k of Student's t with NU degrees of freedom and scatter S (d x d), rows
independent or, with `correlated` > 0, dependent over that many rows. The weight of a row is w = (NU + d) /
(NU + e' S^-1 e) and S is the weighted mean of w e e' (the EM algorithm; Lange, Little, Taylor 1989, DOI
10.1080/01621459.1989.10478852, sec. 3). Standard deviations come from the sandwich A^-1 B A^-1 (Huber 1967;
Newey, West 1987, DOI 10.2307/1913610, for correlated rows), which stays honest when the noise is not the
assumed one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from fsm_calib.types import FloatArray

NU = (
    4.0  # degrees of freedom; bounds the pull of 1 to 5 % outliers and costs a few per cent on Gaussian noise
)
ROUNDS = 60  # re-weighting rounds at most; 10 to 20 are usual
SETTLED = (
    1e-6  # a round that moves no parameter by more than this share of its standard deviation ends the fit
)
OUTLIER_WEIGHT = 0.25  # a row of lower weight (4.5 scatters away) is counted as an outlier
WORST = 0.01  # share of rows that no covariance counts (closest to what Censi et al. 2013 published)
ONE_SIDED = 1e-6  # significance at which outliers are said to err to one side (Hotelling's test)

Model = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class RobustFit:
    """Result: `parameters` (p,), `covariance` (p, p), `scatter` S (d, d), `weights` (n,), `residuals` (n, d).

    `covariance_with_outliers` (p, p) takes the scatter of all rows but the worst `WORST` for the noise.
    """

    parameters: FloatArray
    covariance: FloatArray
    covariance_with_outliers: FloatArray
    scatter: FloatArray
    weights: FloatArray
    residuals: FloatArray

    @property
    def outliers(self) -> int:
        """How many rows are too far off to be the noise that the others show."""
        return int(self.outlying.sum())

    @property
    def outlying(self) -> NDArray[np.bool_]:
        """Which rows are outliers, shape (n,)."""
        return self.weights < OUTLIER_WEIGHT

    @property
    def outliers_have_a_cause(self) -> bool:
        """Whether the outliers err to one side, so that they are no random noise.

        Hotelling's test (1931, DOI 10.1214/aoms/1177732979) of the outliers' mean against zero: with m outliers,
        mean e (d,), covariance C (d, d), T2 = m e' C^-1 e is distributed as d (m - 1) / (m - d) F(d, m - d).
        """
        rows = self.residuals[self.outlying]
        count, dimension = rows.shape
        if count < 3 * dimension + 1:
            return False
        covariance = np.atleast_2d(np.cov(rows, rowvar=False)) + 1e-24 * np.eye(dimension)
        mean = rows.mean(axis=0)
        statistic = count * float(mean @ np.linalg.solve(covariance, mean))
        ratio = statistic * (count - dimension) / (dimension * (count - 1))
        return bool(fdtrc(dimension, count - dimension, ratio) < ONE_SIDED)


def robust_fit(
    model: Model, measured: FloatArray, start: FloatArray, scale: FloatArray, correlated: int = 0
) -> RobustFit:
    """Fit `model(p)`, shape (n, d), to `measured`, shape (n, d).

    start : first guess (p,); scale : size (p,) of each parameter, for the differences of the Jacobian.
    """
    parameters = np.array(start, dtype=float)
    residuals = measured - model(parameters)
    scatter = _first_scatter(residuals)
    weights = np.ones(len(measured))
    for _ in range(ROUNDS):
        jacobian = jacobian_of(model, parameters, scale)
        inverse = np.linalg.inv(scatter).astype(np.float64)
        information = np.einsum("n,nci,cd,ndj->ij", weights, jacobian, inverse, jacobian, optimize=True)
        gradient = np.einsum("n,nci,cd,nd->i", weights, jacobian, inverse, residuals, optimize=True)
        step = scaled_solve(information, gradient, scale)
        parameters, residuals = _line_search(model, measured, parameters, step, inverse)
        distance = np.einsum("nc,cd,nd->n", residuals, inverse, residuals, optimize=True)
        dimension = measured.shape[1]
        weights = (NU + dimension) / (NU + distance)
        scatter = np.einsum("n,nc,nd->cd", weights, residuals, residuals) / len(residuals)
        scatter += 1e-12 * np.trace(scatter) * np.eye(dimension) + 1e-24 * np.eye(dimension)
        if (step**2 * np.diag(information) < SETTLED**2).all():
            break
    jacobian = jacobian_of(model, parameters, scale)
    covariance = _sandwich(jacobian, residuals, weights, scatter, scale, correlated)
    return RobustFit(
        parameters, covariance, _with_outliers(jacobian, residuals, scale), scatter, weights, residuals
    )


def jacobian_of(model: Model, parameters: FloatArray, scale: FloatArray) -> FloatArray:
    """Return the central-difference Jacobian of `model`, shape (n, d, p)."""
    columns = []
    for i, size in enumerate(scale):
        step = np.zeros(len(parameters))
        step[i] = 1e-5 * size
        columns.append((model(parameters + step) - model(parameters - step)) / (2e-5 * size))
    return np.stack(columns, axis=-1)


def scaled_inverse(information: FloatArray, scale: FloatArray) -> FloatArray:
    """Invert an information matrix in units of `scale`; what the data does not tell gets a huge variance."""
    unitless = information * np.outer(scale, scale)
    values, vectors = np.linalg.eigh((unitless + unitless.T) / 2.0)
    floor = max(float(values[-1]), 1e-300) * 1e-13
    inverse = (vectors / np.maximum(values, floor)) @ vectors.T
    return np.asarray(inverse * np.outer(scale, scale))


def scaled_solve(information: FloatArray, gradient: FloatArray, scale: FloatArray) -> FloatArray:
    """Solve for a Gauss-Newton step, with a touch of damping in directions that the data does not tell."""
    unitless = information * np.outer(scale, scale)
    unitless += np.eye(len(scale)) * max(float(np.trace(unitless)), 1e-300) * 1e-12
    return np.linalg.solve(unitless, gradient * scale) * scale


def _first_scatter(residuals: FloatArray) -> FloatArray:
    spread = 1.4826 * np.median(np.abs(residuals), axis=0)
    return np.diag(np.maximum(spread, 1e-9) ** 2)


def _line_search(
    model: Model, measured: FloatArray, start: FloatArray, step: FloatArray, inverse: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Halve the step until the robust cost falls; return the new parameters and residuals."""

    def cost(residuals: FloatArray) -> float:
        distance = np.einsum("nc,cd,nd->n", residuals, inverse, residuals, optimize=True)
        return float(np.log1p(distance / NU).sum())

    before = cost(measured - model(start))
    for halving in range(8):
        trial = start + step * 0.5**halving
        residuals = measured - model(trial)
        if cost(residuals) <= before:
            return trial, residuals
    return start, measured - model(start)


def _sandwich(
    jacobian: FloatArray,
    residuals: FloatArray,
    weights: FloatArray,
    scatter: FloatArray,
    scale: FloatArray,
    correlated: int,
) -> FloatArray:
    """Return A^-1 B A^-1 with the Bartlett-weighted lags of Newey and West up to `correlated` rows."""
    inverse = np.linalg.inv(scatter)
    scores = np.einsum("n,nci,cd,nd->ni", weights, jacobian, inverse, residuals, optimize=True)
    dimension = residuals.shape[1]
    distance = np.einsum("nc,cd,nd->n", residuals, inverse, residuals, optimize=True)
    # derivative of the score: w (S^-1 - 2 S^-1 e e' S^-1 / (NU + distance))
    bent = np.einsum("cd,nd->nc", inverse, residuals)
    curvature = weights[:, None, None] * (
        inverse - 2.0 * np.einsum("nc,nd->ncd", bent, bent) / (NU + distance)[:, None, None]
    )
    bread = scaled_inverse(np.einsum("nci,ncd,ndj->ij", jacobian, curvature, jacobian, optimize=True), scale)
    meat = scores.T @ scores
    for lag in range(1, correlated + 1):
        cross = scores[lag:].T @ scores[:-lag]
        meat += (1.0 - lag / (correlated + 1.0)) * (cross + cross.T)
    rows, count = residuals.shape[0] * dimension, jacobian.shape[2]
    return np.asarray(bread @ meat @ bread * rows / max(rows - count, 1))


def _with_outliers(jacobian: FloatArray, residuals: FloatArray, scale: FloatArray) -> FloatArray:
    """Return the covariance of plain least squares when the noise is the scatter of all rows but the worst."""
    spread = np.maximum(1.4826 * np.median(np.abs(residuals), axis=0), 1e-12)
    farness = ((residuals / spread) ** 2).sum(axis=1)
    counted = np.argsort(farness)[: int(np.ceil(len(farness) * (1.0 - WORST)))]
    variance = np.maximum(residuals[counted].var(axis=0), 1e-24)
    kept = jacobian[counted]
    information = np.einsum("nci,c,ncj->ij", kept, 1.0 / variance, kept, optimize=True)
    return scaled_inverse(information, scale)
