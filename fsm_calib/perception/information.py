"""What a view adds while the robot scans, when to stop, and what to say when the boards cannot give more.

The information S about the intrinsics (8 of the 12 are free while scanning: f, c, k1, k2, p1, p2) is a sum
over views, so the expected error over the image after one more view costs one 8x8 inverse::

    expected^2 = s^2 trace(A (S + S_v)^-1 A') / grid points

with s the noise of a corner coordinate [px] and A from `prediction`; what corners repeat in every view
(`systematic`) is added to it at every solve and does not shrink. A view is wanted for what it takes off this; the scan
ends by the predicted error, its 95 % quantile (`prediction`). What each threshold of the stop rule gives
on robots is measured in docs/camera.md. Sources: Peng and Sturm, Calibration Wizard, ICCV 2019 (next best view
by covariance); mrcal (uncertainty).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.perception.bundle import BundleSettings, Prior, fit, normal_equations
from fsm_calib.perception.fleet_camera import FLEET_DEVIATION, fleet_start
from fsm_calib.perception.free_boards import BoardPoses, FreeBoards, start_poses
from fsm_calib.perception.lens import camera_model, intrinsics_vector, is_sane_over_image
from fsm_calib.perception.prediction import GRID, ImageError, PredictedError, predicted_error, sensitivity
from fsm_calib.perception.stages import held_intrinsics
from fsm_calib.perception.systematic import systematic_covariance
from fsm_calib.types import BoardSpec, BoardView, CameraModel, FloatArray

_FREE = np.nonzero(~held_intrinsics(4))[0]
_FLEET_WIDTHS = 3.0  # the fleet's spread, this many times wider, guards a scan's first solves
_SCAN_FIT = BundleSettings(most_steps=60, smallest_gain=1e-7)  # six views of one board make a long valley
_FIRST_NOISE_PX = 0.2  # of a corner coordinate before the scan has measured its own


@dataclass(frozen=True, slots=True)
class StopRule:
    """When a scan has seen enough.

    Parameters
    ----------
    predicted_px : float
        Largest predicted error over the image, which 95 of 100 calibrations stay within [px].
    views_per_board : int
        Fewest views of every board.
    views : int
        Fewest views in all.
    smallest_gain : float
        A view is accepted when it lowers the expected error by this share [1] (or its board lacks views);
        0 accepts every view.
    """

    predicted_px: float = 0.35
    views_per_board: int = 8
    views: int = 15
    smallest_gain: float = 0.001


DEFAULT_STOP = StopRule()


@dataclass(frozen=True, eq=False)
class ScanProgress:
    """What a scan knows so far.

    camera : CameraModel; information : (12, 12) about the intrinsics, in 1/px^2 of unit noise; noise_px :
    noise of a corner coordinate [px]; repeated : (12, 12) covariance by errors that corners repeat, as of the last
    solve; predicted : error over the image; views : accepted; views_per_board; rms_px : of the last solve [px].
    """

    camera: CameraModel
    information: FloatArray
    noise_px: float
    repeated: FloatArray
    predicted: PredictedError
    views: int
    views_per_board: tuple[int, ...]
    rms_px: float = float("nan")

    @property
    def predicted_px(self) -> float:
        """Predicted error over the image, "al", which 95 of 100 calibrations stay within [px]."""
        return self.predicted.rms


def begin_scan(image_size: tuple[int, int], boards: int, guess: CameraModel | None = None) -> ScanProgress:
    """Return the progress before the first view: the fleet's median camera, known as well as the fleet is."""
    start = fleet_start(image_size) if guess is None else intrinsics_vector(guess)
    prior = np.diag((_FIRST_NOISE_PX / _prior(start, image_size).deviation) ** 2)
    known = _Known(start, prior, _FIRST_NOISE_PX, np.zeros_like(prior))
    return _progress(known, image_size, (0,) * boards, float("nan"))


def solve_scan(
    views: Sequence[BoardView], board: BoardSpec, progress: ScanProgress, *, boards: int | None = None
) -> ScanProgress:
    """Return the progress after a solve with all `views`, started from the last camera: about 40 ms for
    60 views. A solve that ends at a lens which folds inside the image says nothing: the progress then stays.
    """
    image_size = (progress.camera.width, progress.camera.height)
    count = len(progress.views_per_board) if boards is None else boards
    per_board = tuple(sum(view.board == number for view in views) for number in range(count))
    if not views:
        return replace(progress, views=0, views_per_board=per_board)
    corners = np.stack([view.corners_image for view in views])
    problem = FreeBoards(corners, board.points_board())
    start = start_poses(intrinsics_vector(progress.camera), corners, board.points_board())
    prior = _prior(fleet_start(image_size), image_size)
    kept = np.ones(corners.shape[:2])
    solution = fit(problem, start, held_intrinsics(4), kept, _SCAN_FIT, prior)
    if not is_sane_over_image(solution.state.intrinsics, image_size):
        return replace(progress, views=len(views), views_per_board=per_board)
    weights = np.repeat(solution.weights, 2, axis=1)
    freedom = max(weights.size - 6 * len(views) - _FREE.size, 1)
    noise = float(np.sqrt(np.sum(weights * solution.residual**2) / freedom))
    rms = float(np.sqrt(2.0 * np.mean(solution.residual**2)))
    repeated = systematic_covariance(solution, np.array([view.board for view in views]), held_intrinsics(4))
    known = _Known(solution.state.intrinsics, solution.normal.information, noise, repeated)
    return _progress(known, image_size, per_board, rms)


