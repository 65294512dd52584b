"""What a gyro alone can tell: the ratio of each wheel's radius to the axle length, and the gyro's bias.

    omega = J_r rate_r - J_l rate_l + bias,   J_i = a_i / b   [1/s per unit of the wheel's rate]

The forward motion is not seen, so neither radius nor axle can be told. A robot that always turns at about one rate
tells neither the bias nor a wheel alone: both wheels have one ratio then, and a bias of `USUAL_BIAS` is left open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.identify.result import Estimate, Identification, unknown
from fsm_calib.diagnosis.identify.robust_rows import RobustFit, robust_fit
from fsm_calib.diagnosis.replay.wheels import TYPICAL_AXLE, wheels_of
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import middle_of
from fsm_calib.types import FloatArray

CORRELATED_SECONDS = (
    2.0  # s: wheel slip and drive ripple make neighbouring yaw-rate errors alike for about so long
)
FEWEST_ROWS = 50
ONE_RATE = 3.0  # mean of the turning over its spread: of real drives 0.05 to 1.5, spins at one rate 21 to 120
USUAL_BIAS = 0.02  # rad/s, standard deviation: 1 deg/s, what a trimmed gyro keeps


@dataclass(frozen=True, eq=False)
class _Ratios:
    """The ratio J of the left and of the right wheel, (2,), with standard deviations, the gyro's bias, and the fit."""

    values: FloatArray
    sd: FloatArray
    bias: Estimate
    fit: RobustFit


def identify_from_yaw_rate(recordings: list[Recording]) -> Identification:
    """Fit all recordings of one robot together."""
    pieces = [_rates(recording) for recording in recordings]
    left, right, omega = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    if len(omega) < FEWEST_ROWS:
        raise DataError(f"only {len(omega)} yaw rates, expected {FEWEST_ROWS}", cure="Record longer.")
    first, wheels = recordings[0], wheels_of(recordings[0])
    nominal = (wheels.nominal or wheels.size) / (first.robot.axle_length or TYPICAL_AXLE)
    interval = float(np.median(np.diff(first.yaw_rate.time)))  # type: ignore[union-attr]
    turning = right - left
    at_one_rate = abs(turning.mean()) > ONE_RATE * turning.std()
    found = (_of_both if at_one_rate else _of_each)(
        left, right, omega, nominal, int(CORRELATED_SECONDS / interval)
    )
    name, unit = f"{wheels.name}_over_axle", f"{wheels.scale_unit}/m"
    reason = (
        f"only the ratio of {wheels.name} to axle_length can be told: no channel saw the forward motion; "
        f"left {found.values[0]:.5f}, right {found.values[1]:.5f}"
    )
    estimates = {f"{wheels.name}_{side}": unknown(wheels.scale_unit, reason) for side in ("left", "right")}
    estimates["axle_length"] = unknown("m", reason)
    for i, side in enumerate(("left", "right")):
        estimates[f"{name}_{side}"] = _told(float(found.values[i]), float(found.sd[i]), unit, side)
    estimates["yaw_rate_bias"] = found.bias
    for key, part_unit in (("x", "m"), ("y", "m"), ("theta", "rad")):
        estimates[f"sensor.{key}"] = unknown(part_unit, "a yaw rate is the same everywhere on the robot")
    kept = found.fit.residuals[found.fit.weights >= 0.25]
    residual = {
        "yaw_rate_radps": float(np.sqrt(np.mean(kept**2))),
        "rows": float(len(omega)),
        "outliers": float(found.fit.outliers),
    }
    return Identification(
        first.robot.name, "wheels and yaw rate", estimates, residual, _notes(found.values, nominal, wheels.name),
        tuple(finding for recording in recordings for finding in recording.checks),
    )  # fmt: skip


def _of_each(
    left: FloatArray, right: FloatArray, omega: FloatArray, nominal: float, correlated: int
) -> _Ratios:
    """Fit each wheel's ratio and the bias; `nominal` is a first guess, errors are alike over `correlated` rows."""
    fit = robust_fit(
        lambda p: (p[1] * right - p[0] * left + p[2])[:, None],
        omega[:, None],
        np.array([nominal, nominal, 0.0]),
        np.array([nominal, nominal, 0.01]),
        correlated=correlated,
    )
    sd = _deviations(fit)
    return _Ratios(fit.parameters[:2], sd[:2], Estimate(float(fit.parameters[2]), float(sd[2]), "rad/s"), fit)


def _of_both(
    left: FloatArray, right: FloatArray, omega: FloatArray, nominal: float, correlated: int
) -> _Ratios:
    """Fit one ratio of both wheels, without a bias, to a robot that turns at one rate; a bias would change it."""
    fit = robust_fit(
        lambda p: (p[0] * (right - left))[:, None],
        omega[:, None],
        np.array([nominal]),
        np.array([nominal]),
        correlated=correlated,
    )
    sd = np.hypot(_deviations(fit), USUAL_BIAS / abs(float((right - left).mean())))
    bias = unknown("rad/s", "the robot always turned at about one rate; spin at several, both ways, and rest")
    return _Ratios(np.repeat(fit.parameters, 2), np.repeat(sd, 2), bias, fit)


def _deviations(fit: RobustFit) -> FloatArray:
    """Return standard deviations (p,); rows that only ever drive straight leave variances that rounding makes negative:
    nothing is told then.
    """
    variance = np.diag(fit.covariance)
    return np.asarray(np.sqrt(np.where(variance > 0.0, variance, np.inf)))


def _told(value: float, sd: float, unit: str, side: str) -> Estimate:
    if not sd <= 0.5 * abs(value):
        return unknown(unit, f"the {side} wheel hardly moved on its own")
    return Estimate(value, sd, unit)


def _rates(recording: Recording) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the rates of both wheels and the yaw rate at the gyro's times."""
    track = recording.yaw_rate
    if track is None:
        raise DataError("no yaw rate was recorded")
    pair = recording.wheel_rate or recording.wheel_speed
    if pair is not None:
        middle = middle_of(pair)
        left, right = (np.interp(track.time, middle, side) for side in (pair.left, pair.right))
        return left, right, np.asarray(track.value)
    wheels, middle = wheels_of(recording), (track.time[1:] + track.time[:-1]) / 2.0
    left, right = wheels.between(track.time)
    step = np.diff(track.time)
    return left / step, right / step, np.interp(middle, track.time, track.value)


def _notes(ratios: FloatArray, nominal: float, name: str) -> tuple[str, ...]:
    mean = float(ratios.mean())
    notes = []
    if mean < 0:
        notes.append(
            "the robot turns the other way than its wheels say: sides exchanged or both signs reversed"
        )
    elif not 0.9 < mean / nominal < 1.1:
        notes.append(
            f"the robot turns {mean / nominal:.2f} times as fast as {name} and axle of the manifest say: "
            f"an effective axle of {nominal / mean:.2f} times the stated one (skidding wheels) or wrong facts"
        )
    return tuple(notes)
