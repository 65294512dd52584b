"""Settings of the camera solve, each with its unit and its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SolveSettings:
    """How the intrinsics are solved for.

    Parameters
    ----------
    coefficients : tuple of int
        Lens models to try, smallest first: 4 (k1 k2 p1 p2), 5 (and k3), 8 (and k4 k5 k6, rational).
    fewest_views : int
        Fewer views are refused: five or less leave the distortion of a real lens to chance.
    gain_in_errors : float
        A larger model is kept only when cross-validation improves by this many standard errors [1].
    all_but_one_up_to : int
        Up to so many views each is left out in turn; beyond, `folds` groups are.
    folds : int
        Groups of views in cross-validation.
    outlier_sigmas : float
        Corners farther off than this many noise deviations of a distance are left out [1].
    worst_share : float
        A view that lost more than this share of its corners is dropped [1].
    worst_ratio : float
        A view whose rms is this many times the median view's is dropped [1].
    smallest_outlier_px : float
        No corner nearer than this is an outlier [px].
    light_prior : float
        Standard deviation of a prior around 0 on k3, k4, k5, k6 [1]: it costs nothing where the boards reach
        and keeps the lens from folding where they do not (mrcal calls it light regularization).
    largest_error_of_width : float
        A cross-validated or predicted error beyond this share of the image's width is refused [1].
    fisheye : bool
        Whether the equidistant lens of a fisheye is tried, too: for photos of any camera. A Duckiebot's is none.
    """

    coefficients: tuple[int, ...] = (4, 5, 8)
    fewest_views: int = 6
    gain_in_errors: float = 2.0
    all_but_one_up_to: int = 15
    folds: int = 10
    outlier_sigmas: float = 5.0
    worst_share: float = 0.25
    worst_ratio: float = 4.0
    smallest_outlier_px: float = 0.5
    light_prior: float = 0.1
    largest_error_of_width: float = 0.02
    fisheye: bool = False


DEFAULT_SOLVE = SolveSettings()
ANY_CAMERA = SolveSettings(fisheye=True)
"""For photos of a camera of which nothing is known."""
