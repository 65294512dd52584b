"""Fit lens models of growing size, each from the last, and choose by views that the fit has not seen.

The reprojection error of a fit always falls when coefficients are added; the error of views left out of it
does not. View v's mean squared distance e_v [px^2] is computed with v left out. With g_v = log(e_v of the
small model / e_v of the large one), whose mean no single bad view can rule, the larger model is kept when

    mean(g) > 2 sd(g) / sqrt(views)   and   sum(e of the large) < sum(e of the small),

its lens maps every pixel to one ray, and its expected error is not larger than what the smaller one is off:
the larger of the smaller model's own expected error and its distance from the larger model. The equidistant lens of a
fisheye comes last; it is taken as well where views left out find it no worse and its expected error is less than half.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.perception.bundle import BundleSettings, Prior, Solution, corner_distances, fit
from fsm_calib.perception.calibration import ModelTrial
from fsm_calib.perception.free_boards import BoardPoses, FreeBoards, start_poses
from fsm_calib.perception.lens import FREE_OF_COEFFICIENTS, camera_model, is_equidistant, is_sane_over_image
from fsm_calib.perception.prediction import (
    PredictedError,
    predicted_error,
    projection_difference,
    sensitivity,
)
from fsm_calib.perception.solve_settings import SolveSettings
from fsm_calib.perception.systematic import systematic_covariance
from fsm_calib.types import FloatArray

BETTER_KNOWN = 0.5  # of the expected error: less is no chance of the fit
_TINY_PX2 = 1e-12  # keeps the logarithm of a perfect fit finite
_FOLD_FIT = BundleSettings(most_steps=6, smallest_gain=1e-4)
_POSE_FIT = BundleSettings(most_steps=6, smallest_gain=1e-4, huber_sigmas=1e6)


@dataclass(frozen=True, eq=False)
class Stage:
    """One fitted model: its size, solution, covariance (s, s) of its s intrinsics, and squared errors of views left out
    (views,) [px^2].
    """

    coefficients: int
    solution: Solution[BoardPoses]
    covariance: FloatArray
    noise_px: float
    predicted: PredictedError
    is_sane: bool
    left_out: FloatArray

    @property
    def name(self) -> str:
        """What a person calls the model."""
        return lens_name(self.solution.state.intrinsics, self.coefficients)

    @property
    def held(self) -> np.ndarray:
        """Which of its intrinsics the model holds, bool (s,)."""
        return held_of(self.solution.state.intrinsics, self.coefficients)


def lens_name(intrinsics: FloatArray, coefficients: int) -> str:
    """Return what a person calls a model."""
    return "the equidistant lens" if is_equidistant(intrinsics) else f"{coefficients} coefficients"


def held_of(intrinsics: FloatArray, coefficients: int) -> np.ndarray:
    """Return which intrinsics a model holds: none of an equidistant lens."""
    return (
        np.zeros(intrinsics.size, dtype=bool) if is_equidistant(intrinsics) else held_intrinsics(coefficients)
    )


def prior_of(intrinsics: FloatArray, settings: SolveSettings) -> Prior:
    """Return the light prior of a model's intrinsics around 0: of k3 and above; k3 and k4 of an equidistant lens."""
    if not is_equidistant(intrinsics):
        return light_prior(settings.light_prior)
    widths = np.full(intrinsics.size, np.inf)
    widths[6:] = settings.light_prior
    return Prior(np.zeros(intrinsics.size), widths)


def held_intrinsics(coefficients: int) -> np.ndarray:
    """Return which of the 12 intrinsics a model with so many coefficients holds, bool (12,)."""
    held = np.ones(12, dtype=bool)
    held[list(FREE_OF_COEFFICIENTS[coefficients])] = False
    return held


def light_prior(deviation: float) -> Prior:
    """Return the light prior around 0 of k3, k4, k5, k6 with `deviation` [1]."""
    widths = np.full(12, np.inf)
    widths[8:] = deviation
    return Prior(np.zeros(12), widths)


def fit_stages(
    problem: FreeBoards, start: BoardPoses, kept: FloatArray, settings: SolveSettings
) -> list[tuple[int, Solution[BoardPoses]]]:
    """Return the fitted models, smallest first, each started from the one before."""
    prior, solutions, state = light_prior(settings.light_prior), [], start
    for coefficients in settings.coefficients:
        solution = fit(problem, state, held_intrinsics(coefficients), kept, prior=prior)
        solutions.append((coefficients, solution))
        state = solution.state
    return solutions


def covariance_of(solution: Solution, held: np.ndarray, local_unknowns: int) -> tuple[FloatArray, float]:
    """Return the covariance of the shared unknowns and the noise of one corner coordinate [px].

    C = s^2 S^-1 with s^2 = sum w r^2 / (coordinates - unknowns).
    """
    weights = np.repeat(solution.weights, 2, axis=1)
    coordinates = 2.0 * float(np.count_nonzero(solution.weights))
    freedom = max(coordinates - local_unknowns - int(np.count_nonzero(~held)), 1.0)
    noise = float(np.sqrt(np.sum(weights * solution.residual**2) / freedom))
    covariance = np.zeros((held.size, held.size))
    free = np.ix_(~held, ~held)
    covariance[free] = np.linalg.pinv(solution.normal.information[free], hermitian=True) * noise**2
    return covariance, noise


