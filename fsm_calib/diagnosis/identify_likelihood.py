"""Maximise an innovations' likelihood by Fisher scoring, with outliers set aside.

    L(p) = -1/2 sum_k ( log |S_k| + e_k' S_k^-1 e_k )
    I_ij = sum_k e_k,i' S_k^-1 e_k,j + 1/2 tr(S_k^-1 S_k,i S_k^-1 S_k,j)

e_k (n, 3), S_k (n, 3, 3): innovations and their variances at parameters p; a subscript i is the derivative.
The inverse of I is the covariance (Cramer-Rao). Rows whose e' S^-1 e exceeds GATE are outliers: they correct
nothing and count for nothing. Source: Ljung, System Identification, 2nd ed. 1999, sec. 7.4 and 10.2 (ISBN
0-13-656695-2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.identify_robust import scaled_inverse
from fsm_calib.types import FloatArray

GATE = 25.0  # chi-square with 3 degrees of freedom exceeds it once in 65 000 rows
ROUNDS = 60  # scoring steps at most
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
    not show from running away to zero.
    """

    run: Filter
    scale: FloatArray
    prior_mean: FloatArray
    prior_sd: FloatArray

    def objective(self, parameters: FloatArray, used: np.ndarray) -> float:
        """Return the log-likelihood plus the prior's logarithm, without constants."""
        pull = ((parameters - self.prior_mean) / self.prior_sd) ** 2
        return log_likelihood(*self.run(parameters, used), used) - 0.5 * float(pull.sum())


def maximise(problem: Problem, start: FloatArray, rows: int) -> Likelihood:
    """Find the parameters of largest likelihood from the guess `start` (p,), with `rows` n measured poses."""
    run, scale = problem.run, problem.scale
    parameters, used = np.array(start, dtype=float), np.ones(rows, dtype=bool)
    # with a poor guess everything is far off: open the gate step by step
    for gate in (GATE * 8.0, GATE, GATE):
        e, S = run(parameters, used)
        distance = np.einsum("nc,ncd,nd->n", e, np.linalg.inv(S), e)
        typical = max(float(np.median(distance)) / 2.4, 1.0)
        used = distance < gate * typical
        parameters = _score(problem, parameters, used)
    e, S = run(parameters, used)
    information, _ = _information(problem, parameters, used)
    return Likelihood(
        parameters,
        scaled_inverse(information, scale),
        log_likelihood(e, S, used),
        used,
        np.where(used[:, None], e, np.nan),
    )


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
    return np.clip(np.linalg.solve(damped, gradient * scale), -2.0, 2.0) * scale


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
    return information + np.diag(precision), gradient - precision * (parameters - problem.prior_mean)
