"""How often did the robot turn round while nobody saw it? Headings unwrapped with the help of what the wheels did.

A robot that spins with 4 rad/s turns more than half round in a gap of a second, and the nearer way round is then the
wrong one: the path seems to be kicked by a whole turn (seen as a false push on generated robots). The turn that the
wheels were told, or made, tells the branch; its scale is taken from the stretches that were seen:

    theta(k + 1) - theta(k) = the branch nearest to  c (W(k + 1) - W(k)),      c = sum dtheta dW / sum dW^2

W is the integral of the wheels' difference, right minus left, in any unit. Assumes that c W is right to half a turn.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.replay.wheels import wheels_of
from fsm_calib.recording.recording import Recording, held_integral
from fsm_calib.types import FloatArray

SHORT_GAP = 0.3  # s: no small robot turns half round in it
STRETCH = 1.0  # s over which seen turns are compared with the wheels': long beside a motor's lag
LAG = 0.15  # s by which a motor follows its command
FULL_TURN = 2.0 * np.pi


def unwound(recording: Recording, time: FloatArray, theta: FloatArray) -> FloatArray:
    """Return headings (n,) [rad] at `time` (n,) [s] without jumps, full turns in gaps counted by the wheels."""
    theta = np.unwrap(theta)
    gaps = np.flatnonzero(np.diff(time) > SHORT_GAP)
    if not len(gaps):
        return theta
    told = wheels_turn(recording, time)
    if told is None:
        return theta
    scale = _scale(time, theta, told, gaps)
    for k in gaps:
        expected, seen = scale * (told[k + 1] - told[k]), theta[k + 1] - theta[k]
        theta[k + 1 :] += FULL_TURN * np.round((expected - seen) / FULL_TURN)
    return theta


def _scale(time: FloatArray, theta: FloatArray, told: FloatArray, gaps: np.ndarray) -> float:
    """Return radians of heading for a unit of the wheels' difference, from the stretches without a gap."""
    end = np.searchsorted(time, time + STRETCH)
    first = np.flatnonzero(end < len(time))
    last = end[first]
    whole = np.searchsorted(gaps, first) == np.searchsorted(gaps, last)
    turned, told = (series[last[whole]] - series[first[whole]] for series in (theta, told))
    return float(turned @ told / max(float(told @ told), 1e-12))


def wheels_turn(recording: Recording, time: FloatArray) -> FloatArray | None:
    """Return the integral of the wheels' difference (n,), in any unit; None where nothing tells it."""
    if any(
        track is not None for track in (recording.wheel_angle, recording.wheel_rate, recording.wheel_speed)
    ):
        left, right = wheels_of(recording).between(time)
        return np.concatenate([[0.0], np.cumsum(right - left)])
    if recording.command is not None:
        return _held(recording.command.time, recording.command.right - recording.command.left, time - LAG)
    if recording.twist is not None:
        return _held(recording.twist.time, recording.twist.omega, time - LAG)
    return None


def wheels_sum(recording: Recording, time: FloatArray) -> FloatArray | None:
    """Return the integral of the wheels' sum (n,), forward positive, in any unit; None where nothing tells it."""
    if any(
        track is not None for track in (recording.wheel_angle, recording.wheel_rate, recording.wheel_speed)
    ):
        left, right = wheels_of(recording).between(time)
        return np.concatenate([[0.0], np.cumsum(right + left)])
    if recording.command is not None:
        return _held(recording.command.time, recording.command.right + recording.command.left, time - LAG)
    if recording.twist is not None:
        return _held(recording.twist.time, recording.twist.v, time - LAG)
    return None


def _held(stamps: FloatArray, value: FloatArray, time: FloatArray) -> FloatArray:
    """Return the integral at `time` of a value that holds from each stamp to the next, 0 before the first."""
    if not len(stamps):
        return np.zeros(len(time))
    return np.interp(time, *held_integral(stamps, value, float(time[-1])))
