"""Solve for a camera from chessboard views, and say how good the answer is.

The order of work: start from the fleet's median (or the caller's guess), leave out corners and views that do
not belong, fit 4, 5 and 8 distortion coefficients each from the last, and for photos of any camera the equidistant
lens of a fisheye as well, choose by views left out, predict the error over the image from the covariance, and refuse
what no camera can be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.errors import DataError, InputError
from fsm_calib.perception.board_warp import BoardWarp, warp_step, warped
from fsm_calib.perception.bundle import fit
from fsm_calib.perception.calibration import CameraCalibration, DroppedView, ModelTrial, fit_figures
from fsm_calib.perception.coverage import coverage
from fsm_calib.perception.fisheye import fit_equidistant
from fsm_calib.perception.fleet_camera import fleet_start, why_not_a_duckiebot
from fsm_calib.perception.free_boards import BoardPoses, FreeBoards, fitted_poses
from fsm_calib.perception.lens import camera_model, intrinsics_vector
from fsm_calib.perception.outliers import bad_views, kept_corners
from fsm_calib.perception.prediction import predicted_error, sensitivity
from fsm_calib.perception.solve_settings import DEFAULT_SOLVE, SolveSettings
from fsm_calib.perception.stages import (
    Stage,
    best_start,
    choose,
    evaluated,
    fit_stages,
    held_intrinsics,
    is_better,
    light_prior,
    prior_of,
)
from fsm_calib.types import BoardSpec, BoardView, CameraModel, FloatArray

_GOOD_START_OF_WIDTH = 1.0 / 640.0  # a start that reaches 1 px in 640 is taken without trying others
_OTHER_FOCALS = (0.5, 0.8, 1.2, 2.0)  # image widths; starts for cameras unlike a Duckiebot's
_OUTLIER_ROUNDS = 3
_WARP_ROUNDS = 4  # steps of the board's bend; the last moves it by less than a micrometre


def calibrate(
    views: Sequence[BoardView],
    board: BoardSpec,
    image_size: tuple[int, int],
    guess: CameraModel | None = None,
    *,
    is_duckiebot: bool = False,
    may_be_bent: bool = False,
    settings: SolveSettings = DEFAULT_SOLVE,
) -> CameraCalibration:
    """Return the camera that explains the views, and how good it is.

    Parameters
    ----------
    views : sequence of BoardView
        Boards of one form; corners that a view does not show are nan.
    board : BoardSpec
    image_size : (width, height) [px]
    guess : CameraModel, optional
        Where to start; the median Duckiebot camera when missing.
    is_duckiebot : bool
        Refuse cameras that no Duckiebot has.
    may_be_bent : bool
        Also fit a board that is not flat (`board_warp`), and keep it where views left out agree better with it.

    Raises
    ------
    DataError
        Fewer views than `settings.fewest_views`.
    InputError
        Views whose number of corners is not the board's.
    """
    _check(views, board, settings)
    problem = FreeBoards(np.stack([view.corners_image for view in views]), board.points_board())
    start = _start(problem, image_size, guess)
    agreed = _without_outliers(problem, start, views, settings)
    used, kept, start, dropped = agreed.used, agreed.kept, agreed.start, agreed.dropped
    if used.size < settings.fewest_views:
        raise DataError(
            f"only {used.size} of {len(views)} views agree; at least {settings.fewest_views} are needed",
            cure=f"Check the board's size and the first reason: {dropped[0].reason}.",
        )
    problem = problem.taken(used)
    own = np.array([views[i].board for i in used])
    stage, trials = _chosen(problem, start, kept, own, image_size, settings)
    warp: BoardWarp | None = None
    if may_be_bent:
        bent, stage_bent, trials_bent = _bent(problem, stage, start, kept, own, image_size, settings)
        if is_better(stage, stage_bent, settings):
            warp, stage, trials = bent, stage_bent, trials_bent
    result = summary(stage, kept, [views[i] for i in used], board, image_size)
    result = replace(result, used=used, views_dropped=tuple(dropped), models=tuple(trials), board_warp=warp)
    reason = _refusal(result, stage, image_size, is_duckiebot, settings)
    return replace(result, refused=bool(reason), reason=reason)


def _chosen(
    problem: FreeBoards, start: BoardPoses, kept: FloatArray, own: np.ndarray, image_size: tuple[int, int],
    settings: SolveSettings,
) -> tuple[Stage, list[ModelTrial]]:  # fmt: skip
    """Return the model chosen among those of all sizes, and the account of all of them."""
    stages = [
        evaluated(problem, fitted, kept, own, image_size, settings)
        for fitted in fit_stages(problem, start, kept, settings)
    ]
    if settings.fisheye:
        fisheye = fit_equidistant(problem, stages[-1].solution.state, kept, image_size, settings)
        stages.append(evaluated(problem, (4, fisheye), kept, own, image_size, settings))
    return choose(stages, image_size, settings)


def _bent(
    problem: FreeBoards, flat: Stage, start: BoardPoses, kept: FloatArray, own: np.ndarray,
    image_size: tuple[int, int], settings: SolveSettings,
) -> tuple[BoardWarp, Stage, list[ModelTrial]]:  # fmt: skip
    """Return the board's bend, and the model chosen with it."""
    held, prior = flat.held, prior_of(flat.solution.state.intrinsics, settings)
    sizes, solution, now = np.zeros(2), flat.solution, problem
    for _ in range(_WARP_ROUNDS):
        sizes = sizes + warp_step(now, solution, held)
        warp = BoardWarp(*sizes.tolist())
        now = replace(problem, points_board=warped(problem.points_board, warp))
        solution = fit(now, solution.state, held, kept, prior=prior)
    return warp, *_chosen(now, start, kept, own, image_size, settings)


