"""Wheel radii, axle length and sensor pose from wheel motion and displacements over intervals.

Model and observability: Censi, Franchi, Marchionni, Oriolo 2013 (DOI 10.1109/TRO.2012.2226380): the six
parameters can all be told unless the robot only drives straight or only turns on the spot in one place.
Solved by robust maximum likelihood (`identify_robust`) with a full noise covariance of (dx, dy, dtheta) in
place of their trimmed closed form.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.identify.align_heading import complex_linear, robust_linear
from fsm_calib.diagnosis.identify.result import Estimate, Identification, unknown
from fsm_calib.diagnosis.identify.robust_rows import RobustFit, robust_fit
from fsm_calib.diagnosis.replay.kinematics import body_motion, sensor_motion
from fsm_calib.diagnosis.replay.wheels import TYPICAL_AXLE, Wheels, wheels_of
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
    """Fit, with or without a sensor pose, from the linear first guess."""
    track = recording.displacement
    with_sensor = track is not None and track.of == "sensor"
    axle = recording.robot.axle_length or TYPICAL_AXLE
    scale = np.array([wheels.size, wheels.size, axle, 0.1 * axle, 0.1 * axle, 0.1])
    count = 6 if with_sensor else 3

    def model(parameters: FloatArray) -> FloatArray:
        a_left, a_right, b = parameters[:3]
        d, dtheta = body_motion(left, right, a_left, a_right, b)
        return sensor_motion(d, dtheta, parameters[3:] if with_sensor else np.zeros(3))

    start = _start(wheels.nominal or wheels.size, axle, left, right, measured, with_sensor)
    best = robust_fit(model, measured, start[:count], scale[:count])
    return best, with_sensor


def _start(
    scale: float, axle: float, left: FloatArray, right: FloatArray, measured: FloatArray, with_sensor: bool
) -> FloatArray:
    """Return the first guess from linear fits.

    dtheta = J_r q_r - J_l q_l and, in the frame at half the turn, with the sensor at l = x + i y, heading
    psi, dz = exp(-i psi) ((a_l q_l + a_r q_r) / 2 + i l dtheta); both hold for small turns, and robustly
    fitted.
    """
    j = robust_linear(np.stack([-left, right], axis=1), measured[:, 2])
    turn = j[1] * right - j[0] * left
    move = (measured[:, 0] + 1j * measured[:, 1]) * np.exp(-0.5j * measured[:, 2])
    ratio = np.array([abs(j[0]), abs(j[1])]) / max(float(np.abs(j).mean()), 1e-12)
    forward = (np.copysign(ratio[0], j[0]) * left + np.copysign(ratio[1], j[1]) * right) / 2.0
    design = np.stack([forward * np.sinc(turn / (2.0 * np.pi)), 2.0 * np.sin(turn / 2.0)], axis=1)
    alpha, beta = map(complex, complex_linear(design, move))
    if not with_sensor and alpha.real < 0.0:
        alpha, j = abs(alpha) + 0j, -j
    mean, psi = abs(alpha), -float(np.angle(alpha))
    if not 0.02 < mean / scale < 50.0:
        mean = scale
    length = mean / max(float(np.abs(j).mean()), 1e-12)
    place = -1j * beta * np.exp(1j * psi)
    radii = mean * ratio * np.sign(j)
    return np.array([radii[0], radii[1], min(length, 20.0 * axle), place.real, place.imag, psi])


def _estimate(fit: RobustFit, i: int, unit: str) -> Estimate:
    """Return parameter `i`; outliers with a common cause count as noise in its deviation."""
    value, robust = float(fit.parameters[i]), float(np.sqrt(fit.covariance[i, i]))
    limit = UNTOLD_ANGLE if unit == "rad" else UNTOLD_LENGTH if i >= 3 else UNTOLD_SHARE * abs(value)
    if not robust < limit:
        return unknown(unit, NO_TURNS)
    value = wrap_angle(value) if unit == "rad" else value
    if not fit.outliers_have_a_cause:
        return Estimate(value, robust, unit)
    sd = max(float(np.sqrt(fit.covariance_with_outliers[i, i])), robust)
    return Estimate(value, sd, unit, sd_robust=robust)


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
            f"{fit.outliers} of {len(fit.weights)} intervals ({share:.1f} %) are outliers, weighted down"
        )
    if fit.outliers_have_a_cause:
        notes.append(
            "the outliers err to one side, so they have a cause which the other rows may share: every sd counts "
            "them as noise, but for the worst 1 %; sd_robust is what the other rows alone give"
        )
    if (fit.parameters[:2] < 0).any():
        notes.append("a wheel's scale came out negative: the sign of that wheel's channel is reversed")
    return tuple(notes)