def rebuild_scan(
    camera: CameraModel,
    information: FloatArray,
    noise_px: float,
    repeated: FloatArray,
    views_per_board: tuple[int, ...],
    rms_px: float,
) -> ScanProgress:
    """Return the progress with these fields of `ScanProgress`; the others follow from them."""
    known = _Known(intrinsics_vector(camera), information, noise_px, repeated)
    return _progress(known, (camera.width, camera.height), views_per_board, rms_px)


def view_information(view: BoardView, board: BoardSpec, camera: CameraModel) -> FloatArray:
    """Return what one view says about the intrinsics, its own pose eliminated, shape (12, 12) [1/px^2]."""
    intrinsics, corners = intrinsics_vector(camera), view.corners_image[None]
    problem = FreeBoards(corners, board.points_board())
    pose: BoardPoses = start_poses(intrinsics, corners, board.points_board())
    return normal_equations(problem.linearize(pose), np.ones(corners.shape[:2])).information


@dataclass(frozen=True, eq=False)
class Weighed:
    """A view that was weighed.

    progress : ScanProgress, what is known with it; gain : by which share it lowers the expected error [1], in [0, 1);
    is_wanted : whether to keep it.
    """

    progress: ScanProgress
    gain: float
    is_wanted: bool


def weigh_view(
    view: BoardView, board: BoardSpec, progress: ScanProgress, rule: StopRule = DEFAULT_STOP
) -> Weighed:
    """Return what a view adds, without solving again; it is wanted when that is enough or its board lacks views."""
    per_board = list(progress.views_per_board) + [0] * (view.board + 1 - len(progress.views_per_board))
    is_lacking = per_board[view.board] < rule.views_per_board
    per_board[view.board] += 1
    information = progress.information + view_information(view, board, progress.camera)
    known = _Known(intrinsics_vector(progress.camera), information, progress.noise_px, progress.repeated)
    size = (progress.camera.width, progress.camera.height)
    after = _progress(known, size, tuple(per_board), progress.rms_px)
    gain = max(0.0, 1.0 - after.predicted.expected / max(progress.predicted.expected, 1e-12))
    return Weighed(after, gain, is_lacking or gain >= rule.smallest_gain)


def is_enough(progress: ScanProgress, rule: StopRule = DEFAULT_STOP) -> bool:
    """Tell whether the camera is known well enough after this solve, from enough views of every board."""
    is_seen = all(count >= rule.views_per_board for count in progress.views_per_board)
    return progress.predicted_px <= rule.predicted_px and is_seen and progress.views >= rule.views


def weakest_region(error: ImageError) -> str:
    """Return the name of the ninth of the image whose predicted error is largest, such as "bottom left"."""
    rows, columns = np.array_split(np.arange(GRID[1]), 3), np.array_split(np.arange(GRID[0]), 3)
    worst = max(
        ((i, j) for i in range(3) for j in range(3)),
        key=lambda cell: float(np.mean(error.grid[np.ix_(rows[cell[0]], columns[cell[1]])] ** 2)),
    )
    name = f"{('top', 'middle', 'bottom')[worst[0]]} {('left', 'centre', 'right')[worst[1]]}"
    return "centre" if name == "middle centre" else name


def advice(error: ImageError, rule: StopRule = DEFAULT_STOP) -> str:
    """Return what to do about boards that cannot reach the wanted precision, in one sentence."""
    region = weakest_region(error)
    wanted = f"{rule.predicted_px:.2g} px over the image was wanted"
    weakness = f"The image is least certain at the {region} ({error.max:.2f} px); {wanted}."
    if region.startswith("bottom"):
        return f"{weakness} Lay a board flat on the floor ahead of the robot: only it reaches there."
    return f"{weakness} Lean one board back by 20 to 40 degrees, turn another by 30, and put one nearer."


def _prior(mean: FloatArray, image_size: tuple[int, int]) -> Prior:
    """Return the fleet's spread, widened, as a prior that only guards: it changes a finished scan by
    under 2 %.
    """
    deviation = FLEET_DEVIATION * _FLEET_WIDTHS
    deviation[:4] *= image_size[0] / 640.0
    deviation[8:] = np.inf
    return Prior(mean, deviation)


@dataclass(frozen=True, eq=False)
class _Known:
    """Intrinsics (12,) and what makes up their covariance: information (12, 12), noise [px], repeated (12, 12)."""

    intrinsics: FloatArray
    information: FloatArray
    noise_px: float
    repeated: FloatArray

    def predicted(self, image_size: tuple[int, int]) -> PredictedError:
        """Return the predicted error over the image."""
        covariance = self.repeated.copy()
        free = np.ix_(_FREE, _FREE)
        covariance[free] += np.linalg.pinv(self.information[free], hermitian=True) * self.noise_px**2
        return predicted_error(sensitivity(self.intrinsics, image_size), covariance)


def _progress(
    known: _Known, image_size: tuple[int, int], per_board: tuple[int, ...], rms_px: float
) -> ScanProgress:
    return ScanProgress(
        camera=camera_model(known.intrinsics, image_size),
        information=known.information,
        noise_px=known.noise_px,
        repeated=known.repeated,
        predicted=known.predicted(image_size),
        views=sum(per_board),
        views_per_board=per_board,
        rms_px=rms_px,
    )
