"""A unit that is off shows: the same drive, told by two channels, differs by a factor that units differ by.

Compared are the ways that wheels or commands and the poses say the robot went, and the turns that commands, gyro and
poses say it made. A factor near 2 pi / 60 (rpm), pi / 180 (degrees), 1000 (millimetres) or, beside
speeds, 100 (centimetres) is taken off and told, where the unit was not stated; a factor 2 (diameter for radius, half an
axle) may be the robot and is told.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from fsm_calib.recording.channels import Channel, PoseTrack
from fsm_calib.recording.clear_moves import agreement, clear_moves
from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.types import FloatArray

SPAN = 1.0  # s: ways and turns are compared over this long, so that lags and noise hardly count
TOLERANCE = 0.2  # of a factor: tyres, slip and gains differ by less, the factors among each other by more
FASTEST = 20.0  # m/s: no wheeled robot that is recorded here drives so fast
QUICKEST, TURNED = 0.004, 0.5  # s between poses; rad that the headings must cover
FEWEST = 8  # spans with motion
RPM, DEGREE = 2.0 * math.pi / 60.0, math.pi / 180.0
WAY, TURN = "way", "turn"
FACTORS: Mapping[str, tuple[tuple[float, str, str], ...]] = {
    "wheel_rate": ((RPM, "rpm", WAY), (DEGREE, "deg/s", WAY)),
    "wheel_angle": ((DEGREE, "degrees", WAY),),
    "wheel_speed": ((1e-3, "mm/s", WAY),),
    "twist.v": ((1e-3, "mm/s", WAY),),
    "twist.omega": ((DEGREE, "deg/s", TURN),),
    "yaw_rate": ((DEGREE, "deg/s", TURN),),
}
"""What a channel may be in: SI units per unit, its name, and what shows it."""
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "wheel_rate": ("left", "right"),
    "wheel_angle": ("left", "right"),
    "wheel_speed": ("left", "right"),
    "twist.v": ("v",),
    "twist.omega": ("omega",),
    "yaw_rate": ("value",),
    "pose.length": ("x", "y"),
}


def with_guessed_units(recording: Recording, stated: Collection[str] = ()) -> Recording:
    """Return the recording with units corrected and told; channels in `stated` keep theirs and are told.

    `stated` names keys of `COLUMNS`. Headings in degrees are judged by their own size.
    """
    recording = _centimetres(_degrees_of_heading(recording, stated), stated)
    recording = _millimetres_by_speed(recording, stated)
    pose = recording.pose
    if pose is None or not np.isfinite(pose.x).any():
        return recording
    for name in FACTORS:
        way = _said(recording, name)
        if way is None:
            continue
        recording = _corrected(recording, name, *way, stated)
    return recording


def _corrected(
    recording: Recording, name: str, time: FloatArray, told: FloatArray, stated: Collection[str]
) -> Recording:
    """Return the recording with one channel's unit corrected where poses say so."""
    pose = recording.pose
    if pose is None:
        return recording
    kind = FACTORS[name][0][2]
    ratio = _ratio(pose, time, told, kind)
    if ratio is None:
        return recording
    for factor, unit, _ in FACTORS[name]:
        if _near(ratio, factor):
            return _scaled(recording, name, factor, unit, stated)
    if kind == WAY and _near(ratio, 1e3):
        return _scaled(recording, "pose.length", 1e-3, "mm", stated)
    for factor, why in ((2.0, "a radius in place of a diameter"), (0.5, "a diameter in place of a radius")):
        if abs(ratio / factor - 1.0) < 0.05 and name.startswith("wheel"):
            said = f"the poses tell {ratio:.2f} times the way that the wheels tell: {why}?"
            recording = _with(recording, Finding(name.split(".")[0], "unit_slip", said))
    return recording


def _near(ratio: float, factor: float) -> bool:
    return abs(math.log(ratio / factor)) < math.log(1.0 + TOLERANCE)


def _scaled(recording: Recording, name: str, factor: float, unit: str, stated: Collection[str]) -> Recording:
    slot = name.split(".")[0]
    if name in stated:
        said = f"the numbers look like {unit}, which the manifest does not say; they are read as it says"
        return _with(recording, Finding(slot, "unit_slip", said))
    channel: Channel = getattr(recording, slot)
    changes: dict[str, Any] = {key: getattr(channel, key) * factor for key in COLUMNS[name]}
    said = f"read as {unit}: only so do the channels tell the same drive (factor {factor:.4g})"
    slots: dict[str, Any] = {slot: dataclasses.replace(channel, **changes)}
    return _with(dataclasses.replace(recording, **slots), Finding(slot, "unit_guess", said))


def _with(recording: Recording, finding: Finding) -> Recording:
    return dataclasses.replace(recording, checks=(*recording.checks, finding))


