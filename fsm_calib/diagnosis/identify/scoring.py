"""Maximise an innovations' likelihood by Fisher scoring, with outliers set aside.

    L(p) = -1/2 sum_k ( log |S_k| + e_k' S_k^-1 e_k )
    I_ij = sum_k e_k,i' S_k^-1 e_k,j + 1/2 tr(S_k^-1 S_k,i S_k^-1 S_k,j)

e_k (n, 3), S_k (n, 3, 3): innovations and their variances at parameters p; a subscript i is the derivative.
The inverse of I is the covariance (Cramer-Rao). Rows whose e' S^-1 e exceeds GATE are outliers: they correct
nothing and count for nothing. Source: Ljung, System Identification, 2nd ed. 1999, sec. 7.4 and 10.2 (ISBN
0-13-656695-2).

Some parameters n are noise levels. Their likeliest values are too small, as the other parameters q have fitted
part of the noise; so the likelihood is restricted, L(p) - 1/2 log |I_qq(n)| (Patterson, Thompson 1971, DOI
10.1093/biomet/58.3.545), the second term linear in n about the likeliest values. And since a standard deviation
s_i depends on noise levels that are themselves uncertain, its square is the mean over them: with V the
covariance of n and g = d log s_i^2 / dn, s_i^2 grows by exp(g' V g / 2), the mean of a log-normal variable.
A noise level that is rarely there, and does what others do, is free only where it earns its place.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsm_calib.diagnosis.identify.robust_rows import scaled_inverse
from fsm_calib.types import FloatArray

GATE = 25.0  # chi-square with 3 degrees of freedom exceeds it once in 65 000 rows
ROUNDS = 60  # scoring steps at most
NOISE_STEP = 0.1  # log units: difference for what depends on a noise level
WIDEST = 2.0  # at most this variance of log s^2 counts: beyond, only the prior speaks
SILENT, FAINT = -10.0, -2.0  # log units below its first guess: a noise level of nothing, of little
EARNED = 3.5  # log-likelihood: half the logarithm of 1000 rows, Schwarz 1978 (DOI 10.1214/aos/1176344136)
SETTLED = 3e-3  # gain of log-likelihood below which scoring ends

Filter = Callable[[FloatArray, np.ndarray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Result: `parameters` (p,), `covariance` (p, p), `log_likelihood`, `used` (n,) bool, `innovations` (n,
    3).
    """

    parameters: FloatArray
    covariance: FloatArray
    log_likelihood: float
    used: np.ndarray
    innovations: FloatArray


@dataclass(frozen=True, eq=False)
class Problem:
    """What is maximised: `run` (parameters, used) -> (e, S); size (p,) of each parameter; a weak prior.

    prior_mean, prior_sd (p,): normal prior; an infinite sd is none. It keeps a noise level that the data does
    not show from running away to zero. noise (p,): which parameters are logarithms of noise levels; tilt
    (p,): gradient of what is added to the log-likelihood.
    """

    run: Filter
    scale: FloatArray
    prior_mean: FloatArray
    prior_sd: FloatArray
    noise: NDArray[np.bool_]
    tilt: FloatArray

    def objective(self, parameters: FloatArray, used: np.ndarray) -> float:
        """Return the log-likelihood plus the prior's logarithm and the tilt, without constants."""
        pull = 0.5 * float((((parameters - self.prior_mean) / self.prior_sd) ** 2).sum())
        return log_likelihood(*self.run(parameters, used), used) - pull + float(self.tilt @ parameters)


def maximise(problem: Problem, start: FloatArray, rows: int, spare: int) -> Likelihood:
    """Find the parameters of largest likelihood from the guess `start` (p,), with `rows` n measured poses.

    The noise level at place `spare` is next to nothing unless it raises the likelihood by EARNED.
    """
    without = _silenced(problem, spare)
    parameters, used = _climb(without, start, np.ones(rows, dtype=bool))
    richer = parameters.copy()
    richer[spare] = FAINT
    richer = _score(problem, richer, used)
    if problem.objective(richer, used) > without.objective(parameters, used) + EARNED:
        parameters, used = _climb(problem, richer, used)
    else:
        problem = without
    here = _information(problem, parameters, used)[0]
    louder = _louder(problem, parameters, used)
    restricted = dataclasses.replace(problem, tilt=_restriction(problem, here, louder))
    parameters = _score(restricted, parameters, used)
    e, S = problem.run(parameters, used)
    return Likelihood(
        parameters,
        _covariance(problem, _information(problem, parameters, used)[0], here, louder),
        log_likelihood(e, S, used),
        used,
        np.where(used[:, None], e, np.nan),
    )


def _silenced(problem: Problem, place: int) -> Problem:
    """Return the problem with a noise level held at next to nothing by its prior."""
    mean, sd = problem.prior_mean.copy(), problem.prior_sd.copy()
    mean[place], sd[place] = SILENT, 1e-3
    return dataclasses.replace(problem, prior_mean=mean, prior_sd=sd)


