"""Steps between poses that no robot makes: a tracker lost it and found it elsewhere, or the map moved."""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

FASTEST = 3.0  # m/s; three times what a Duckiebot, a Create or a Khepera can do
FASTEST_OF_ALL = 20.0  # m/s; no robot on wheels that is recorded here
FASTEST_TURN = 15.0  # rad/s; twice a Duckiebot's spin
SMALLEST_TURN = 0.3  # rad; less may be noise between two poses that came close together
FEW_JUMPS = 0.05  # share of rows; more jumps than that are no jumps but a wrong unit


def fastest_of(recording: Recording) -> float:
    """Return the speed [m/s] that no such robot passes: twice what its wheels or commands say where that is more."""
    radius, told = recording.robot.wheel_radius or 0.0, [0.0]
    for pair, scale in ((recording.wheel_rate, radius), (recording.wheel_speed, 1.0)):
        if pair is not None and len(pair):
            told.append(scale * float(np.quantile(np.maximum(np.abs(pair.left), np.abs(pair.right)), 0.99)))
    if recording.twist is not None and len(recording.twist):
        told.append(float(np.quantile(np.abs(recording.twist.v), 0.99)))
    return max(FASTEST, min(2.0 * max(told), FASTEST_OF_ALL))


def leaps(time: FloatArray, x: FloatArray, y: FloatArray, theta: FloatArray, fastest: float) -> np.ndarray:
    """Return a mask (n,) of the poses that no robot below `fastest` [m/s] could have reached from the one before.

    time [s], x, y [m], theta [rad]: shape (n,); where a heading is unknown (NaN) places alone are judged.
    """
    far = np.zeros(len(time), dtype=bool)
    if len(time) < 2:
        return far
    step = np.diff(time)
    way = np.hypot(np.diff(x), np.diff(y))
    turn = np.zeros(len(step))
    if np.isfinite(theta).all():
        turn = np.abs(np.angle(np.exp(1j * np.diff(theta))))
    far[1:] = (way > fastest * step) & (way > fastest * float(np.median(step)))
    far[1:] |= (turn > FASTEST_TURN * step) & (turn > SMALLEST_TURN)
    return far
