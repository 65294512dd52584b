"""Least squares of a camera and many board views: one Levenberg-Marquardt for every arrangement of the
boards.

Unknowns fall into `shared` ones (intrinsics and, when boards stand still, the boards and the camera's tilt)
and `local` blocks (the pose of each view, or the planar motion of each frame). With residual r = predicted -
found [px], J_s and J_l its derivatives and W the weights, the local blocks are eliminated (Schur
complement)::

    S = sum J_s' W J_s - sum_b (J_s' W J_l)_b (J_l' W J_l)_b^-1 (J_l' W J_s)_b

S is the information about the shared unknowns; its inverse times the noise variance is their covariance.
Sources: Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000, section 6; Huber, Robust Statistics,
1981.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import FloatArray

State = TypeVar("State")
_LARGEST_DAMPING = 1e8  # beyond it no step lowers the cost: the fit has ended
_RIDGE = 1e-12  # relative to the diagonal: keeps a block of an unobserved unknown invertible


@dataclass(frozen=True, eq=False)
class Linearized:
    """Residuals and derivatives of every view at one state.

    residual : (views, 2 n) [px]; shared : (views, 2 n, s); local : (views, 2 n, l); block : (views,) number
    of the local block that the view's local derivatives belong to.
    """

    residual: FloatArray
    shared: FloatArray
    local: FloatArray
    block: np.ndarray


class Problem(Protocol[State]):
    """An arrangement of boards whose unknowns can be fitted."""

    def residuals(self, state: State) -> FloatArray:
        """Return predicted minus found corners, shape (views, 2 n) [px]."""
        ...

    def linearize(self, state: State) -> Linearized:
        """Return the residuals and their derivatives."""
        ...

    def shared(self, state: State) -> FloatArray:
        """Return the shared unknowns (s,) that a prior can speak of; zeros where it cannot."""
        ...

    def moved(self, state: State, shared: FloatArray, local: FloatArray) -> State:
        """Return the state after a step: shared (s,), local (blocks, l)."""
        ...


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known beforehand of the shared unknowns: mean (s,) and standard deviation (s,), inf for
    nothing.
    """

    mean: FloatArray
    deviation: FloatArray

    def information(self, noise_px: float) -> FloatArray:
        """Return the prior's information (s,) in units of the residuals, whose noise is `noise_px` [px]."""
        return (noise_px / self.deviation) ** 2


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations: information S (s, s), gradient (s,), and what the local blocks need for their step.

    cross : (blocks, s, l); local_inverse : (blocks, l, l); local_gradient : (blocks, l).
    """

    information: FloatArray
    gradient: FloatArray
    cross: FloatArray
    local_inverse: FloatArray
    local_gradient: FloatArray

    def step(self, held: NDArray[np.bool_], damping: float) -> tuple[FloatArray, FloatArray]:
        """Return the step of the shared (s,) and local (blocks, l) unknowns; `held` marks unknowns that
        stay.
        """
        free = ~held
        matrix = self.information[np.ix_(free, free)]
        scale = np.diag(matrix) * damping + np.diag(matrix).max(initial=0.0) * _RIDGE
        shared = np.zeros(held.size)
        shared[free] = -np.linalg.solve(matrix + np.diag(scale), self.gradient[free])
        right = self.local_gradient + np.einsum("bsl,s->bl", self.cross, shared)
        return shared, -np.einsum("blm,bm->bl", self.local_inverse, right)


@dataclass(frozen=True, slots=True)
class BundleSettings:
    """When the fit stops and how it treats outliers.

    Parameters
    ----------
    most_steps : int
        Accepted or tried steps.
    smallest_gain : float
        Relative decrease of the cost that ends the fit [1].
    huber_sigmas : float
        Corners farther off than this many robust standard deviations weigh less (95 % efficiency at 1.345 for
        one coordinate; 2.5 leaves normal noise alone).
    """

    most_steps: int = 30
    smallest_gain: float = 1e-6
    huber_sigmas: float = 2.5


DEFAULT_BUNDLE = BundleSettings()


@dataclass(frozen=True, eq=False)
class Solution(Generic[State]):
    """The end of a fit.

    state : the problem's state; cost : weighted sum of squares, prior included [px^2]; normal : normal
    equations there; weights : (views, n) in [0, 1]; linearized : residuals and derivatives there; steps : how
    many were tried.
    """

    state: State
    cost: float
    normal: Normal
    weights: FloatArray
    linearized: Linearized
    steps: int

    @property
    def residual(self) -> FloatArray:
        """Predicted minus found corners, shape (views, 2 n) [px]."""
        return self.linearized.residual


def with_prior(normal: Normal, prior: FloatArray, offset: FloatArray) -> Normal:
    """Return the normal equations with a prior of information (s,) whose mean lies `-offset` (s,) away."""
    return replace(
        normal, information=normal.information + np.diag(prior), gradient=normal.gradient + prior * offset
    )


def normal_equations(linearized: Linearized, weights: FloatArray, damping: float = 0.0) -> Normal:
    """Return the normal equations with the local blocks eliminated; weights (views, n) per corner."""
    doubled = np.repeat(weights, 2, axis=1)[..., None]
    shared, local, residual = linearized.shared, linearized.local, linearized.residual[..., None]
    weighted_shared, weighted_local = shared * doubled, local * doubled
    blocks = int(linearized.block.max()) + 1
    own = _summed(np.swapaxes(weighted_local, 1, 2) @ local, linearized.block, blocks)
    cross = _summed(np.swapaxes(weighted_shared, 1, 2) @ local, linearized.block, blocks)
    local_gradient = _summed((np.swapaxes(weighted_local, 1, 2) @ residual)[..., 0], linearized.block, blocks)
    diagonal = np.einsum("bll->bl", own)
    diagonal += diagonal * damping + _RIDGE * (1.0 + diagonal.max(axis=1, keepdims=True))
    inverse = np.linalg.inv(own)
    reduced = cross @ inverse
    flat = weighted_shared.reshape(-1, shared.shape[2])
    information = flat.T @ shared.reshape(-1, shared.shape[2]) - np.einsum("bsl,btl->st", reduced, cross)
    gradient = flat.T @ residual.ravel() - np.einsum("bsl,bl->s", reduced, local_gradient)
    return Normal(information, gradient, cross, np.asarray(inverse, dtype=float), local_gradient)


def _summed(values: FloatArray, block: np.ndarray, blocks: int) -> FloatArray:
    if blocks == len(values) and bool(np.all(block == np.arange(blocks))):
        return values.copy()
    total = np.zeros((blocks, *values.shape[1:]))
    np.add.at(total, block, values)
    return total


def corner_distances(residual: FloatArray) -> FloatArray:
    """Return the length of each corner's residual, (views, 2 n) -> (views, n) [px]."""
    return np.asarray(np.hypot(residual[:, 0::2], residual[:, 1::2]))


