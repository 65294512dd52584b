"""Wheel radii, axle length and sensor pose from wheel motion and displacements over intervals.

Model and observability: Censi, Franchi, Marchionni, Oriolo 2013 (DOI 10.1109/TRO.2012.2226380): the six
parameters can all be told unless the robot only drives straight or only turns on the spot in one place.
Solved by robust maximum likelihood (`identify_robust`) with a full noise covariance of (dx, dy, dtheta) in
place of their trimmed closed form.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.identify_inputs import TYPICAL_AXLE, Wheels, wheels_of
from fsm_calib.diagnosis.identify_motion import body_motion, sensor_motion
from fsm_calib.diagnosis.identify_result import Estimate, Identification, unknown
from fsm_calib.diagnosis.identify_robust import RobustFit, robust_fit
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray, wrap_angle

FEWEST_ROWS = 20  # intervals; six parameters and three noise levels need some more than nine numbers
UNTOLD_LENGTH = 0.5  # m: a sensor offset with a larger standard deviation is not told
UNTOLD_ANGLE = 1.0  # rad, likewise
NO_TURNS = "the motion does not tell it: drive arcs to both sides as well as straight"
UNTOLD_SHARE = 0.5  # of its value: a radius or an axle with a larger standard deviation is not told


def identify_from_displacement(recordings: list[Recording]) -> Identification:
    """Fit all recordings together; they must be of one robot with one sensor."""
    pieces = [_intervals(recording) for recording in recordings]
    left, right = (np.concatenate([piece[i] for piece in pieces]) for i in (0, 1))
    measured = np.concatenate([piece[2] for piece in pieces])
    if len(measured) < FEWEST_ROWS:
        raise DataError(f"only {len(measured)} intervals, expected {FEWEST_ROWS}", cure="Record longer.")
    wheels, first = wheels_of(recordings[0]), recordings[0]
    fit, with_sensor = _fit(wheels, first, left, right, measured)
    names = [
        f"{wheels.name}_left",
        f"{wheels.name}_right",
        "axle_length",
        "sensor.x",
        "sensor.y",
        "sensor.theta",
    ]
    units = [wheels.scale_unit, wheels.scale_unit, "m", "m", "m", "rad"]
    estimates = {}
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        if i >= 3 and not with_sensor:
            estimates[name] = unknown(unit, "the displacements are the base's own: no sensor pose enters")
        else:
            estimates[name] = _estimate(fit, i, unit)
    return Identification(
        first.robot.name, "wheels and displacements", estimates, _residual(fit), _notes(fit),
        tuple(finding for recording in recordings for finding in recording.checks),
    )  # fmt: skip


def _intervals(recording: Recording) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the travel of both wheels and the displacement over every interval."""
    track = recording.displacement
    if track is None:
        raise DataError("no displacement was recorded")
    measured = np.stack([track.dx, track.dy, track.dtheta], axis=1)
    rates = recording.wheel_rate or recording.wheel_speed
    lasts = None if rates is None or recording.wheel_angle is not None else rates.duration
    if rates is not None and lasts is not None and np.array_equal(lasts, track.duration):
        return rates.left * lasts, rates.right * lasts, measured
    wheels = wheels_of(recording)
    end = track.time + track.duration
    left = np.interp(end, wheels.time, wheels.left) - np.interp(track.time, wheels.time, wheels.left)
    right = np.interp(end, wheels.time, wheels.right) - np.interp(track.time, wheels.time, wheels.right)
    return left, right, measured


def _fit(
    wheels: Wheels, recording: Recording, left: FloatArray, right: FloatArray, measured: FloatArray
) -> tuple[RobustFit, bool]:
    """Start from a linear fit of the turns and the heading of the sensor that suits best."""
    track = recording.displacement
    with_sensor = track is not None and track.of == "sensor"
    axle = recording.robot.axle_length or TYPICAL_AXLE
    scale = np.array([wheels.size, wheels.size, axle, 0.1 * axle, 0.1 * axle, 0.1])
    count = 6 if with_sensor else 3

    def model(parameters: FloatArray) -> FloatArray:
        a_left, a_right, b = parameters[:3]
        d, dtheta = body_motion(left, right, a_left, a_right, b)
        return sensor_motion(d, dtheta, parameters[3:] if with_sensor else np.zeros(3))

    fits = [
        robust_fit(model, measured, start[:count], scale[:count])
        for start in _starts(wheels.nominal or wheels.size, axle, left, right, measured, with_sensor)
    ]
    best = min(fits, key=lambda fit: float(np.log(np.linalg.det(fit.scatter))))
    return best, with_sensor


def _starts(
    scale: float, axle: float, left: FloatArray, right: FloatArray, measured: FloatArray, with_sensor: bool
) -> list[FloatArray]:
    """Return first guesses: the turn's sign and ratio from the rows' median, four headings of the sensor."""
    turn = (right - left) * scale / axle
    turning = np.abs(turn) > np.median(np.abs(turn))
    ratio = float(np.median(measured[turning, 2] / turn[turning])) if turning.any() else 1.0
    axle = axle / abs(ratio) if 0.1 < abs(ratio) < 10.0 else axle
    sign = 1.0 if ratio >= 0 else -1.0
    headings = np.arange(4) * np.pi / 2.0 if with_sensor else [0.0]
    return [np.array([sign * scale, sign * scale, axle, 0.0, 0.0, heading]) for heading in headings]


def _estimate(fit: RobustFit, i: int, unit: str) -> Estimate:
    value, sd = float(fit.parameters[i]), float(np.sqrt(fit.covariance[i, i]))
    limit = UNTOLD_ANGLE if unit == "rad" else UNTOLD_LENGTH if i >= 3 else UNTOLD_SHARE * abs(value)
    if not sd < limit:
        return unknown(unit, NO_TURNS)
    all_rows = float(np.sqrt(fit.covariance_all_rows[i, i]))
    return Estimate(wrap_angle(value) if unit == "rad" else value, sd, unit, sd_all_rows=all_rows)


def _residual(fit: RobustFit) -> dict[str, float]:
    kept = fit.residuals[fit.weights >= 0.25]
    rms = np.sqrt(np.mean(kept**2, axis=0))
    return {
        "xy_m": float(np.hypot(rms[0], rms[1])),
        "theta_rad": float(rms[2]),
        "rows": float(len(fit.residuals)),
        "outliers": float(fit.outliers),
    }


def _notes(fit: RobustFit) -> tuple[str, ...]:
    notes = []
    if fit.outliers:
        share = 100.0 * fit.outliers / len(fit.weights)
        notes.append(
            f"{fit.outliers} of {len(fit.weights)} intervals ({share:.1f} %) are outliers, weighted down; "
            "sd_all_rows takes them for noise"
        )
    if (fit.parameters[:2] < 0).any():
        notes.append("a wheel's scale came out negative: the sign of that wheel's channel is reversed")
    return tuple(notes)
