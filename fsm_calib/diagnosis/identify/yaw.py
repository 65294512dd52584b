"""What a gyro alone can tell: the ratio of each wheel's radius to the axle length, and the gyro's bias.

    omega = J_r rate_r - J_l rate_l + bias,   J_i = a_i / b   [1/s per unit of the wheel's rate]

The forward motion is not seen, so neither radius nor axle can be told.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.identify.result import Estimate, Identification, unknown
from fsm_calib.diagnosis.identify.robust_rows import robust_fit
from fsm_calib.diagnosis.replay.wheels import TYPICAL_AXLE, wheels_of
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import middle_of
from fsm_calib.types import FloatArray

CORRELATED_SECONDS = (
    2.0  # s: wheel slip and drive ripple make neighbouring yaw-rate errors alike for about so long
)
FEWEST_ROWS = 50


def identify_from_yaw_rate(recordings: list[Recording]) -> Identification:
    """Fit all recordings of one robot together."""
    pieces = [_rates(recording) for recording in recordings]
    left, right, omega = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    if len(omega) < FEWEST_ROWS:
        raise DataError(f"only {len(omega)} yaw rates, expected {FEWEST_ROWS}", cure="Record longer.")
    first, wheels = recordings[0], wheels_of(recordings[0])
    nominal = (wheels.nominal or wheels.size) / (first.robot.axle_length or TYPICAL_AXLE)
    interval = float(np.median(np.diff(first.yaw_rate.time)))  # type: ignore[union-attr]
    fit = robust_fit(
        lambda p: (p[1] * right - p[0] * left + p[2])[:, None],
        omega[:, None],
        np.array([nominal, nominal, 0.0]),
        np.array([nominal, nominal, 0.01]),
        correlated=int(CORRELATED_SECONDS / interval),
    )
    # rows that only ever drive straight leave a variance that rounding can make negative: nothing is told then
    variance = np.diag(fit.covariance)
    sd = np.sqrt(np.where(variance > 0.0, variance, np.inf))
    name, unit = f"{wheels.name}_over_axle", f"{wheels.scale_unit}/m"
    reason = (
        f"only the ratio of {wheels.name} to axle_length can be told: no channel saw the forward motion; "
        f"left {fit.parameters[0]:.5f}, right {fit.parameters[1]:.5f}"
    )
    estimates = {f"{wheels.name}_{side}": unknown(wheels.scale_unit, reason) for side in ("left", "right")}
    estimates["axle_length"] = unknown("m", reason)
    for i, side in enumerate(("left", "right")):
        estimates[f"{name}_{side}"] = _told(float(fit.parameters[i]), float(sd[i]), unit, side)
    estimates["yaw_rate_bias"] = Estimate(float(fit.parameters[2]), float(sd[2]), "rad/s")
    for key, part_unit in (("x", "m"), ("y", "m"), ("theta", "rad")):
        estimates[f"sensor.{key}"] = unknown(part_unit, "a yaw rate is the same everywhere on the robot")
    kept = fit.residuals[fit.weights >= 0.25]
    residual = {
        "yaw_rate_radps": float(np.sqrt(np.mean(kept**2))),
        "rows": float(len(omega)),
        "outliers": float(fit.outliers),
    }
    return Identification(
        first.robot.name, "wheels and yaw rate", estimates, residual, _notes(fit.parameters, nominal,
        wheels.name), tuple(finding for recording in recordings for finding in recording.checks),
    )  # fmt: skip


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


def _notes(parameters: FloatArray, nominal: float, name: str) -> tuple[str, ...]:
    mean = float(parameters[:2].mean())
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
