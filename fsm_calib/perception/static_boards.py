"""Solve for a camera whose boards never move while it drives on the floor; pitch, roll and height come for
free.

A free solve gives every view six unknowns. Here a frame has three, and all views of one board share six: the
fewer unknowns, the better the rest is known. Where the assumption does not hold (a board was pushed, the
robot tilted), the noise of the fit grows; then the free answer is kept and the sentence says so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.perception.board_order import half_turned, is_half_turn_ambiguous
from fsm_calib.perception.bundle import Prior, Solution, fit
from fsm_calib.perception.calibration import CameraCalibration, fit_figures
from fsm_calib.perception.chessboard import half_windows
from fsm_calib.perception.corner_bias import expected_bias
from fsm_calib.perception.intrinsics import calibrate, views_per_board
from fsm_calib.perception.lens import camera_model, intrinsics_vector, is_sane_over_image
from fsm_calib.perception.outliers import kept_corners
from fsm_calib.perception.prediction import predicted_error, sensitivity
from fsm_calib.perception.solve_settings import DEFAULT_SOLVE, SolveSettings
from fsm_calib.perception.stages import covariance_of, held_intrinsics, light_prior
from fsm_calib.perception.static_problem import FIRST_BOARD, StaticBoards, StaticState
from fsm_calib.perception.static_start import (
    Placement,
    level_poses,
    place_all,
    tilt_from_vertical,
    vertical_in_camera,
)
from fsm_calib.perception.systematic import shared_covariance, systematic_covariance
from fsm_calib.types import BoardSpec, BoardView, CameraMount, FloatArray

_FLAT = math.cos(math.radians(4.0))  # a board whose normal is this near the vertical lies on the floor
_NOMINAL_TILT = (CameraMount().pitch, 0.0)


@dataclass(frozen=True, slots=True)
class StaticSettings:
    """When the static answer is taken.

    largest_noise_growth : its noise over the free solve's [1]; normal noise makes it 1.0, a board that moved
    by a millimetre at half a metre makes it 3. fewest_frames : with fewer the frames do not hold the boards
    together. smallest_share : of the views that must fit their board [1]. largest_strain : robust standard
    deviations by which a view may fit worse than the middle one with the board that it is said to show: with more it
    shows another, of which lean and height are nearly the same.
    """

    largest_noise_growth: float = 1.5
    fewest_frames: int = 5
    smallest_share: float = 0.8
    largest_strain: float = 6.0


DEFAULT_STATIC = StaticSettings()


@dataclass(frozen=True, eq=False)
class StaticResult:
    """What the static solve found.

    Parameters
    ----------
    calibration : CameraCalibration
        The static answer, or the free one when the assumption does not hold.
    is_static : bool
        Whether the static answer was taken; `sentence` says why not.
    pitch, roll : float
        Of the camera, down and right side down [rad]; `pitch_deviation`, `roll_deviation` their standard
        deviations [rad].
    height : float
        Of the camera over the floor [m]; nan when no board lies on it.
    frames : array, shape (frames, 3)
        x, y [m] and yaw [rad] of the camera in each frame, from the first; by the order of `frame_numbers`.
    frame_numbers : array of int
    """

    calibration: CameraCalibration
    is_static: bool
    sentence: str = ""
    pitch: float = float("nan")
    roll: float = float("nan")
    pitch_deviation: float = float("nan")
    roll_deviation: float = float("nan")
    height: float = float("nan")
    frames: FloatArray | None = None
    frame_numbers: np.ndarray | None = None


def calibrate_static(
    views: Sequence[BoardView],
    frames: Sequence[int],
    board: BoardSpec,
    free: CameraCalibration,
    *,
    settings: SolveSettings = DEFAULT_SOLVE,
    limits: StaticSettings = DEFAULT_STATIC,
) -> StaticResult:
    """Return the calibration under the assumption that boards never move and the camera drives on a floor.

    Parameters
    ----------
    views : sequence of BoardView
        The views that `free` was made from; `BoardView.board` says which board each shows. Where that is a
        miscount, the board whose lean, height and place fit is taken (`static_start`).
    frames : sequence of int
        Number of the image that each view was found in, growing with time.
    board : BoardSpec
    free : CameraCalibration
        The result of `intrinsics.calibrate` on the same views.
    """
    used, numbers = free.used, np.asarray(frames, dtype=int)[free.used]
    if np.unique(numbers).size < limits.fewest_frames:
        return StaticResult(free, False, "too few frames for boards to hold together")
    own = np.array([views[i].board for i in used])
    placement, tilt, poses_kept = _placement(free, own, numbers, board)
    keep = np.array([i for i in range(used.size) if i in poses_kept], dtype=int)
    own[keep] = [placement.shown[i] for i in keep]
    ordered = {int(i): _ordered(views[used[i]], placement.flipped[i]) for i in keep}
    fitted = _fitted(keep, ordered, own, numbers, board, free, placement, tilt, settings)
    strained = fitted.strain > np.median(fitted.strain) + limits.largest_strain * _spread(fitted.strain)
    if strained.any():
        keep = keep[~strained]
        fitted = _fitted(keep, ordered, own, numbers, board, free, placement, tilt, settings)
    bias = np.stack(
        [expected_bias(ordered[int(i)], half_windows(ordered[int(i)], board), board) for i in keep]
    )
    found = _result(fitted.solution, fitted.problem, fitted.kept, fitted.held, bias, keep, free, limits)
    if not found.is_static:
        return found
    count = views_per_board([replace(views[used[i]], board=int(own[i])) for i in keep])
    return replace(found, calibration=replace(found.calibration, views_per_board=count))


@dataclass(frozen=True, eq=False)
class _Fitted:
    """A static fit: solution, problem, corners in use (views, corners), unknowns that were held, each view's strain.

    strain : (views,) its error over its error in the free solve, where it needs no board that stands still [1].
    """

    solution: Solution[StaticState]
    problem: StaticBoards
    kept: FloatArray
    held: np.ndarray
    strain: FloatArray


def _fitted(
    keep: np.ndarray, ordered: Mapping[int, FloatArray], own: np.ndarray, numbers: np.ndarray, board: BoardSpec,
    free: CameraCalibration, placement: Placement, tilt: FloatArray, settings: SolveSettings,
) -> _Fitted:  # fmt: skip
    """Fit the views `keep` (of the used ones) whose corners are `ordered`, without the corners that lie far off."""
    corners = np.stack([ordered[int(i)] for i in keep])
    problem, state, anchors = _problem(corners, own[keep], numbers[keep], board, free, placement, tilt)
    held, prior = _held(problem, _coefficients(free), anchors), _prior(problem, settings)
    kept = np.isfinite(free.residuals[keep]).all(axis=2).astype(float)
    solution = fit(problem, state, held, kept, prior=prior)
    kept = kept_corners(solution.residual, kept, settings)
    solution = fit(problem, solution.state, held, kept, prior=prior)
    squares = np.sum(solution.residual.reshape(*kept.shape, 2) ** 2, axis=2)
    error = np.sum(kept * squares, axis=1) / np.maximum(np.sum(kept, axis=1), 1.0)
    strain = np.sqrt(error / np.nanmean(np.sum(free.residuals[keep] ** 2, axis=2), axis=1))
    return _Fitted(solution, problem, kept, held, strain)


def _spread(values: FloatArray) -> float:
    """Return a robust standard deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def _placement(
    free: CameraCalibration, own: np.ndarray, numbers: np.ndarray, board: BoardSpec
) -> tuple[Placement, FloatArray, set[int]]:
    upward = vertical_in_camera(free.rotation, own)
    tilt = np.array(_NOMINAL_TILT) if upward is None else tilt_from_vertical(upward)
    middle = board.points_board().mean(axis=0)
    poses = level_poses(free.rotation, free.shift, tilt, middle)
    placement = place_all(poses, own, numbers, is_half_turn_ambiguous(board))
    return placement, tilt, set(placement.flipped)