def summary(
    stage: Stage, kept: FloatArray, views: Sequence[BoardView], board: BoardSpec, image_size: tuple[int, int]
) -> CameraCalibration:
    """Return the calibration of a fitted model; `kept` (views, corners) marks the corners in use."""
    state: BoardPoses = stage.solution.state
    residuals = stage.solution.residual.reshape(*kept.shape, 2).copy()
    residuals[kept == 0.0] = np.nan
    predicted = predicted_error(sensitivity(state.intrinsics, image_size), stage.covariance)
    figures = fit_figures(residuals)
    return CameraCalibration(
        camera=camera_model(state.intrinsics, image_size),
        rms_px=figures.rms_px,
        mean_px=figures.mean_px,
        paper_px=figures.paper_px,
        predicted_px=predicted.rms,
        predicted_map=predicted,
        cross_validated_px=float(np.sqrt(stage.left_out.mean())) if stage.left_out.size else float("nan"),
        noise_px=stage.noise_px,
        covariance=stage.covariance,
        views_used=len(views),
        views_per_board=views_per_board(views),
        views_dropped=(),
        used=np.arange(len(views)),
        rotation=state.rotation,
        shift=state.shift,
        residuals=residuals,
        coverage=coverage(views, board, image_size),
    )


def views_per_board(views: Sequence[BoardView]) -> tuple[int, ...]:
    """Return how many views show board 0, 1, ..."""
    count = Counter(view.board for view in views)
    return tuple(count[number] for number in range(max(count, default=-1) + 1))


def _check(views: Sequence[BoardView], board: BoardSpec, settings: SolveSettings) -> None:
    corners = board.columns * board.rows
    for view in views:
        if len(view.corners_image) != corners:
            raise InputError(
                f"{len(view.corners_image)} corners are not a {board.columns}x{board.rows} board",
                where=view.source,
            )
    if len(views) < settings.fewest_views:
        raise DataError(
            f"{len(views)} views of the whole board are too few, {settings.fewest_views} are needed",
            cure="Take 15 or more, near and far, tilted to every side, and into every corner of the image.",
        )