def robust_sigma(residual: FloatArray, kept: FloatArray) -> float:
    """Return the noise per coordinate [px] from the median corner distance (Rayleigh: median = 1.177
    sigma).
    """
    distances = corner_distances(residual)[kept > 0.0]
    return max(float(np.median(distances)) / 1.1774, 1e-6) if distances.size else 1e-6


def huber_weights(residual: FloatArray, kept: FloatArray, sigmas: float) -> FloatArray:
    """Return weights (views, n): 1 within `sigmas` robust deviations of the length, falling as 1/length
    beyond.
    """
    limit = sigmas * robust_sigma(residual, kept)
    return kept * np.minimum(1.0, limit / np.maximum(corner_distances(residual), 1e-12))


def fit(
    problem: Problem[State],
    state: State,
    held: NDArray[np.bool_],
    kept: FloatArray,
    settings: BundleSettings = DEFAULT_BUNDLE,
    prior: Prior | None = None,
) -> Solution[State]:
    """Fit the unknowns by Levenberg-Marquardt with Huber weights.

    Parameters
    ----------
    problem, state : the arrangement and where to start
    held : array of bool, shape (s,)
        Shared unknowns that stay at their start.
    kept : array, shape (views, n)
        0 for corners that are left out, 1 for the others.
    prior : Prior, optional
        A light prior on the shared unknowns.
    """
    point = _evaluate(problem, state, kept, settings, prior)
    damping, steps = 1e-4, 0
    while steps < settings.most_steps and damping < _LARGEST_DAMPING:
        steps += 1
        normal = with_prior(
            normal_equations(point.linearized, point.weights, damping), point.prior, point.offset
        )
        candidate = problem.moved(point.state, *normal.step(held, damping))
        lower = point.cost_at(problem, candidate)
        if not lower < point.cost:
            damping = max(damping, 1e-6) * 10.0
            continue
        gain = (point.cost - lower) / max(point.cost, 1e-300)
        point, damping = _evaluate(problem, candidate, kept, settings, prior), damping * 0.1
        if gain < settings.smallest_gain:
            break
    normal = with_prior(normal_equations(point.linearized, point.weights), point.prior, point.offset)
    return Solution(point.state, point.cost, normal, point.weights, point.linearized, steps)


@dataclass(frozen=True, eq=False)
class _Point(Generic[State]):
    """A state with everything evaluated there; weights and the prior's strength stay fixed while a step
    is tried.
    """

    state: State
    linearized: Linearized
    weights: FloatArray
    prior: FloatArray
    offset: FloatArray
    mean: FloatArray
    cost: float

    def cost_at(self, problem: Problem[State], state: State) -> float:
        """Return the cost of another state under this point's weights."""
        offset = problem.shared(state) - self.mean
        return weighted_cost(problem.residuals(state), self.weights) + float(self.prior @ offset**2)


def _evaluate(
    problem: Problem[State], state: State, kept: FloatArray, settings: BundleSettings, prior: Prior | None
) -> _Point[State]:
    linearized = problem.linearize(state)
    weights = huber_weights(linearized.residual, kept, settings.huber_sigmas)
    shared = problem.shared(state)
    mean = shared if prior is None else prior.mean
    strength = np.zeros_like(shared)
    if prior is not None:
        strength = prior.information(robust_sigma(linearized.residual, kept))
    cost = weighted_cost(linearized.residual, weights) + float(strength @ (shared - mean) ** 2)
    return _Point(state, linearized, weights, strength, shared - mean, mean, cost)


def weighted_cost(residual: FloatArray, weights: FloatArray) -> float:
    """Return the weighted sum of squares [px^2] of residuals (views, 2 n) with weights (views, n)."""
    return float(np.sum(np.repeat(weights, 2, axis=1) * residual**2))
