"""What is recorded of a drive: noisy poses at a camera's rate, encoder ticks, commands, the data sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.physx_robots.laws import Law, Reported
from benchmarks.physx_robots.robots import Rng, Robot
from benchmarks.physx_robots.simulate import Drive
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts

ENCODER_RATE = 50.0  # Hz
FLOOR_WINDOW = 2.0  # s


def reported(robot: Robot, laws: Sequence[Law], drive: Drive, seeds: Sequence[Rng]) -> Reported:
    """Return what the camera would report without noise, on the drive's grid; `robot` with its laws built in."""
    x, y = robot.sensing.tag
    cos, sin = np.cos(drive.yaw), np.sin(drive.yaw)
    poses: Reported = {
        "time": drive.time,
        "stamp": drive.time.copy(),
        "x": drive.x + cos * x - sin * y,
        "y": drive.y + sin * x + cos * y,
        "yaw": drive.yaw + robot.sensing.tag_yaw,
        "bx": drive.x,
        "by": drive.y,
        "byaw": drive.yaw,
    }
    for law, rng in zip(laws, seeds):
        poses = law.observe(poses, rng)
    return poses


@dataclass(frozen=True)
class Seen:
    """Poses as recorded, and the same without noise: stamp [s], columns x, y [m], yaw [rad]."""

    stamp: np.ndarray
    noisy: np.ndarray
    exact: np.ndarray


def look(rng: Rng, robot: Robot, poses: Reported) -> Seen:
    """Sample the reported poses with noise, tails and missing frames."""
    sensing = robot.sensing
    end = float(poses["time"][-1])
    frames = np.arange(float(rng.uniform(0, 1 / sensing.rate)), end, 1.0 / sensing.rate)
    keep = rng.random(len(frames)) >= sensing.missing
    if sensing.missing:
        for _ in range(int(rng.integers(0, 3))):
            gap = rng.uniform(2.0, end - 2.0)
            keep &= ~((frames > gap) & (frames < gap + rng.uniform(0.2, 0.6)))
    frames = frames[keep]
    stamp = np.interp(frames, poses["time"], poses["stamp"])
    exact = np.stack([np.interp(frames, poses["time"], poses[k]) for k in ("x", "y", "yaw")], axis=1)
    sd = np.array([sensing.position_sd, sensing.position_sd, sensing.heading_sd])
    wide = np.where(rng.random(len(frames)) < sensing.tails, rng.uniform(3.0, 6.0, len(frames)), 1.0)
    return Seen(stamp, exact + rng.normal(size=exact.shape) * sd * wide[:, None], exact)


def record(robot: Robot, drive: Drive, seen: Seen) -> Recording:
    """Return the recording; `robot` gives the data sheet."""
    facts, sensing = dict(robot.facts), robot.sensing
    wheels = None
    if sensing.ticks:
        tick = 2.0 * np.pi / sensing.ticks
        rows = slice(None, None, round(100 / ENCODER_RATE))
        counted = np.floor(drive.angle[rows] / tick) * tick
        wheels = WheelPair(drive.time[rows], counted[:, 0], counted[:, 1], unit="rad", resolution=tick)
        facts["metres_per_tick"] = facts["wheel_radius"] * tick
    wrapped = (seen.noisy[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return Recording(
        robot=RobotFacts(name="robot", **facts),
        command=CommandTrack(drive.command_time, drive.command[:, 0], drive.command[:, 1]),
        pose=PoseTrack(seen.stamp, seen.noisy[:, 0], seen.noisy[:, 1], wrapped),
        wheel_angle=wheels,
    )


def displacements(poses: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return (dx, dy [m], dyaw [rad]) from rows `start` to rows `end` of (x, y, yaw), in the frame at the start."""
    a, d = poses[start], poses[end] - poses[start]
    cos, sin = np.cos(a[:, 2]), np.sin(a[:, 2])
    return np.stack([cos * d[:, 0] + sin * d[:, 1], -sin * d[:, 0] + cos * d[:, 1], d[:, 2]], axis=1)


def floor_of(seen: Seen) -> dict[str, float]:
    """Return the error of a model that knows the exact displacements over 2 s: rms of the distance, and of the
    heading.
    """
    end = np.searchsorted(seen.stamp, seen.stamp + FLOOR_WINDOW - 1e-6)
    start = np.flatnonzero(end < len(seen.stamp))
    error = displacements(seen.noisy, start, end[start]) - displacements(seen.exact, start, end[start])
    return {
        "xy_m": float(np.sqrt(np.mean(error[:, 0] ** 2 + error[:, 1] ** 2))),
        "theta_rad": float(np.sqrt(np.mean(error[:, 2] ** 2))),
    }
