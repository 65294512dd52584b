"""What a camera calibration hands out: the camera, how good it is, and what it was made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.perception.board_warp import BoardWarp
from fsm_calib.perception.coverage import Coverage
from fsm_calib.perception.lens import intrinsics_vector, names_of
from fsm_calib.perception.prediction import PredictedError
from fsm_calib.types import CameraModel, CameraMount, FloatArray

RETAKE_RATIO = 2.0
"""A photo whose error is so many times the median photo's is worth taking again [1]."""


@dataclass(frozen=True, slots=True)
class DroppedView:
    """A view that was left out: its number in the input, its source, and the reason in one sentence."""

    index: int
    source: str
    reason: str


@dataclass(frozen=True, eq=False)
class ModelTrial:
    """One lens model that was tried.

    name : what a person calls it; coefficients : 4, 5 or 8 distortion coefficients, 4 of the equidistant lens;
    rms_px : root mean square corner distance of the fit [px]; cross_validated_px : the same on views that the fit had
    not seen [px]; predicted_px : predicted error over the image [px]; is_sane : one ray per pixel; verdict : why it was
    kept or not.
    """

    name: str
    coefficients: int
    rms_px: float
    cross_validated_px: float
    predicted_px: float
    is_sane: bool
    verdict: str


@dataclass(frozen=True, eq=False)
class CameraCalibration:
    """A camera and how good it is.

    Parameters
    ----------
    camera : CameraModel
    rms_px : float
        Root mean square distance between found and predicted corners (OpenCV's number) [px].
    mean_px : float
        Mean of the same distances [px].
    paper_px : float
        The paper's number: per image the norm of all distances over their count, averaged; RMS /
        sqrt(corners) [px].
    predicted_px : float
        Predicted projection error over the whole image, "al" of `prediction`: 95 of 100 such calibrations stay within
        it [px].
    predicted_map : PredictedError
        The same over a 25x19 grid, and the error that is expected.
    cross_validated_px : float
        Root mean square corner distance on views that the fit had not seen; nan when it was not computed
        [px].
    noise_px : float
        Estimated noise of one corner coordinate [px].
    covariance : array, shape (12, 12), or (8, 8) of an equidistant lens
        Of the intrinsics in the order of `lens.names_of`; zero rows for those that were held.
    views_used : int
    views_per_board : tuple of int
        How many of them show board 0, 1, ...
    views_dropped : tuple of DroppedView
    used : array of int, shape (views_used,)
        Numbers of the used views in the input.
    rotation, shift : arrays, shapes (views, 3, 3) and (views, 3) [m]
        Board to camera, per used view.
    residuals : array, shape (views, corners, 2) [px]
        Predicted minus found, per used view; nan for corners left out.
    coverage : Coverage
        Duckietown's four bars.
    models : tuple of ModelTrial
        The lens models tried, smallest first.
    refused : bool
        The result failed the gate of sanity; `reason` says why.
    mount : CameraMount, optional
        Height, pitch and roll when boards that stand still gave them.
    board_warp : BoardWarp, optional
        How the board is bent, where views left out agreed better with a bent one.
    """

    camera: CameraModel
    rms_px: float
    mean_px: float
    paper_px: float
    predicted_px: float
    predicted_map: PredictedError
    cross_validated_px: float
    noise_px: float
    covariance: FloatArray
    views_used: int
    views_per_board: tuple[int, ...]
    views_dropped: tuple[DroppedView, ...]
    used: np.ndarray
    rotation: FloatArray
    shift: FloatArray
    residuals: FloatArray
    coverage: Coverage
    models: tuple[ModelTrial, ...] = ()
    refused: bool = False
    reason: str = ""
    mount: CameraMount | None = None
    board_warp: BoardWarp | None = None

    @property
    def view_rms(self) -> FloatArray:
        """Root mean square corner distance of each used view, shape (views_used,) [px]."""
        squares = np.sum(self.residuals**2, axis=2)
        return np.asarray(np.sqrt(np.nanmean(squares, axis=1)))

    @property
    def worst_views(self) -> tuple[int, ...]:
        """Numbers among the used views of those to take again, the worst first: twice the median view's error."""
        rms = self.view_rms
        bad = np.flatnonzero(rms > RETAKE_RATIO * np.median(rms))
        return tuple(int(view) for view in bad[np.argsort(-rms[bad])])

    @property
    def parameter_deviation(self) -> dict[str, float]:
        """Standard deviation of every freed intrinsic, by name ([px] for fx, fy, cx, cy, else [1])."""
        deviation = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        names = names_of(intrinsics_vector(self.camera))
        return {name: float(value) for name, value in zip(names, deviation, strict=True) if value > 0.0}


@dataclass(frozen=True, slots=True)
class FitFigures:
    """The three reprojection figures of a fit, each by its name [px]."""

    rms_px: float
    mean_px: float
    paper_px: float


def fit_figures(residuals: FloatArray) -> FitFigures:
    """Return the figures of residuals (views, corners, 2) [px]; nan corners are left out."""
    distances = np.linalg.norm(residuals, axis=2)
    kept = np.isfinite(distances)
    squares = np.where(kept, distances, 0.0) ** 2
    per_image = np.sqrt(squares.sum(axis=1)) / np.maximum(kept.sum(axis=1), 1)
    return FitFigures(
        rms_px=float(np.sqrt(squares.sum() / max(int(kept.sum()), 1))),
        mean_px=float(np.nanmean(distances)),
        paper_px=float(per_image.mean()),
    )
