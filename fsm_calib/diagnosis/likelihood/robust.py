r"""The robust likelihood of whitened innovations, and the noise that makes it largest.

For an innovation e with variance S: log p = log t_nu(e / sqrt(S / c)) - 1/2 log(S / c), c = nu / (nu - 2) so that S
stays the variance. Robust weights w = (nu + 1) / (nu - 2 + e^2 / S) turn it into reweighted least squares.
Source: Lange, Little & Taylor, J. Am. Stat. Assoc. 84 (1989) 881; noise by BHHH (Berndt et al. 1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import lgamma, log, pi

import numpy as np
from numpy.typing import NDArray

from fsm_calib.diagnosis.likelihood.noise import LARGEST_NOISE, SMALLEST_NOISE, Noise
from fsm_calib.diagnosis.likelihood.whitening import covariance_pass, mean_pass, transitions
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.types import FloatArray

LOG_STEP = 0.04  # finite difference of log noise parameters
SWEEPS = 3  # of reweighted least squares, where the rest of a model stands still
PRIOR_SPREAD = 2.0  # log units: a noise level a factor 7 from its start costs half a unit of log-likelihood


@dataclass(frozen=True, eq=False)
class Whitener:
    """The filter of one recording at one noise: whitens residuals and Jacobian columns alike."""

    prepared: Prepared
    moves: FloatArray
    gains: FloatArray
    scale: FloatArray
    jitter: float

    @classmethod
    def at(cls, prepared: Prepared, noise: Noise) -> Whitener:
        """Run the covariance pass."""
        p, levels = prepared, noise.vector()
        moves = transitions(p.dt, p.moving, p.surge, p.anew, levels, p.geometry)
        gains, variance = covariance_pass(
            p.dt, p.rotation, p.step, p.moving, p.seen, p.restart, moves, levels, p.geometry
        )
        return cls(prepared, moves, gains, 1.0 / np.sqrt(variance), noise.jitter)

    def columns(self, increments: FloatArray, measured: bool = False) -> FloatArray:
        """Return whitened columns, shape (N, m), of increments (n, 5, m).

        `measured`: column 0 is a residual (the measurements enter); all others are derivatives.
        """
        p = self.prepared
        out = np.empty((p.innovations, increments.shape[2]))
        mean_pass(
            p.rotation, p.step, p.seen, p.restart, self.moves, self.gains, self.scale, self.jitter,
            np.ascontiguousarray(increments), p.y if measured else np.zeros_like(p.y), out,
        )  # fmt: skip
        return out

    def of_span(self, increments: FloatArray, first: int, last: int) -> FloatArray:
        """Return the rows of `columns` (k, m) that the events from `first` to `last` have, where none before has any.

        increments : (last - first + 1, 5, m), of these events.
        """
        p, here = self.prepared, slice(first, last + 1)
        out = np.empty((int(p.scored[here].sum()), increments.shape[2]))
        mean_pass(
            p.rotation[here], p.step[here], p.seen[here], p.restart[here], self.moves[here], self.gains[here],
            self.scale[here], self.jitter, np.ascontiguousarray(increments), np.zeros_like(p.y[here]), out,
        )  # fmt: skip
        return out

    def residual(self, simulated: FloatArray) -> FloatArray:
        """Return the whitened innovations, shape (N,), of simulated increments (n, 5)."""
        return self.columns((simulated - self.prepared.step)[:, :, None], measured=True)[:, 0]

    @cached_property
    def log_scale(self) -> FloatArray:
        """log(1 / sqrt(S)) of every innovation, shape (N,)."""
        return np.asarray(np.log(self.scale[self.prepared.scored]))


def log_kernel(white: FloatArray, nu: float) -> FloatArray:
    """Return the log-likelihood of innovations (N, ...) up to a constant, summed over the first axis."""
    return np.asarray(-0.5 * (nu + 1) * np.sum(np.log1p(white * white / (nu - 2)), axis=0))


def log_density(white: FloatArray, log_scale: FloatArray, nu: float) -> FloatArray:
    """Return log p of every innovation: Student's t with unit variance in `white`."""
    constant = lgamma((nu + 1) / 2) - lgamma(nu / 2) - 0.5 * log((nu - 2) * pi)
    return constant - 0.5 * (nu + 1) * np.log1p(white * white / (nu - 2)) + log_scale


