r"""Is anything left over? A score test of feature groups after a fit.

For a group with whitened features X (fitted Jacobian projected out) and robustly weighted residual psi of unit
variance, Q = |X' psi|^2 is under "nothing is left" a weighted sum of chi-squares with the eigenvalues of X'X as
weights. Its tail is taken from a scaled chi-square with the same mean and variance (Satterthwaite 1946). The test has
one degree of strength for a whole family of shapes: the score test of a variance component (Lin, Biometrika 84 (1997)
309), no fit of anything is needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.special import chdtrc

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.likelihood.robust import Whitener, log_kernel, robust_weights
from fsm_calib.diagnosis.shapes.features import Group
from fsm_calib.types import FloatArray

NO_POWER = (
    1e-12  # squared whitened units: a change that the base robot can make wholly has no power of its own
)
ALPHA = 0.003  # probability with which chance may pass for a finding: beyond three standard deviations
SPANNED = (
    1e-12  # share of its squared length that a group must keep beside what is fitted, which rounding does not
)


@dataclass(frozen=True, eq=False)
class LeftOver:
    """The test of one group, kept without its columns: surprise = -log10 p; gain = log-likelihood still to win."""

    group: Group
    surprise: float
    gain: float
    coefficients: FloatArray


@dataclass(frozen=True, eq=False)
class Residual:
    """The whitened residual of a fit, ready for score tests.

    white : (N,) the residual itself; psi : (N,) the same, robust, of unit variance; basis : (N, m) orthonormal
    columns of the fitted Jacobian.
    """

    white: FloatArray
    psi: FloatArray
    basis: FloatArray
    whiteners: tuple[Whitener, ...]
    engine: Engine

    def rows(self, run: int) -> slice:
        """Return where one recording's innovations stand among all."""
        begin = sum(w.prepared.innovations for w in self.whiteners[:run])
        return slice(begin, begin + self.whiteners[run].prepared.innovations)

    @cached_property
    def psi_inside(self) -> FloatArray:
        """What of psi the fitted Jacobian spans, (m,): taken off products of columns that have not been projected."""
        return np.asarray(self.basis.T @ self.psi)

    @cached_property
    def weighted_basis(self) -> FloatArray:
        """The basis (N, m) with the residual's robust weights."""
        return self.basis * robust_weights(self.white, self.engine.nu)[:, None]

    @cached_property
    def refit(self) -> FloatArray:
        """The matrix (m, m) that turns `weighted_basis.T @ r` into the numbers re-fitted to a residual r (N,)."""
        return np.asarray(np.linalg.inv(self.weighted_basis.T @ self.basis))


def residual_of(engine: Engine, fit: Fit) -> Residual:
    """Whiten a fit's residual and orthonormalise its Jacobian."""
    whiteners = engine.whiteners(fit.noise)
    white = engine.residual(whiteners, fit.simulated)
    psi = white * robust_weights(white, engine.nu)
    columns = engine.white_known(whiteners, fit.columns)
    basis, _ = np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))
    return Residual(white, psi / max(float(psi.std()), 1e-12), basis, tuple(whiteners), engine)


def project(residual: Residual, columns: Sequence[FloatArray]) -> FloatArray:
    """Return columns whitened (N, m), without what the fitted parameters can do."""
    return free_part(residual, residual.engine.white_columns(residual.whiteners, columns))


def free_part(residual: Residual, white: FloatArray) -> FloatArray:
    """Return whitened columns (N, m) without what the fitted parameters can do."""
    fitted = residual.basis @ (residual.basis.T @ white)
    return np.subtract(white, fitted, out=fitted)


def winnings(residual: Residual, changes: FloatArray) -> FloatArray:
    """Return the log-likelihood (m,) that whitened changes (N, m) win as they stand, the base re-fitted linearly.

    A score test sees no more of an outlier than the robust weights leave; an event or a slide that makes outliers is
    judged by the densities themselves. The base is re-fitted with the weights of the residual before the change.
    """
    nu = residual.engine.nu
    left = residual.white[:, None] - changes
    fitted = left - residual.basis @ (residual.refit @ (residual.weighted_basis.T @ left))
    after = np.maximum(log_kernel(left, nu), log_kernel(fitted, nu))
    return after - log_kernel(residual.white, nu)


