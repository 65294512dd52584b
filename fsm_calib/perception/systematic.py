"""What no number of views averages out: errors that a corner repeats in every view of its board, or all share.

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

The bias of curved edges (`corner_bias`) is of one kind on all boards, and so is what its removal leaves: a share
r of it, unknown but the same for all corners. With b_v the bias of the corners of view v, that moves the intrinsics by

    m = S^-1 sum_v J_v' b_v,   C_shared = r^2 m m'

r = 0.5 is an allowance: over rendered scans of 16 robots the share left in the corners is -0.09 +- 0.11 in plain light
and 0.29 +- 0.22 in glare (`benchmarks/camera_glare.py`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.bundle import Solution
from fsm_calib.types import FloatArray

REPEATED_ERROR_PX = 0.025  # per coordinate; see the module
SHARE_LEFT = 0.5  # of the bias of curved edges; see the module


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
    reduced, inverse = _reduced(solution), _inverse(solution, held)
    middle = np.zeros((held.size, held.size))
    for number in np.unique(board):
        pull = reduced[board == number].sum(axis=0)
        middle += pull.T @ pull
    return np.asarray(amplitude_px**2 * inverse @ middle @ inverse)


def shared_covariance(
    solution: Solution, bias: FloatArray, held: NDArray[np.bool_], share: float = SHARE_LEFT
) -> FloatArray:
    """Return the covariance (s, s) of the shared unknowns by what is left of one bias of all corners.

    Parameters
    ----------
    solution : Solution
    bias : array, shape (views, corners, 2)
        The bias that was taken away [px].
    held : array of bool, shape (s,)
    share : float
        Standard deviation of the share of it that is left [1].
    """
    pull = np.einsum("vns,vn->s", _reduced(solution), bias.reshape(len(bias), -1))
    moved = share * _inverse(solution, held) @ pull
    return np.outer(moved, moved)


def _reduced(solution: Solution) -> FloatArray:
    """Return the weighted derivatives by the shared unknowns, local ones eliminated (views, 2 n, s)."""
    linearized, normal = solution.linearized, solution.normal
    back = normal.local_inverse @ np.swapaxes(normal.cross, 1, 2)
    reduced = linearized.shared - linearized.local @ back[linearized.block]
    return np.asarray(reduced * np.repeat(solution.weights, 2, axis=1)[..., None])


def _inverse(solution: Solution, held: NDArray[np.bool_]) -> FloatArray:
    """Return S^-1 of the unknowns that are not held, zero for the others, (s, s)."""
    inverse, free = np.zeros((held.size, held.size)), np.ix_(~held, ~held)
    inverse[free] = np.linalg.pinv(solution.normal.information[free], hermitian=True)
    return inverse
