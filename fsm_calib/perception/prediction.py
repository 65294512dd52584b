"""How far a calibration is from the truth, over the whole image: predicted from its covariance, or measured.

The number everywhere is "al": the distance in the image between two cameras' projections of the same ray,
root mean square over a 25x19 grid of the whole image, after the best rotation between the two has been
removed (the rotation is absorbed by the later calibration of the camera against the floor). mrcal calls this
a projection difference at infinity. For small errors, with q the grid's image points, theta the intrinsics
and rho a rotation [rad]::

    dq = J_theta dtheta + J_rho rho,   A = (I - J_rho J_rho^+) J_theta,   M = C A'A / grid points

with C the covariance of theta. The squared error is then a sum of l_i z_i^2, l_i the eigenvalues of M, z_i standard
normal. Its mean, expected^2 = trace M, is what uncertainties are usually told by; but one direction often holds most of
it, and a calibration in fifty is beyond twice the root. What is promised is therefore a quantile: the predicted error
is what 95 of 100 such calibrations stay within, from the gamma distribution with the sum's mean and variance,

    predicted^2 = g chi2_h(0.95),   g = trace M^2 / trace M,   h = (trace M)^2 / trace M^2,

right to 0.5 % of the error for one direction and for many. Sources: Kogan, mrcal documentation, "projection
uncertainty" and "differencing"; Welch and Satterthwaite's formula, as in the Guide to the Expression of Uncertainty in
Measurement, annex G.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from fsm_calib.perception.lens import intrinsics_vector, project, project_with_derivatives, unproject
from fsm_calib.perception.rotations import rotation_from_vector, skew
from fsm_calib.types import CameraModel, FloatArray

GRID = (25, 19)  # columns and rows of grid points over the image
COVERAGE = 0.95  # of calibrations stay within the predicted error: metrology's usual level of confidence
_ROTATION_STEPS = 20  # Gauss-Newton steps of the best rotation; 3 to 5 are used


@dataclass(frozen=True, eq=False)
class ImageError:
    """An error over the image: grid (19, 25) [px], top row first, and its summaries [px]."""

    grid: FloatArray

    @property
    def rms(self) -> float:
        """Root mean square over the grid [px]: "al"."""
        return float(np.sqrt(np.mean(self.grid**2)))

    @property
    def max(self) -> float:
        """Largest value of the grid [px]."""
        return float(self.grid.max())


@dataclass(frozen=True, eq=False)
class PredictedError(ImageError):
    """What 95 of 100 such calibrations stay within, over the image; `rms` is "the predicted error" [px].

    expected : root of the mean squared error over the image that the covariance gives [px], the usual uncertainty (one
    standard deviation). The grid is its distribution over the image, raised to the quantile.
    """

    expected: float


def image_grid(image_size: tuple[int, int]) -> FloatArray:
    """Return the grid's image points, shape (475, 2) [px], row by row, from corner to corner of the image."""
    columns = np.linspace(0.0, image_size[0] - 1.0, GRID[0])
    rows = np.linspace(0.0, image_size[1] - 1.0, GRID[1])
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def _directions(intrinsics: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    rays = unproject(intrinsics, image_grid(image_size))
    rays = np.column_stack([rays, np.ones(len(rays))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def sensitivity(intrinsics: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return A, shape (950, s) [px per unit]: motion of the grid by the intrinsics, rotation removed."""
    points = _directions(intrinsics, image_size)
    _, by_point, by_intrinsics = project_with_derivatives(intrinsics, points)
    by_rotation = (-by_point @ skew(points)).reshape(-1, 3)
    motion = by_intrinsics.reshape(-1, intrinsics.size)
    basis, _ = np.linalg.qr(by_rotation)
    return motion - basis @ (basis.T @ motion)


def predicted_error(motion: FloatArray, covariance: FloatArray) -> PredictedError:
    """Return the predicted error over the image from `sensitivity` (950, s) and the intrinsics'
    covariance (s, s).
    """
    variance = np.einsum("ij,jk,ik->i", motion, covariance, motion).reshape(-1, 2).sum(axis=1)
    deviation = np.sqrt(np.maximum(variance, 0.0)).reshape(GRID[::-1])
    factor = _quantile_factor(covariance @ (motion.T @ motion))
    return PredictedError(factor * deviation, float(np.sqrt(np.mean(deviation**2))))


def _quantile_factor(moments: FloatArray) -> float:
    """Return the predicted over the expected error from M (s, s), up to a factor; 1 where nothing is uncertain."""
    mean, half_variance = float(np.trace(moments)), float(np.sum(moments * moments.T))
    if mean <= 0.0 or not np.isfinite(half_variance):
        return 1.0
    half_freedom = 0.5 * mean**2 / half_variance
    return float(np.sqrt(gammaincinv(half_freedom, COVERAGE) / half_freedom))


def projection_difference(first: CameraModel, second: CameraModel) -> ImageError:
    """Return how differently two cameras see the same rays, over the image of `first`, best rotation
    removed.
    """
    size, other = (first.width, first.height), intrinsics_vector(second)
    points = _directions(intrinsics_vector(first), size)
    wanted, rotation = image_grid(size), np.eye(3)
    for _ in range(_ROTATION_STEPS):
        turned = points @ rotation.T
        image, by_point, _ = project_with_derivatives(other, turned)
        by_rotation = (-by_point @ skew(turned)).reshape(-1, 3)
        step, *_ = np.linalg.lstsq(by_rotation, (wanted - image).ravel(), rcond=None)
        rotation = rotation_from_vector(np.asarray(step, dtype=float)) @ rotation
        if float(np.linalg.norm(step)) < 1e-10:
            break
    difference = project(other, points @ rotation.T) - wanted
    return ImageError(np.linalg.norm(difference, axis=1).reshape(GRID[::-1]))