@dataclass(frozen=True, eq=False)
class Products:
    """What a test needs to know of a group's whitened columns X (N, m), fitted Jacobian projected out.

    scores : X' psi, (m,); gram : X' X, (m, m); parts : the scores of each block of innovations by itself, (blocks, m).
    """

    scores: FloatArray
    gram: FloatArray
    parts: FloatArray

    @property
    def has_nothing(self) -> bool:
        """Whether the columns are nothing beside what is fitted."""
        return not np.any(self.gram)

    def surprise(self, energy: float | FloatArray) -> FloatArray:
        """Return -log10 of the chance that squared scores are so large (Satterthwaite's chi-square)."""
        mean, variance = float(np.trace(self.gram)), 2.0 * float(np.sum(self.gram * self.gram))
        scale = variance / (2.0 * mean)
        return np.asarray(-log_tail(energy / scale, mean / scale) / np.log(10.0))


@dataclass(frozen=True)
class Blocks:
    """The block that each innovation belongs to, in order, (N,), and how many there are."""

    number: NDArray[np.int_]
    count: int

    def sums(self, begin: int, weights: FloatArray, columns: FloatArray) -> FloatArray:
        """Return the weighted sums (blocks, m) of columns that belong to the innovations from `begin` on."""
        edges = np.searchsorted(self.number[begin : begin + len(columns)], np.arange(self.count + 1))
        return np.array([weights[a:b] @ columns[a:b] for a, b in pairwise(edges)]).reshape(
            -1, columns.shape[1]
        )


NO_BLOCKS = Blocks(np.zeros(0, dtype=int), 0)


def products_of(residual: Residual, group: Group, blocks: Blocks = NO_BLOCKS) -> Products:
    """Return a group's products, recording by recording; what is fitted is taken off the products of whole columns."""
    found: list[tuple[FloatArray, ...]] = []
    for run, make in enumerate(group.makers):
        white = residual.engine.white_columns(residual.whiteners[run : run + 1], [make()])
        rows = residual.rows(run)
        psi, basis = residual.psi[rows], residual.basis[rows]
        found.append((psi @ white, basis.T @ white, blocks.sums(rows.start, psi, white), white.T @ white))
    join = _side_by_side if group.own else _summed
    scores, inside, parts, gram = join(found)
    whole = float(np.trace(gram))
    gram = gram - inside.T @ inside
    if float(np.trace(gram)) < SPANNED * whole:
        gram = np.zeros_like(gram)
    scores = scores - inside.T @ residual.psi_inside
    return Products(scores, gram, parts - blocks.sums(0, residual.psi, residual.basis) @ inside)


def _side_by_side(found: Sequence[tuple[FloatArray, ...]]) -> tuple[FloatArray, ...]:
    """Return the products of recordings whose columns are nothing in the others."""
    scores, inside, parts, grams = zip(*found, strict=True)
    return *(np.concatenate(each, axis=-1) for each in (scores, inside, parts)), block_diag(*grams)


def _summed(found: Sequence[tuple[FloatArray, ...]]) -> tuple[FloatArray, ...]:
    """Return the products of recordings that share their columns."""
    return tuple(np.sum(each, axis=0) for each in zip(*found, strict=True))


def test_group(residual: Residual, group: Group) -> LeftOver:
    """Return how surprising the residual's dependence on a group is."""
    return test_products(group, products_of(residual, group))


def test_products(group: Group, products: Products) -> LeftOver:
    """Test a group whose products are at hand."""
    scores, gram = products.scores, products.gram
    if products.has_nothing:
        return LeftOver(group.named_alone(), 0.0, 0.0, np.zeros(len(scores)))
    ridge = 1e-3 * float(np.trace(gram)) / len(gram)
    coefficients = np.asarray(np.linalg.solve(gram + ridge * np.eye(len(gram)), scores), dtype=float)
    gain = 0.5 * float(scores @ coefficients) - 0.5 * len(gram)
    return LeftOver(group.named_alone(), float(products.surprise(scores @ scores)), gain, coefficients)


def log_tail(energy: float | FloatArray, degrees: float | FloatArray) -> FloatArray:
    """Return the log of the probability that a chi-square of so many degrees of freedom exceeds `energy`."""
    with np.errstate(divide="ignore"):  # what is beyond all numbers is surely left over
        return np.asarray(np.log(chdtrc(degrees, energy)))


def surprising(tests: Sequence[LeftOver]) -> list[LeftOver]:
    """Return the tests that chance alone gives in ALPHA of all robots, counted for their number (Bonferroni)."""
    return [test for test in tests if test.surprise > -np.log10(ALPHA / len(tests))]


def left_over(engine: Engine, fit: Fit, groups: Iterable[Group]) -> list[LeftOver]:
    """Return the tests of all groups, most surprising first."""
    return tested(residual_of(engine, fit), groups)


def tested(residual: Residual, groups: Iterable[Group]) -> list[LeftOver]:
    """Return the tests of all groups on a residual, most surprising first."""
    tests = [test_group(residual, group) for group in groups]
    return sorted(tests, key=lambda test: -test.surprise)
