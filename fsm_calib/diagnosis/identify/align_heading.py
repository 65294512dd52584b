"""A first guess where headings were measured: two linear fits over stretches of about a second.

    dtheta = J_r q_r - J_l q_l                     J_i = a_i / b
    dz exp(-i theta_m) = alpha (q_l + q_r) / 2 + beta dtheta        z = x + i y, complex alpha, beta

over each stretch, theta_m its middle heading. The signs of J tell reversed or exchanged wheels, the phase of
alpha is -psi (how the tracked point's heading stands on the robot) and its size the mean scale.
"""

from __future__ import annotations

import cmath

import numpy as np
from scipy.optimize import nnls

from fsm_calib.diagnosis.replay.wheels import TYPICAL_AXLE, Wheels
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.types import FloatArray

STRETCH = 1.0  # s: long beside time constants and delays, short beside a turn
SHORTEST_PATH = 0.05  # m: a robot that moved less stood still
ROUNDS = 15  # of re-weighting against outliers


def linear_guess(
    wheels: Wheels, pose: PoseTrack, axle: float | None
) -> tuple[int, int, bool, float, float, float]:
    """Return left sign, right sign, exchanged, scale, axle [m], psi [rad]; raise DataError for a robot at
    rest.
    """
    left, right, turn, move = moves_of(wheels, pose)
    nominal = wheels.nominal or wheels.size
    if float(np.abs(move).max()) < SHORTEST_PATH:
        raise DataError(
            "the robot hardly moved", cure="Drive at least some turns of the wheels, to both sides."
        )
    j = robust_linear(np.stack([-left, right], axis=1), turn)
    exchanged = False
    signs = [1 if j[0] >= 0 else -1, 1 if j[1] >= 0 else -1]
    alpha = forward_of(signs[0] * left + signs[1] * right, turn, move)
    if are_exchanged((signs[0], signs[1]), alpha):
        signs, exchanged, alpha = [1, 1], True, -alpha
    scale = abs(alpha) if 0.05 < abs(alpha) / nominal < 20.0 else nominal
    ratio = float(np.abs(j).mean())
    length = scale / ratio if ratio > 0 else axle or TYPICAL_AXLE
    stated = axle or TYPICAL_AXLE
    length = length if 0.2 < length / stated < 5.0 else stated
    return signs[0], signs[1], exchanged, float(scale), float(length), -float(np.angle(alpha))


def are_exchanged(signs: tuple[int, int], alpha: complex) -> bool:
    """Return whether the columns are: both wheels turn the robot the wrong way, yet it drives forward as stated."""
    return signs == (-1, -1) and abs(cmath.phase(alpha)) > np.pi / 2.0


def moves_of(wheels: Wheels, pose: PoseTrack) -> tuple[FloatArray, FloatArray, FloatArray, np.ndarray]:
    """Return q_l, q_r, dtheta [rad] and dz exp(-i theta_m) [m] over stretches; raise DataError with fewer than ten."""
    known = np.isfinite(pose.theta)
    time, heading = pose.time[known], np.unwrap(pose.theta[known])
    z = pose.x[known] + 1j * pose.y[known]
    end = np.searchsorted(time, time + STRETCH)
    start = np.flatnonzero(end < len(time))
    end = end[start]
    near = time[end] - time[start] < 2.0 * STRETCH
    start, end = start[near], end[near]
    if len(start) < 10:
        raise DataError(
            "the poses are too sparse: fewer than 10 stretches of a second", cure="Record longer."
        )
    left, right = (np.interp(time, wheels.time, side) for side in (wheels.left, wheels.right))
    middle = (heading[start] + heading[end]) / 2.0
    move = (z[end] - z[start]) * np.exp(-1j * middle)
    return left[end] - left[start], right[end] - right[start], heading[end] - heading[start], move


def forward_of(both: FloatArray, turn: FloatArray, move: np.ndarray) -> complex:
    """Return alpha."""
    return complex(complex_linear(np.stack([both / 2.0, turn], axis=1), move)[0])


def complex_linear(design: FloatArray, move: np.ndarray) -> np.ndarray:
    """Return complex coefficients of a real design (n, k) for a complex motion (n,), its two parts fitted in turn."""
    return robust_linear(design, move.real) + 1j * robust_linear(design, move.imag)


def robust_linear(design: FloatArray, target: FloatArray, positive: bool = False) -> FloatArray:
    """Least absolute deviations, roughly: least squares re-weighted by 1 / |residual|; `positive`: none below 0."""
    weight = np.ones(len(target))
    solution: FloatArray = np.zeros(design.shape[1])
    for _ in range(ROUNDS):
        root = np.sqrt(weight)
        a, b = design * root[:, None], target * root
        solution = nnls(a, b)[0] if positive else np.linalg.lstsq(a, b, rcond=None)[0].astype(np.float64)
        residual = np.abs(target - design @ solution)
        weight = 1.0 / np.maximum(residual, max(float(np.median(residual)), 1e-9))
    return solution
