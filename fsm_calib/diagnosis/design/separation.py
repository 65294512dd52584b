r"""How far apart two explanations put a drive, and how much doubt that is expected to remove.

What a drive shows is whitened as the likelihood whitens it. Under explanation i it is normal with mean mu_i and
covariance I + X_i C_i X_i', where X_i are derivatives by its numbers, those of the base robot included (every fit
re-fits them), and C_i their covariance. All that is needed are inner products of mu and X, the Gram matrix K, which is
a sum over manoeuvres. The squared distance of two explanations, both free to move their numbers,

    L_ij = d' (I + Z D Z')^-1 d = K_dd - K_dZ (I + D K_ZZ)^-1 D K_Zd,     d = mu_i - mu_j,  D = (C_i + C_j) / 2

gives the Bhattacharyya distance L_ij / 8 (log-determinants, which only add, left out), and the information that the
drive is expected to give about which explanation is right is at least

    I >= -sum_i p_i ln sum_j p_j exp(-L_ij / (8 temper))        [nat]

Source: Kolchinsky & Tracey, Entropy 19 (2017) 361. `temper` is by how much the diagnosis divides evidence, since its
equations are inexact; the designer must not be surer than the diagnosis will be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsm_calib.types import FloatArray


@dataclass(frozen=True, eq=False)
class Columns:
    """Where mu and X of each explanation stand in the Gram matrix.

    width : columns in all, the last one always zero; means : (h,); numbers : (h, m) padded with the last column;
    covariances : (h, m, m) padded with zeros; base : how many numbers are shared.
    """

    width: int
    means: np.ndarray
    numbers: np.ndarray
    covariances: FloatArray
    base: int


@dataclass(frozen=True, eq=False)
class Pairs:
    """Every pair of explanations, laid out once: i, j (q,); idx (q, 2 m - base); D (q, ., .)."""

    i: np.ndarray
    j: np.ndarray
    index: np.ndarray
    spread: FloatArray

    @classmethod
    def of(cls, columns: Columns) -> Pairs:
        """Lay out all pairs i < j."""
        count, m = columns.numbers.shape
        b, own = columns.base, m - columns.base
        i, j = np.triu_indices(count, 1)
        index = np.concatenate([columns.numbers[i], columns.numbers[j][:, b:]], axis=1)
        spread = np.zeros((len(i), m + own, m + own))
        spread[:, :m, :m] += 0.5 * columns.covariances[i]
        place = np.r_[0:b, m : m + own]
        spread[:, place[:, None], place[None, :]] += 0.5 * columns.covariances[j]
        return cls(i, j, index, spread)


def distances(gram: FloatArray, columns: Columns, pairs: Pairs) -> FloatArray:
    """Return L_ij of all pairs, shape (h, h), symmetric, from a Gram matrix (width, width)."""
    mi, mj = columns.means[pairs.i], columns.means[pairs.j]
    length = gram[mi, mi] + gram[mj, mj] - 2.0 * gram[mi, mj]
    across = gram[mi[:, None], pairs.index] - gram[mj[:, None], pairs.index]
    inner = gram[pairs.index[:, :, None], pairs.index[:, None, :]]
    free = np.linalg.solve(
        np.eye(pairs.index.shape[1]) + pairs.spread @ inner, (pairs.spread @ across[:, :, None])
    )
    apart = np.maximum(length - np.einsum("qa,qa->q", across, free[:, :, 0]), 0.0)
    out = np.zeros((len(columns.means), len(columns.means)))
    out[pairs.i, pairs.j] = out[pairs.j, pairs.i] = apart
    return out


def information(apart: FloatArray, p: FloatArray, temper: FloatArray | float) -> float:
    """Return the least information [nat] that a drive with distances `apart` (h, h) is expected to give.

    temper : of all pairs alike, or of each (h, h).
    """
    overlap = np.exp(-apart / (8.0 * temper)) @ p
    return float(-np.sum(p * np.log(np.maximum(overlap, 1e-300))))


Weigh = Callable[[FloatArray], FloatArray]
"""Log odds (n, h), up to what all share, from log-likelihoods (n, h) of a drive."""


def expected_posteriors(
    gram: FloatArray,
    columns: Columns,
    weigh: Weigh,
    within: FloatArray,
    draws: int,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Return mean posterior probabilities by nested sampling, shape (h, h): row = what is true, column = said, and
    the mean probability (h,) that what is then likeliest is right.

    within : (h, h) 1 where an explanation (column) is right about all that another (row) says.
    For every explanation `draws` sets of numbers and noises; the likelihood of each explanation is exact for them.
    """
    count = len(columns.means)
    root = _root(gram)
    solved = [_evidence_parts(gram, columns, j) for j in range(count)]
    table, surest = np.zeros((count, count)), np.zeros(count)
    for i in range(count):
        seen = _seen(gram, root, columns, i, draws, rng)
        likelihood = np.column_stack([_log_evidence(gram, columns, j, solved[j], seen) for j in range(count)])
        weight = weigh(likelihood)
        weight = np.exp(weight - weight.max(axis=1, keepdims=True))
        posterior = weight / weight.sum(axis=1, keepdims=True)
        right = np.sum(posterior * within[posterior.argmax(axis=1)], axis=1)
        table[i], surest[i] = posterior.mean(axis=0), right.mean()
    return table, surest


def _root(gram: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(0.5 * (gram + gram.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _seen(
    gram: FloatArray, root: FloatArray, columns: Columns, i: int, draws: int, rng: np.random.Generator
) -> FloatArray:
    """Return inner products W'y, shape (draws, width), of what is measured when i is true."""
    numbers, spread = columns.numbers[i], columns.covariances[i]
    weights = np.zeros((draws, columns.width))
    weights[:, columns.means[i]] = 1.0
    moved = rng.standard_normal((draws, len(numbers))) @ _root(spread).T
    for k, column in enumerate(numbers):
        weights[:, column] += moved[:, k]
    return weights @ gram + rng.standard_normal((draws, len(root))) @ root.T


def _evidence_parts(gram: FloatArray, columns: Columns, j: int) -> tuple[FloatArray, float]:
    """Return (I + C K)^-1 C and log |I + C K| of one explanation."""
    numbers, spread = columns.numbers[j], columns.covariances[j]
    system = np.eye(len(numbers)) + spread @ gram[np.ix_(numbers, numbers)]
    return np.linalg.solve(system, spread), float(np.linalg.slogdet(system)[1])


def _log_evidence(
    gram: FloatArray, columns: Columns, j: int, parts: tuple[FloatArray, float], seen: FloatArray
) -> FloatArray:
    """Return log p(y | j) up to what all explanations share, shape (draws,)."""
    inverse, log_volume = parts
    mean, numbers = columns.means[j], columns.numbers[j]
    across = seen[:, numbers] - gram[mean, numbers]
    length = gram[mean, mean] - 2.0 * seen[:, mean]
    fitted = np.einsum("na,ab,nb->n", across, inverse, across)
    return np.asarray(-0.5 * (length - fitted + log_volume))