def _start(problem: FreeBoards, image_size: tuple[int, int], guess: CameraModel | None) -> BoardPoses:
    first = fleet_start(image_size) if guess is None else intrinsics_vector(guess)
    others = []
    for widths in _OTHER_FOCALS:
        plain = np.zeros(12)
        plain[:2] = widths * image_size[0]
        plain[2:4] = (np.array(image_size) - 1.0) / 2.0
        others.append(plain)
    limit = _GOOD_START_OF_WIDTH * image_size[0]
    kept = problem.seen
    return best_start([first, *others], problem, kept, lambda rms: rms < limit)


@dataclass(frozen=True, eq=False)
class _Used:
    """Numbers of the views used (v,), their corners kept (v, n), a start for them, and the views dropped."""

    used: np.ndarray
    kept: FloatArray
    start: BoardPoses
    dropped: list[DroppedView]


def _without_outliers(
    problem: FreeBoards, start: BoardPoses, views: Sequence[BoardView], settings: SolveSettings
) -> _Used:
    """Leave out what does not belong; views are dropped only after a second look.

    A view may be off because its pose started at the mirror image, or because another one bent the lens: it is
    posed again with the lens of those that agree, and judged once more.
    """
    found = _judged(problem, start, views, settings)
    if not found.dropped or found.used.size < settings.fewest_views:
        return found
    prior, held = light_prior(settings.light_prior), held_intrinsics(min(settings.coefficients))
    agreed = fit(problem.taken(found.used), found.start, held, found.kept, prior=prior)
    second = _judged(problem, fitted_poses(agreed.state.intrinsics, problem), views, settings)
    return second if len(second.dropped) < len(found.dropped) else found


def _judged(
    problem: FreeBoards, start: BoardPoses, views: Sequence[BoardView], settings: SolveSettings
) -> _Used:
    """Leave out corners far off and views that lost many of them, refit, and judge again."""
    used, dropped = np.arange(len(views)), []
    kept = problem.seen
    largest, prior = max(settings.coefficients), light_prior(settings.light_prior)
    for _ in range(_OUTLIER_ROUNDS):
        solution = fit(problem.taken(used), start, held_intrinsics(largest), kept, prior=prior)
        seen = problem.seen[used]
        found = kept_corners(solution.residual, seen, settings)
        bad = bad_views(solution.residual, found, settings, seen)
        is_settled = not bad and bool(np.all(found == kept))
        dropped += [DroppedView(int(used[i]), views[used[i]].source, reason) for i, reason in bad.items()]
        stay = np.array([i for i in range(used.size) if i not in bad], dtype=int)
        used, kept, start = used[stay], found[stay], start.taken(stay)
        if is_settled or used.size < settings.fewest_views:
            break
    return _Used(used, kept, start, dropped)


def _refusal(
    result: CameraCalibration,
    stage: Stage,
    image_size: tuple[int, int],
    is_duckiebot: bool,
    settings: SolveSettings,
) -> str:
    """Return the sentence that refuses the result, or an empty string."""
    width, height = image_size
    vector = stage.solution.state.intrinsics
    limit = settings.largest_error_of_width * width
    if not stage.is_sane:
        return "the lens folds inside the image: no view reaches its corners"
    if not (0.2 * width < vector[0] < 10.0 * width and abs(vector[1] / vector[0] - 1.0) < 0.2):
        return f"focal lengths {vector[0]:.0f} and {vector[1]:.0f} px are those of no camera"
    if abs(vector[2] - width / 2.0) > 0.3 * width or abs(vector[3] - height / 2.0) > 0.3 * height:
        return f"the principal point ({vector[2]:.0f}, {vector[3]:.0f}) px is far off the image's middle"
    if result.cross_validated_px > limit:
        return f"unseen views are off by {result.cross_validated_px:.1f} px, {limit:.1f} px allowed"
    expected = result.predicted_map.expected
    if expected > limit:
        return f"the views leave {expected:.1f} px over the image, {limit:.1f} px allowed"
    return why_not_a_duckiebot(vector, image_size) if is_duckiebot else ""