def _ordered(view: BoardView, flipped: bool) -> FloatArray:
    return half_turned(view.corners_image) if flipped else view.corners_image


def _problem(
    corners: FloatArray, own: np.ndarray, numbers: np.ndarray, board: BoardSpec, free: CameraCalibration,
    placement: Placement, tilt: FloatArray,
) -> tuple[StaticBoards, StaticState, list[int]]:  # fmt: skip
    """Return the problem with boards and frames numbered without gaps, its start and its anchors."""
    boards, board_index = np.unique(own, return_inverse=True)
    moments, frame_index = np.unique(numbers, return_inverse=True)
    points = board.points_board()
    placed = [placement.boards[int(number)] for number in boards]
    rotation = np.stack([pose.rotation for pose in placed])
    shift = np.stack([pose.centre - pose.rotation @ points.mean(axis=0) for pose in placed])
    frames = np.stack([placement.frames[int(number)] for number in moments])
    state = StaticState(intrinsics_vector(free.camera), tilt, rotation, shift, frames)
    anchors = [int(np.searchsorted(boards, number)) for number in placement.anchors]
    return StaticBoards(corners, points, board_index, frame_index), state, anchors


def _coefficients(free: CameraCalibration) -> int:
    freed = int(np.count_nonzero(np.diag(free.covariance)))
    return {8: 4, 9: 5}.get(freed, 8)


def _held(problem: StaticBoards, coefficients: int, anchors: Sequence[int]) -> np.ndarray:
    """Return which shared unknowns stay: intrinsics the model has not, place and yaw of the anchors."""
    held = np.zeros(FIRST_BOARD + 6 * problem.boards, dtype=bool)
    held[:12] = held_intrinsics(coefficients)
    for anchor in anchors:
        held[FIRST_BOARD + 6 * anchor + np.array([2, 3, 4])] = True
    return held