def evaluated(
    problem: FreeBoards, fitted: tuple[int, Solution[BoardPoses]], kept: FloatArray, board: np.ndarray,
    image_size: tuple[int, int], settings: SolveSettings,
) -> Stage:  # fmt: skip
    """Return a fitted model with its covariance, predicted error and cross-validation; `board` per view."""
    coefficients, solution = fitted
    intrinsics = solution.state.intrinsics
    held = held_of(intrinsics, coefficients)
    covariance, noise = covariance_of(solution, held, 6 * len(kept))
    covariance = covariance + systematic_covariance(solution, board, held)
    predicted = predicted_error(sensitivity(intrinsics, image_size), covariance)
    left_out = left_out_errors(problem, solution.state, coefficients, kept, settings)
    sane = is_sane_over_image(intrinsics, image_size)
    return Stage(coefficients, solution, covariance, noise, predicted, sane, left_out)


def folds(views: int, settings: SolveSettings) -> list[np.ndarray]:
    """Return the groups of views to be left out, one view each for few views, every tenth together for
    many.
    """
    if views <= settings.all_but_one_up_to:
        return [np.array([view]) for view in range(views)]
    return [np.arange(first, views, settings.folds) for first in range(settings.folds)]


def left_out_errors(
    problem: FreeBoards, state: BoardPoses, coefficients: int, kept: FloatArray, settings: SolveSettings
) -> FloatArray:
    """Return each view's mean squared corner distance under intrinsics fitted without it, shape (views,)
    [px^2].
    """
    views, errors = len(kept), np.zeros(len(kept))
    held, prior = held_of(state.intrinsics, coefficients), prior_of(state.intrinsics, settings)
    all_held = np.ones(held.size, dtype=bool)
    for out in folds(views, settings):
        rest = np.setdiff1d(np.arange(views), out)
        refit = fit(problem.taken(rest), state.taken(rest), held, kept[rest], _FOLD_FIT, prior)
        intrinsics = refit.state.intrinsics
        unseen = BoardPoses(intrinsics, state.rotation[out], state.shift[out])
        posed = fit(problem.taken(out), unseen, all_held, kept[out], _POSE_FIT)
        squares = corner_distances(posed.residual) ** 2 * kept[out]
        errors[out] = squares.sum(axis=1) / np.maximum(kept[out].sum(axis=1), 1.0)
    return errors


def choose(
    stages: Sequence[Stage], image_size: tuple[int, int], settings: SolveSettings
) -> tuple[Stage, list[ModelTrial]]:
    """Return the chosen model and the account of all that were tried."""
    chosen, trials = stages[0], [_trial(stages[0], "the smallest")]
    for stage in stages[1:]:
        objection = _objection(chosen, stage, image_size, settings)
        praise = f"better than {chosen.name} on unseen views"
        if objection and _is_better_known(chosen, stage, settings):
            objection, praise = (
                "",
                f"as good as {chosen.name} on unseen views, and better known over the image",
            )
        trials.append(_trial(stage, objection or praise))
        chosen = chosen if objection else stage
    return chosen, trials


def is_better(small: Stage, large: Stage, settings: SolveSettings) -> bool:
    """Tell whether views left out agree better with the larger model, by more than chance; see the module."""
    gain = np.log(np.maximum(small.left_out, _TINY_PX2) / np.maximum(large.left_out, _TINY_PX2))
    error = float(gain.std(ddof=1)) / np.sqrt(gain.size)
    is_lower = float(large.left_out.sum()) < float(small.left_out.sum())
    return is_lower and float(gain.mean()) > settings.gain_in_errors * error


def _objection(small: Stage, large: Stage, image_size: tuple[int, int], settings: SolveSettings) -> str:
    """Return why the larger model is not kept, or an empty string."""
    if not large.is_sane:
        return "folds or has a pole inside the image"
    if not is_better(small, large, settings):
        return f"no better than {small.name} on unseen views"
    cameras = [camera_model(stage.solution.state.intrinsics, image_size) for stage in (large, small)]
    apart = projection_difference(*cameras).rms
    if small.is_sane and large.predicted.expected > max(small.predicted.expected, apart):
        return f"expected error {large.predicted.expected:.2f} px is larger than what it would mend"
    return ""


def _is_better_known(chosen: Stage, other: Stage, settings: SolveSettings) -> bool:
    """Tell whether views left out find an equidistant lens no worse, while far less is left open over the image.

    It is no larger model than a rational one but another: where both fit, the one that the views tell is the better.
    """
    if (
        not is_equidistant(other.solution.state.intrinsics)
        or not other.is_sane
        or is_better(other, chosen, settings)
    ):
        return False
    return not chosen.is_sane or other.predicted.expected < BETTER_KNOWN * chosen.predicted.expected


def _trial(stage: Stage, verdict: str) -> ModelTrial:
    residual = stage.solution.residual[np.repeat(stage.solution.weights > 0.0, 2, axis=1)]
    return ModelTrial(
        name=stage.name,
        coefficients=stage.coefficients,
        rms_px=float(np.sqrt(2.0 * np.mean(residual**2))),
        cross_validated_px=float(np.sqrt(stage.left_out.mean())),
        predicted_px=stage.predicted.rms,
        is_sane=stage.is_sane,
        verdict=verdict,
    )


def best_start(
    candidates: Sequence[FloatArray], problem: FreeBoards, kept: FloatArray, good: Callable[[float], bool]
) -> BoardPoses:
    """Return the fitted 4-coefficient state of the first candidate that is `good` by its rms [px], else
    the best one.
    """
    best: tuple[float, BoardPoses] | None = None
    for intrinsics in candidates:
        start = start_poses(intrinsics, problem.corners_image, problem.points_board)
        solution = fit(problem, start, held_intrinsics(4), kept)
        rms = float(np.sqrt(np.median(corner_distances(solution.residual)[kept > 0.0] ** 2)))
        if best is None or rms < 0.8 * best[0]:
            best = (rms, solution.state)
        if good(best[0]):
            break
    if best is None:
        raise ValueError("no candidate start was given")
    return best[1]
