"""A first guess from the shape of the path: signs of the wheels, scale, axle length, start heading.

The wheels are chained to a path for every choice of signs and a ladder of axle lengths, and each path is laid
on the measured one by the best rotation, shift and scale (Umeyama 1991, DOI 10.1109/34.88573, in the plane
with complex numbers: z = x + i y). The choice with the smallest error wins; the stated signs stay unless
others are clearly better.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from fsm_calib.diagnosis.identify.align_heading import SHORTEST_PATH, linear_guess
from fsm_calib.diagnosis.replay.kinematics import dead_reckon
from fsm_calib.diagnosis.replay.wheels import TYPICAL_AXLE, Wheels
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.types import FloatArray

LADDER = np.geomspace(0.3, 3.0, 41)  # axle lengths tried, as multiples of the stated one
PATHS = (4.0, 8.0, 16.0, 32.0)  # m: least squares on growing paths; beyond, drift hides the axle
CLEARLY_BETTER = 0.7  # an error below this share of the stated signs' error overrules them
SIGNS = ((1, 1, False), (-1, -1, False), (1, -1, False), (-1, 1, False))  # exchanged sides look like (-1, -1)


@dataclass(frozen=True, slots=True)
class Alignment:
    """Signs (and exchange) of the wheels, scale, axle [m], start heading of the base [rad], psi [rad], error
    [m].
    """

    left_sign: int
    right_sign: int
    exchanged: bool
    scale: float
    axle: float
    heading: float
    psi: float
    error: float
    ratio: float = 1.0

    @property
    def scales(self) -> tuple[float, float]:
        """Scale of the left and of the right wheel."""
        left = 2.0 * self.scale / (1.0 + self.ratio)
        return left, left * self.ratio

    @property
    def as_stated(self) -> bool:
        """Whether signs and sides are those of the manifest."""
        return (self.left_sign, self.right_sign, self.exchanged) == (1, 1, False)

    def applied(self, wheels: Wheels) -> Wheels:
        """Return the wheels with these signs and sides."""
        left, right = self.sides(wheels.left, wheels.right)
        return dataclasses.replace(wheels, left=left, right=right)

    def sides(self, left: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what stands in the left and the right column with these signs and sides."""
        left, right = self.left_sign * left, self.right_sign * right
        return (right, left) if self.exchanged else (left, right)


def align(wheels: Wheels, pose: PoseTrack, axle: float | None) -> Alignment:
    """Return the best first guess; raise DataError for a robot that stood still."""
    if pose.has_heading:
        left_sign, right_sign, exchanged, scale, length, psi = linear_guess(wheels, pose, axle)
        first = float(pose.theta[np.isfinite(pose.theta)][0]) - psi
        return Alignment(left_sign, right_sign, exchanged, scale, length, first, psi, 0.0)
    left, right = wheels.between(pose.time)
    moved = np.concatenate([[0.0], np.cumsum(np.maximum(np.abs(left), np.abs(right)))]) * (
        wheels.nominal or wheels.size
    )
    measured_way = float(np.hypot(np.ptp(pose.x), np.ptp(pose.y)))
    if moved[-1] < SHORTEST_PATH or measured_way < SHORTEST_PATH:
        raise DataError(
            "the robot hardly moved", cure="Drive at least some turns of the wheels, to both sides."
        )
    found = []
    for signs in SIGNS:
        a, b = signs[0] * left, signs[1] * right
        guesses = []
        for path in (PATHS[0], PATHS[-1]):
            end = max(int(np.searchsorted(moved, path)), 10)
            guess = _best_axle(
                wheels, pose.rows(slice(0, end)), left[: end - 1], right[: end - 1], axle, signs
            )
            guesses.append(_refined(guess, pose, a, b, moved))
        found.append(min(guesses, key=lambda guess: guess.error))
    stated = found[0]
    best = min(found, key=lambda guess: guess.error)
    return best if best.error < CLEARLY_BETTER * stated.error else stated