def _prior(problem: StaticBoards, settings: SolveSettings) -> Prior:
    light = light_prior(settings.light_prior)
    rest = np.full(FIRST_BOARD - 12 + 6 * problem.boards, np.inf)
    return Prior(np.zeros(12 + rest.size), np.concatenate([light.deviation, rest]))


def _result(
    solution: Solution[StaticState], problem: StaticBoards, kept: FloatArray, held: np.ndarray, bias: FloatArray,
    keep: np.ndarray, free: CameraCalibration, limits: StaticSettings,
) -> StaticResult:  # fmt: skip
    state = solution.state
    covariance, noise = covariance_of(solution, held, 3 * len(state.frames))
    covariance = covariance + systematic_covariance(solution, problem.board, held)
    covariance = covariance + shared_covariance(solution, bias, held)
    deviation = np.sqrt(np.diag(covariance)[12:FIRST_BOARD])
    height = _height(state, problem.points_board.mean(axis=0))
    result = StaticResult(
        calibration=free,
        is_static=False,
        pitch=float(state.tilt[0]),
        roll=float(state.tilt[1]),
        pitch_deviation=float(deviation[0]),
        roll_deviation=float(deviation[1]),
        height=height,
        frames=state.frames,
        frame_numbers=np.unique(problem.frame),
    )
    sentence = _objection(noise, len(keep), state, free, limits)
    if sentence:
        return replace(result, sentence=sentence)
    static = _calibration(solution, kept, covariance[:12, :12], noise, keep, free, height)
    return replace(result, calibration=static, is_static=True)


def _objection(
    noise: float, kept_views: int, state: StaticState, free: CameraCalibration, limits: StaticSettings
) -> str:
    """Return why the static answer is not taken, or an empty string."""
    if kept_views < limits.smallest_share * free.views_used:
        return f"only {kept_views} of {free.views_used} views show boards that stayed in place"
    if noise > limits.largest_noise_growth * free.noise_px:
        return f"boards or robot did not keep still: noise {noise:.2f} px, free {free.noise_px:.2f} px"
    is_sane = is_sane_over_image(state.intrinsics, (free.camera.width, free.camera.height))
    return "" if is_sane else "the lens folds inside the image"


def _height(state: StaticState, middle: FloatArray) -> float:
    """Return the camera's height over the boards that lie flat [m], nan without one: all cameras are at z
    = 0.
    """
    flat = np.abs(state.board_rotation[:, 2, 2]) > _FLAT
    centres = state.board_shift + state.board_rotation @ middle
    return float(-centres[flat, 2].mean()) if bool(flat.any()) else float("nan")


def _calibration(
    solution: Solution[StaticState], kept: FloatArray, covariance: FloatArray, noise: float, keep: np.ndarray,
    free: CameraCalibration, height: float,
) -> CameraCalibration:  # fmt: skip
    """Return the free calibration with everything replaced that the static solve knows better."""
    state, size = solution.state, (free.camera.width, free.camera.height)
    residuals = solution.residual.reshape(*kept.shape, 2).copy()
    residuals[kept == 0.0] = np.nan
    figures = fit_figures(residuals)
    predicted = predicted_error(sensitivity(state.intrinsics, size), covariance)
    nominal = CameraMount()
    mount = replace(
        nominal,
        pitch=float(state.tilt[0]),
        roll=float(state.tilt[1]),
        height=nominal.height if math.isnan(height) else height,
    )
    return replace(
        free,
        camera=camera_model(state.intrinsics, size),
        rms_px=figures.rms_px,
        mean_px=figures.mean_px,
        paper_px=figures.paper_px,
        predicted_px=predicted.rms,
        predicted_map=predicted,
        noise_px=noise,
        covariance=covariance,
        views_used=len(keep),
        used=free.used[keep],
        rotation=free.rotation[keep],
        shift=free.shift[keep],
        residuals=residuals,
        mount=mount,
    )


def frames_of(views: Sequence[BoardView]) -> list[int]:
    """Return a number for the image of each view: views with the same `source` share it, in order of
    appearance.
    """
    numbers: dict[str, int] = {}
    frames = []
    for index, view in enumerate(views):
        key = view.source or f"view {index}"
        frames.append(numbers.setdefault(key, len(numbers)))
    return frames


def calibrate_scan(
    views: Sequence[BoardView],
    board: BoardSpec,
    image_size: tuple[int, int],
    *,
    settings: SolveSettings = DEFAULT_SOLVE,
) -> StaticResult:
    """Return the calibration of a Duckiebot that scanned boards which did not move: free first, then static.

    `BoardView.source` tells which views are of one image and must appear in order of time; `BoardView.board`
    tells the boards apart.
    """
    free = calibrate(views, board, image_size, is_duckiebot=True, settings=settings)
    if free.refused:
        return StaticResult(free, False, free.reason)
    return calibrate_static(views, frames_of(views), board, free, settings=settings)