def _climb(problem: Problem, start: FloatArray, used: np.ndarray) -> tuple[FloatArray, np.ndarray]:
    """Maximise from `start`; return the parameters and which rows are no outliers."""
    parameters = np.where(problem.prior_mean == SILENT, SILENT, start)
    # with a poor guess everything is far off: open the gate step by step
    for gate in (GATE * 8.0, GATE, GATE):
        e, S = problem.run(parameters, used)
        distance = np.einsum("nc,ncd,nd->n", e, np.linalg.inv(S), e)
        typical = max(float(np.median(distance)) / 2.4, 1.0)
        used = distance < gate * typical
        parameters = _score(problem, parameters, used)
    return parameters, used


def _louder(problem: Problem, parameters: FloatArray, used: np.ndarray) -> dict[int, FloatArray]:
    """Return the information where each noise level is a little higher, by the level's place."""
    steps = {int(i): np.eye(len(parameters))[i] * NOISE_STEP for i in np.flatnonzero(problem.noise)}
    return {i: _information(problem, parameters + step, used)[0] for i, step in steps.items()}


def _restriction(problem: Problem, here: FloatArray, louder: dict[int, FloatArray]) -> FloatArray:
    """Return the gradient of -1/2 log |I_qq| over the noise levels, shape (p,); zero for the others."""
    told = problem.scale * ~problem.noise

    def volume(information: FloatArray) -> float:
        unitless = information * np.outer(told, told) + np.diag(problem.noise.astype(float))
        return float(np.linalg.slogdet(unitless)[1])

    tilt = np.zeros(len(told))
    for i, information in louder.items():
        tilt[i] = -0.5 * (volume(information) - volume(here)) / NOISE_STEP
    return tilt


def _covariance(
    problem: Problem, information: FloatArray, here: FloatArray, louder: dict[int, FloatArray]
) -> FloatArray:
    """Return the inverse of the information (p, p), widened by what is not known of the noise levels."""
    covariance = scaled_inverse(information, problem.scale)
    before = np.diag(scaled_inverse(here, problem.scale))
    slopes = np.zeros_like(covariance)
    for i, raised in louder.items():
        slopes[i] = np.log(np.diag(scaled_inverse(raised, problem.scale)) / before) / NOISE_STEP
    spread = np.einsum("ni,nm,mi->i", slopes, covariance, slopes)
    wider = np.exp(np.minimum(spread, WIDEST) / 4.0)
    return covariance * np.outer(wider, wider)


def log_likelihood(e: FloatArray, S: FloatArray, used: np.ndarray) -> float:
    """Return L without its constant; -inf where the filter broke down."""
    sign, logdet = np.linalg.slogdet(S[used])
    if not (sign > 0).all() or not np.isfinite(logdet).all() or not np.isfinite(e[used]).all():
        return -np.inf
    distance = np.einsum("nc,ncd,nd->n", e[used], np.linalg.inv(S[used]), e[used])
    return -0.5 * float((logdet + distance).sum())


def _score(problem: Problem, parameters: FloatArray, used: np.ndarray) -> FloatArray:
    """Fisher scoring with Levenberg's damping; never leaves the likelihood lower than it found it."""
    best = problem.objective(parameters, used)
    damping = 1e-3
    for _ in range(ROUNDS):
        information, gradient = _information(problem, parameters, used)
        gain = 0.0
        for _ in range(8):
            trial = parameters + _step(information, gradient, problem.scale, damping)
            value = problem.objective(trial, used)
            if value > best:
                gain, best, parameters, damping = value - best, value, trial, damping / 5.0
                break
            damping *= 8.0
        if gain < SETTLED:
            break
    return parameters


def _step(information: FloatArray, gradient: FloatArray, scale: FloatArray, damping: float) -> FloatArray:
    unitless = information * np.outer(scale, scale)
    diagonal = np.diag(unitless)
    damped = unitless + np.diag(damping * diagonal + 1e-9 * max(float(diagonal.max()), 1e-300))
    # no parameter moves by more than twice its size at once
    return np.asarray(np.clip(np.linalg.solve(damped, gradient * scale), -2.0, 2.0) * scale)


def _information(problem: Problem, parameters: FloatArray, used: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Return Fisher's information (p, p) and the gradient (p,) of L by central differences."""
    run, scale = problem.run, problem.scale
    e, S = run(parameters, used)
    inverse = np.linalg.inv(S[used])
    bent = np.einsum("ncd,nd->nc", inverse, e[used])
    de, dS = [], []
    for i, size in enumerate(scale):
        step = np.zeros(len(parameters))
        step[i] = 1e-4 * size
        (ep, Sp), (em, Sm) = run(parameters + step, used), run(parameters - step, used)
        de.append((ep - em)[used] / (2e-4 * size))
        dS.append((Sp - Sm)[used] / (2e-4 * size))
    DE, DS = np.stack(de), np.stack(dS)
    half = np.einsum("ncd,pnde->pnce", inverse, DS)
    information = np.einsum("pnc,ncd,qnd->pq", DE, inverse, DE, optimize=True)
    information += 0.5 * np.einsum("pncd,qndc->pq", half, half, optimize=True)
    gradient = -np.einsum("pnc,nc->p", DE, bent) - 0.5 * np.einsum("pncc->p", half)
    gradient += 0.5 * np.einsum("nc,pncd,nd->p", bent, DS, bent, optimize=True)
    precision = problem.prior_sd**-2.0
    gradient += problem.tilt - precision * (parameters - problem.prior_mean)
    return information + np.diag(precision), gradient