def _said(recording: Recording, name: str) -> tuple[FloatArray, FloatArray] | None:
    """Return times (n,) and the cumulative way [m, if the unit is right] or turn [rad] that a channel tells."""
    channel: Any = getattr(recording, name.split(".")[0])
    if channel is None or len(channel) < 2 or getattr(channel, "duration", None) is not None:
        return None
    radius = recording.robot.wheel_radius
    if name == "wheel_angle":
        if channel.unit != "rad" or channel.resolution or radius is None:
            return None
        return channel.time, 0.5 * radius * (channel.left + channel.right)
    if name == "wheel_rate" and radius is None:
        return None
    columns = [getattr(channel, key) for key in COLUMNS[name]]
    speed = np.mean(columns, axis=0) * (radius if name == "wheel_rate" and radius else 1.0)
    return channel.time, np.concatenate([[0.0], np.cumsum(speed[:-1] * np.diff(channel.time))])


def _ratio(pose: PoseTrack, time: FloatArray, told: FloatArray, kind: str) -> float | None:
    """Return how many times the way or turn of the poses is what a channel told, by the middle over spans of motion."""
    known = np.isfinite(pose.x) & np.isfinite(pose.y) & (np.isfinite(pose.theta) | (kind == WAY))
    if known.sum() < FEWEST:
        return None
    first, last = max(pose.time[known][0], time[0]), min(pose.time[known][-1], time[-1])
    grid = np.arange(first, last, SPAN)
    if len(grid) <= FEWEST:
        return None
    by_channel = np.abs(np.diff(np.interp(grid, time, told)))
    if kind == TURN:
        by_pose = np.abs(np.diff(np.interp(grid, pose.time[known], np.unwrap(pose.theta[known]))))
    else:
        x, y = (np.interp(grid, pose.time[known], part[known]) for part in (pose.x, pose.y))
        by_pose = np.hypot(np.diff(x), np.diff(y))
    moving = (by_channel > 0.3 * np.max(by_channel, initial=0.0)) & (by_channel > 0.0)
    if moving.sum() < FEWEST:
        return None
    ratio = float(np.median(by_pose[moving] / by_channel[moving]))
    return ratio if math.isfinite(ratio) and ratio > 0.0 else None


def _degrees_of_heading(recording: Recording, stated: Collection[str]) -> Recording:
    """Read headings as degrees where their size and their wraps show it."""
    pose = recording.pose
    if pose is None or "pose.theta" in stated:
        return recording
    theta = pose.theta[np.isfinite(pose.theta)]
    if len(theta) < FEWEST or float(np.abs(theta).max()) < 2.0 * math.pi * 1.05:
        return recording
    turned = dataclasses.replace(pose, theta=pose.theta * DEGREE)
    moves = [clear_moves(track) for track in (pose, turned)]
    in_radians, in_degrees = (agreement(*m) if len(m[0]) >= FEWEST else 0.0 for m in moves)
    if in_degrees < 0.5 or in_degrees < 1.5 * in_radians:
        return recording
    said = f"headings up to {np.abs(theta).max():.0f} are read as degrees: only so does the robot drive where it looks"
    return _with(dataclasses.replace(recording, pose=turned), Finding("pose", "unit_guess", said))


def _centimetres(recording: Recording, stated: Collection[str]) -> Recording:
    """Read positions as centimetres where speeds say so; rates do not, as rpm beside millimetres look the same."""
    for name in ("twist.v", "wheel_speed"):
        way, pose = _said(recording, name), recording.pose
        if way is None or pose is None or "pose.length" in stated or not np.isfinite(pose.x).any():
            continue
        ratio = _ratio(pose, *way, WAY)
        if ratio is not None and _near(ratio, 100.0):
            return _scaled(recording, "pose.length", 0.01, "cm", stated)
    return recording


def _millimetres_by_speed(recording: Recording, stated: Collection[str]) -> Recording:
    """Read positions as millimetres where no robot of this house is so fast, but drives where it looks."""
    pose = recording.pose
    if pose is None or "pose.length" in stated or len(pose) < FEWEST or not np.isfinite(pose.theta).all():
        return recording
    step = np.diff(pose.time)
    speed = np.hypot(np.diff(pose.x), np.diff(pose.y)) / np.maximum(step, 1e-9)
    direction, headings = clear_moves(pose)
    if not FASTEST < float(np.quantile(speed, 0.8)) < 1e3 * FASTEST or len(headings) < FEWEST:
        return recording
    if float(np.median(step)) < QUICKEST or float(np.ptp(headings)) < TURNED:
        return (
            recording  # a straight line of many poses a second is as likely a position in place of the time
        )
    if agreement(direction, headings) < 0.8:
        return recording
    return _scaled(recording, "pose.length", 1e-3, "mm", stated)
