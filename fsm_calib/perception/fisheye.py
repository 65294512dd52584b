"""The equidistant lens fitted to the same photos: started from the lens that is there, by its own radial curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.perception import equidistant
from fsm_calib.perception.bundle import Solution, fit
from fsm_calib.perception.free_boards import BoardPoses, FreeBoards
from fsm_calib.perception.lens import radial_factor, unproject
from fsm_calib.perception.prediction import image_grid
from fsm_calib.perception.solve_settings import SolveSettings
from fsm_calib.perception.stages import held_of, prior_of
from fsm_calib.types import FloatArray

COEFFICIENTS = 4
_WIDEST = 4.0  # tangent of 76 deg: farther out the lens that is there was drawn by no board


def fit_equidistant(
    problem: FreeBoards,
    state: BoardPoses,
    kept: FloatArray,
    image_size: tuple[int, int],
    settings: SolveSettings,
) -> Solution[BoardPoses]:
    """Return the fitted equidistant lens; `state` is the fit of another lens to the same corners."""
    start = replace(state, intrinsics=equidistant_like(state.intrinsics, image_size))
    held, prior = held_of(start.intrinsics, COEFFICIENTS), prior_of(start.intrinsics, settings)
    return fit(problem, start, held, kept, prior=prior)


def equidistant_like(intrinsics: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return the equidistant intrinsics (8,) that see rays nearly as a lens of 12 intrinsics does."""
    rays = unproject(intrinsics, image_grid(image_size))
    r2 = np.sum(rays * rays, axis=1)
    r2 = r2[r2 < _WIDEST**2]
    found = np.zeros(equidistant.SIZE)
    found[:4] = intrinsics[:4]
    found[4:] = equidistant.coefficients_like(radial_factor(intrinsics, r2)[0], r2)
    return found