def _refined(
    guess: Alignment, pose: PoseTrack, left: FloatArray, right: FloatArray, moved: FloatArray
) -> Alignment:
    """Fit both scales, the axle and the tracked point on growing paths by robust least squares."""
    size = np.array([guess.scale, guess.scale, guess.axle, 0.02, 0.02])
    vector, turn, error = np.array([1.0, 1.0, 1.0, 0.0, 0.0]), guess.heading, guess.error
    for path in PATHS:
        end = max(int(np.searchsorted(moved, path)), 10)
        target = (pose.x + 1j * pose.y)[:end]

        def difference(u: FloatArray, end: int = end, target: np.ndarray = target) -> np.ndarray:
            a_left, a_right, b, px, py = u * size
            s_left, s_right = a_left * left[: end - 1], a_right * right[: end - 1]
            x, y, theta = dead_reckon((s_left + s_right) / 2.0, (s_right - s_left) / b, (0.0, 0.0, 0.0))
            point = x + 1j * y + np.exp(1j * theta) * complex(px, py)
            return _rotated(point, target)[0]

        def residual(
            u: FloatArray, difference: Callable[[FloatArray], np.ndarray] = difference
        ) -> FloatArray:
            away = difference(u)
            return np.concatenate([away.real, away.imag])

        low, high = [0.2, 0.2, 0.2, -20.0, -20.0], [5.0, 5.0, 5.0, 20.0, 20.0]
        fit = least_squares(residual, vector, bounds=(low, high), loss="soft_l1", f_scale=0.02, max_nfev=40)
        vector, error = fit.x, float(np.sqrt(np.mean(np.abs(difference(fit.x)) ** 2)))
        if moved[-1] <= path:
            break
    a_left, a_right, b, px, py = vector * size
    x, y, theta = dead_reckon(
        (a_left * left + a_right * right) / 2.0, (a_right * right - a_left * left) / b, (0.0, 0.0, 0.0)
    )
    end = max(int(np.searchsorted(moved, path)), 10)
    point = (x + 1j * y + np.exp(1j * theta) * complex(px, py))[:end]
    turn = _rotated(point, (pose.x + 1j * pose.y)[:end])[1]
    scale = float(a_left + a_right) / 2.0
    return dataclasses.replace(
        guess, scale=scale, ratio=float(a_right / a_left), axle=float(b), heading=turn, error=error
    )


def _rotated(point: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, float]:
    """Lay `point` on `target` by the best rotation and shift; return what is left [m] and the
    rotation [rad].
    """
    a, b = point - point.mean(), target - target.mean()
    turn = float(np.angle(np.vdot(a, b)))
    return b - np.exp(1j * turn) * a, turn


def _best_axle(
    wheels: Wheels,
    pose: PoseTrack,
    left: FloatArray,
    right: FloatArray,
    axle: float | None,
    signs: tuple[int, int, bool],
) -> Alignment:
    """Try the ladder of axle lengths for one choice of signs."""
    left, right = signs[0] * left, signs[1] * right
    scale = wheels.nominal or wheels.size
    target = pose.x + 1j * pose.y
    guesses = []
    for length in LADDER * (axle or TYPICAL_AXLE):
        x, y, _theta = dead_reckon(
            scale * (left + right) / 2.0, scale * (right - left) / length, (0.0, 0.0, 0.0)
        )
        factor, error = lay_on(x + 1j * y, target)
        size = abs(factor) if 0.5 < abs(factor) < 2.0 else 1.0
        guesses.append(
            Alignment(*signs, scale * size, float(length) * size, float(np.angle(factor)), 0.0, error)
        )
    return min(guesses, key=lambda guess: guess.error)


def lay_on(path: np.ndarray, target: np.ndarray) -> tuple[complex, float]:
    """Return the factor (scale and rotation) that lays `path` on `target`, and the rms error [m] without
    scaling.
    """
    a, b = path - path.mean(), target - target.mean()
    power = float(np.sum(np.abs(a) ** 2))
    factor = complex(np.vdot(a, b) / power) if power > 0.0 else 1.0 + 0j
    return factor, float(np.sqrt(np.mean(np.abs(b - factor * a) ** 2)))


def open_loop_error(wheels: Wheels, pose: PoseTrack, values: dict[str, float]) -> float:
    """Return the rms position error [m] of the whole path by wheels alone, its start pose chosen best."""
    left, right = wheels.between(pose.time + values["clock"])
    s_left, s_right = values["left"] * left, values["right"] * right
    x, y, theta = dead_reckon((s_left + s_right) / 2.0, (s_right - s_left) / values["axle"], (0.0, 0.0, 0.0))
    point = x + 1j * y + np.exp(1j * theta) * complex(values["px"], values["py"])
    target = pose.x + 1j * pose.y
    return float(np.sqrt(np.mean(np.abs(_rotated(point, target)[0]) ** 2)))
