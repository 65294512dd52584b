"""Two computers, two clocks: commands and poses whose clocks differ by seconds are brought together by what moved when.

The robot goes when it is told to, so how much it is told to move, |left| + |right| or |v| + |omega|, and how fast the
poses move rise and fall together. The shift of the largest correlation is taken where it is more than a second, clear,
and much better than none; less is left to the fits, which know lags of their own.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from scipy.linalg import solve_banded

from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Finding, Recording, held_at
from fsm_calib.types import FloatArray

STEP, FINE = 0.1, 0.02  # s
LAGS = (0.02, 0.05, 0.08, 0.12, 0.17, 0.23, 0.3, 0.4, 0.6)  # s: motors of all sizes
NEAR = 0.6  # s about the largest correlation: the longest lag
SMALLEST = 1.0  # s: a smaller shift may be a lag
CLEAR = 0.7  # correlation that two tellings of one drive reach
BETTER = 0.3  # by which it must beat no shift
SHARED = 0.6  # of the shorter of the two that must overlap
LONGEST = 36_000.0  # s; the grid of a longer recording is not worth its memory
INPUTS = ("command", "twist", "wheel_angle", "wheel_rate", "wheel_speed")


def with_one_clock(recording: Recording) -> Recording:
    """Return the recording with commands and wheels moved onto the clock of the poses, and told."""
    pose = recording.pose
    if pose is None or len(pose) < 20 or not np.isfinite(pose.x).any():
        return recording
    changes: dict[str, Any] = {}
    said = []
    grid, seen = _pose_activity(pose)
    for name in INPUTS:
        channel = getattr(recording, name)
        if channel is None or len(channel) < 3 or getattr(channel, "duration", None) is not None:
            continue
        shift = _shift(seen, grid, *_input_activity(name, channel))
        if shift is not None:
            shift = _refined(pose, name, channel, shift) if name in ("command", "twist") else shift
            changes[name] = dataclasses.replace(channel, time=channel.time + shift)
            sentence = f"its clock and the poses' differ; {shift:+.2f} s brought what moved when together"
            said.append(Finding(name, "clocks", sentence, "kept", 0, float(channel.time[0])))
    return (
        dataclasses.replace(recording, **changes, checks=(*recording.checks, *said)) if changes else recording
    )


def _grid(first: float, last: float, step: float) -> FloatArray:
    return np.arange(first, min(last, first + LONGEST), step)


def _refined(pose: PoseTrack, name: str, channel: Any, shift: float) -> float:
    """Return the shift [s] of commands at which motors that lag behind them tell the poses' motion best.

    A correlation lays the lag of the motors on the clock; here a first-order lag is tried beside each shift.
    """
    grid, seen = _pose_activity(pose, FINE)
    told_at, told = _input_activity(name, channel, FINE)
    best = (np.inf, shift)
    for lag in LAGS:
        step = FINE / (lag + FINE)
        slow = _smooth(_lagging(told, step))
        for change in np.arange(-NEAR, NEAR + FINE, FINE):
            there = np.interp(grid, told_at + shift + change, slow)
            gain = float(there @ seen) / max(float(there @ there), 1e-12)
            best = min(best, (float(np.sum((seen - gain * there) ** 2)), float(shift + change)))
    return best[1]


def _lagging(told: FloatArray, step: float) -> FloatArray:
    """Return y (n,) with y_i = y_(i-1) + step (told_i - y_(i-1)), from rest: a first-order lag, row by row."""
    bands = np.vstack([np.ones(len(told)), np.full(len(told), step - 1.0)])
    return np.asarray(solve_banded((1, 0), bands, step * told))


def _pose_activity(pose: PoseTrack, step: float = STEP) -> tuple[FloatArray, FloatArray]:
    """Return a grid of times, every `step` [s], and how fast the pose moves there."""
    known = np.isfinite(pose.x) & np.isfinite(pose.y)
    time = pose.time[known]
    grid = _grid(time[0], time[-1], step)
    x, y = (np.interp(grid, time, part[known]) for part in (pose.x, pose.y))
    speed = _unitless(np.hypot(np.gradient(_smooth(x)), np.gradient(_smooth(y)))) if len(grid) > 5 else grid
    theta = pose.theta[known]
    if len(grid) > 5 and np.isfinite(theta).all():
        turn = np.abs(np.gradient(_smooth(np.interp(grid, time, np.unwrap(theta)))))
        speed = speed + _unitless(turn)
    return grid, speed


def _input_activity(name: str, channel: Any, step: float = STEP) -> tuple[FloatArray, FloatArray]:
    """Return a grid of times [s] and how much the robot is told to move, or its wheels do."""
    grid = _grid(channel.time[0], channel.time[-1], step)
    if len(grid) < 6:
        return grid, np.zeros(len(grid))
    if name == "wheel_angle":
        sides = [
            np.gradient(_smooth(np.interp(grid, channel.time, s))) for s in (channel.left, channel.right)
        ]
    else:
        pair = (channel.v, channel.omega) if name == "twist" else (channel.left, channel.right)
        sides = [held_at(grid, channel.time, s) for s in pair]
    if name == "twist":
        return grid, _unitless(np.abs(sides[0])) + _unitless(np.abs(sides[1]))
    return grid, _unitless(np.abs(sides[0] + sides[1])) + _unitless(np.abs(sides[0] - sides[1]))


def _smooth(values: FloatArray) -> FloatArray:
    return np.convolve(np.pad(values, 2, mode="edge"), np.full(5, 0.2), mode="valid")


def _unitless(values: FloatArray) -> FloatArray:
    top = float(np.quantile(values, 0.95)) if len(values) else 0.0
    return np.clip(values / top, 0.0, 1.5) if top > 0.0 else values


def _shift(a: FloatArray, a_grid: FloatArray, b_grid: FloatArray, b: FloatArray) -> float | None:
    """Return by how much [s] the times of `b` must be moved to fit `a`; None where they fit as they are."""
    shorter = min(len(a), len(b))
    if shorter < 50 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    size = 1 << int(len(a) + len(b)).bit_length()

    def sums(left: FloatArray, right: FloatArray) -> FloatArray:
        """Return sum_t left(t + k) right(t) for k = -len(b) + 1 ... len(a) - 1."""
        both = np.fft.irfft(np.fft.rfft(left, size) * np.conj(np.fft.rfft(right, size)), size)
        return np.concatenate([both[-(len(b) - 1) :], both[: len(a)]])

    one_a, one_b = np.ones(len(a)), np.ones(len(b))
    n = np.maximum(sums(one_a, one_b), 1.0)
    mean_a, mean_b = sums(a, one_b) / n, sums(one_a, b) / n
    covariance = sums(a, b) / n - mean_a * mean_b
    spread = np.sqrt(
        np.maximum(sums(a**2, one_b) / n - mean_a**2, 1e-9)
        * np.maximum(sums(one_a, b**2) / n - mean_b**2, 1e-9)
    )
    fit = np.where(n >= SHARED * shorter, covariance / spread, -1.0)
    offsets = float(a_grid[0] - b_grid[0]) + STEP * np.arange(-(len(b) - 1), len(a))
    best, none = int(np.argmax(fit)), int(np.argmin(np.abs(offsets)))
    unmoved = float(fit[none]) if abs(float(offsets[none])) <= STEP else -1.0
    if abs(float(offsets[best])) < SMALLEST or fit[best] < CLEAR or fit[best] < unmoved + BETTER:
        return None
    return float(offsets[best])
