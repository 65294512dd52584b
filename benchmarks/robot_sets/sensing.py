"""From the truth of a drive to what is reported and recorded."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.displacements import floor_of
from benchmarks.robot_sets.driving import EVERY, Array, Drive, Poses, Robot, Sensing, Setup
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts

Rng = np.random.Generator
ENCODER_HZ = 50.0
TAIL = 5.0  # how much larger the noise of an outlier is


def report(setup: Setup, drive: Drive, stamps: Array, run: int) -> tuple[Poses, Array]:
    """Return the tag's poses as reported at stamps [s] but for noise, and where local effects touch."""
    time = stamps.astype(float)
    for clock in setup.clocks:
        time = clock(run)(time)
    time = np.clip(time, 0.0, drive.time[-1])
    poses: Poses = (drive.x, drive.y, drive.yaw)
    for smooth in setup.filters:
        poses = smooth(run)(drive.time, poses)
    x, y, yaw = (np.interp(time, drive.time, p) for p in poses)
    touched = np.interp(time, drive.time, drive.touched.astype(float)) > 0.0
    dx, dy = np.full_like(time, setup.sensing.tag[0]), np.full_like(time, setup.sensing.tag[1])
    turn = np.full_like(time, setup.sensing.tag_yaw)
    for tag in setup.tags:
        more = tag(run)(time)
        dx, dy, turn = dx + more[0], dy + more[1], turn + more[2]
    c, s = np.cos(yaw), np.sin(yaw)
    poses = (x + c * dx - s * dy, y + s * dx + c * dy, yaw + turn)
    for marker in setup.markers:
        poses, near = marker(run)(poses)
        touched = touched | near
    return poses, touched


def pose_stamps(rng: Rng, sensing: Sensing, seconds: float) -> Array:
    """Return when poses were taken [s]: with a little jitter, some missing, a gap or two."""
    time = np.arange(0.0, seconds - 0.03, 1.0 / sensing.rate)
    time = time + rng.uniform(0.0, 0.1 / sensing.rate, len(time))
    keep = rng.random(len(time)) >= sensing.missing
    for _ in range(sensing.gaps):
        start = rng.uniform(4.0, seconds - 4.0)
        keep &= (time < start) | (time > start + rng.uniform(0.3, 0.8))
    keep[:2] = True
    return np.asarray(time[keep])


def noisy(rng: Rng, sensing: Sensing, poses: Poses) -> Poses:
    """Return poses with noise; some robots have a few outliers."""
    n = len(poses[0])
    large = np.where(rng.random(n) < sensing.tail, TAIL, 1.0)
    x = poses[0] + rng.normal(0.0, sensing.noise_xy, n) * large
    y = poses[1] + rng.normal(0.0, sensing.noise_xy, n) * large
    yaw = poses[2] + rng.normal(0.0, sensing.noise_theta, n) * large
    return x, y, np.remainder(yaw + math.pi, 2.0 * math.pi) - math.pi


def _encoders(robot: Robot, drive: Drive) -> WheelPair | None:
    ticks = robot.sensing.encoder_ticks
    if not ticks:
        return None
    every = round(1.0 / ENCODER_HZ / EVERY)
    unit = 2.0 * math.pi / ticks
    left, right = (np.floor(a[::every] / unit) * unit for a in (drive.left, drive.right))
    return WheelPair(drive.time[::every], left, right, unit="rad", resolution=unit)


def recorded(rng: Rng, name: str, setup: Setup, drive: Drive, run: int) -> tuple[Recording, dict[str, float]]:
    """Return the recording of a drive, and the floor of its poses."""
    robot, sensing = setup.robot, setup.sensing
    stamps = pose_stamps(rng, sensing, drive.seconds)
    exact, _ = report(setup, drive, stamps, run)
    seen = noisy(rng, sensing, exact)
    times = np.arange(len(drive.commands), dtype=np.float64) * drive.tick
    command = CommandTrack(times, drive.commands[:, 0].copy(), drive.commands[:, 1].copy())
    facts = RobotFacts(name=name, **robot.sheet)
    pose = PoseTrack(stamps, *seen)
    found = Recording(robot=facts, command=command, pose=pose, wheel_angle=_encoders(robot, drive))
    return found, floor_of(stamps, exact, seen)
