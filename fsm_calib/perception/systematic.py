"""What no number of views averages out: errors that a corner repeats in every view of its board.

The covariance of a fit assumes that corner errors are independent; then a hundred views promise a hundredth
of a pixel. Real ones repeat: a print is bent by a tenth of a millimetre, blur and lens pull one corner the
same way in every view. With a of them [px], shared by all views of a corner i of a board b and independent
between corners, the intrinsics move by S^-1 G_bi' e with G_bi = sum over views of the derivatives J_vi, local
unknowns eliminated, and

    C_sys = a^2 S^-1 (sum_bi G_bi' G_bi) S^-1

is added to the covariance. a = 0.025 px is what explains the true errors of rendered scans, after the bias of
curved edges is taken off; without it the predicted error of a long scan is three times too small. The form is
the cluster-robust covariance of Liang and Zeger, Biometrika 1986, with the errors' size assumed rather than
estimated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.bundle import Solution
from fsm_calib.types import FloatArray

REPEATED_ERROR_PX = 0.025  # per coordinate; see the module


def systematic_covariance(
    solution: Solution,
    board: NDArray[np.int_],
    held: NDArray[np.bool_],
    amplitude_px: float = REPEATED_ERROR_PX,
) -> FloatArray:
    """Return the covariance (s, s) of the shared unknowns by errors that corners repeat.

    Parameters
    ----------
    solution : Solution
    board : array of int, shape (views,)
        Which board each view shows.
    held : array of bool, shape (s,)
    amplitude_px : float
        Standard deviation of the repeated error per coordinate [px].
    """
    linearized, normal = solution.linearized, solution.normal
    back = normal.local_inverse @ np.swapaxes(normal.cross, 1, 2)
    reduced = linearized.shared - linearized.local @ back[linearized.block]
    reduced = reduced * np.repeat(solution.weights, 2, axis=1)[..., None]
    middle = np.zeros((held.size, held.size))
    for number in np.unique(board):
        pull = reduced[board == number].sum(axis=0)
        middle += pull.T @ pull
    free = np.ix_(~held, ~held)
    inverse = np.zeros_like(middle)
    inverse[free] = np.linalg.pinv(normal.information[free], hermitian=True)
    return np.asarray(amplitude_px**2 * inverse @ middle @ inverse)