def robust_weights(white: FloatArray, nu: float) -> FloatArray:
    """Return the weights of the equivalent least squares."""
    return (nu + 1) / (nu - 2 + white * white)


def log_likelihood(prepared: Sequence[Prepared], noise: Noise, simulated: Sequence[FloatArray]) -> float:
    """Return the log-likelihood of all recordings for simulated increments (n, 5) each."""
    return float(sum(densities(p, noise, s).sum() for p, s in zip(prepared, simulated, strict=True)))


def densities(prepared: Prepared, noise: Noise, simulated: FloatArray) -> FloatArray:
    """Return log p of each scored innovation of one recording."""
    whitener = Whitener.at(prepared, noise)
    nu = prepared.settings.degrees_of_freedom
    return log_density(whitener.residual(simulated), whitener.log_scale, nu)


def fit_noise(
    prepared: Sequence[Prepared],
    simulated: Sequence[FloatArray],
    start: Noise,
    names: Sequence[int],
    steps: int = 8,
) -> Noise:
    """Return the noise that makes the residuals likeliest.

    Parameters
    ----------
    names : indices into `NOISE_NAMES` of what may change; the rest stays.
    steps : at most so many BHHH steps, each damped until the likelihood grows.
    """
    free = np.array(names)
    low, high = np.log(SMALLEST_NOISE)[free], np.log(LARGEST_NOISE)[free]
    origin = np.log(np.maximum(start.vector(), SMALLEST_NOISE))

    def terms(position: FloatArray) -> FloatArray:
        noise = with_levels(start, free, position)
        return np.concatenate([densities(p, noise, s) for p, s in zip(prepared, simulated, strict=True)])

    def prior(position: FloatArray) -> float:
        return float(-0.5 * np.sum(((position - origin[free]) / PRIOR_SPREAD) ** 2))

    here = origin[free].copy()
    now = terms(here)
    for _ in range(steps):
        scores = np.column_stack(
            [(terms(here + LOG_STEP * unit) - now) / LOG_STEP for unit in np.eye(len(free))]
        )
        gradient = scores.sum(axis=0) - (here - origin[free]) / PRIOR_SPREAD**2
        centred = scores - scores.mean(axis=0)  # far from the top the mean score would shorten the steps
        curvature = centred.T @ centred + np.eye(len(free)) / PRIOR_SPREAD**2
        inside = ~(((here <= low) & (gradient < 0)) | ((here >= high) & (gradient > 0)))
        move = np.zeros(len(free))
        move[inside] = np.linalg.solve(curvature[np.ix_(inside, inside)], gradient[inside])
        move *= 1.0 / max(1.0, float(np.abs(move).max()))
        best, best_terms, top = here, now, now.sum() + prior(here)
        for damping in (1.6, 0.8, 0.4, 0.15, 0.04):
            tried = np.clip(here + damping * move, low, high)
            there = terms(tried)
            if there.sum() + prior(tried) > top:
                best, best_terms, top = tried, there, there.sum() + prior(tried)
            elif best is not here:
                break
        gain = best_terms.sum() - now.sum()
        here, now = best, best_terms
        if gain < 0.1:
            break
    return with_levels(start, free, here)


def with_levels(noise: Noise, free: NDArray[np.intp], logs: FloatArray) -> Noise:
    """Return the noise with the exponentials of `logs` in the places `free`."""
    levels = noise.vector()
    levels[free] = np.exp(logs)
    return Noise.of(levels)
