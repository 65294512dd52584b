"""A first look without data: a robot with a wheel off its centre is driven, and the diagnosis must find it.

The robot lives in the rigid-body world. What is recorded is what a camera above the floor would see: commands,
and poses with white noise. The diagnosis gets the recordings and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.recording.channels import CommandTrack, PoseTrack, StateTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.types import Pose2, WheelCalibration, WheelCommand
from fsm_calib.world2d.fleet import RobotSpec, nominal_robot
from fsm_calib.world2d.robot import WorldSpec, make_world
from fsm_calib.world2d.scene import SceneSpec

HIDDEN = "wheel_eccentricity"
"""The physics that the robot has and the diagnosis is not told."""
ECCENTRICITY = (0.04, 0.07)
"""How far the wheel may sit off its centre, as a share of its radius: well visible, still drives [1]."""
WHEEL_RATIO = (0.93, 1.07)
"""How unequal the motors may be [1]."""
POSITION_NOISE, HEADING_NOISE = 0.001, 0.005
"""Noise of the recorded poses [m, rad]: a good ceiling camera."""
POSE_EVERY = 2
"""Every second pose of the true path (0.02 s apart): 25 Hz."""
DURATION = 30.0
"""Length of one drive [s]."""
REST = 0.4
"""Pause after a manoeuvre [s]."""


@dataclass(frozen=True, eq=False)
class DemoDrives:
    """Two drives to learn from, one to be judged by, and what the robot hid (share of the wheel's radius)."""

    learned: tuple[Recording, Recording]
    judged: Recording
    eccentricity: float


def drive_demo(seed: int, names: Sequence[str] = ("drive-1", "drive-2", "drive-3")) -> DemoDrives:
    """Drive a robot three times; the seed draws the wheel, the motors, the manoeuvres and the noise.

    `names` are what the recordings call their source.
    """
    rng = np.random.default_rng(seed)
    eccentricity, ratio = float(rng.uniform(*ECCENTRICITY)), float(rng.uniform(*WHEEL_RATIO))
    robot = replace(nominal_robot("demo"), wheel_ratio=ratio)
    drives = []
    for name in names:
        phase = float(rng.uniform(0.0, 2.0 * np.pi))
        hidden = {f"{HIDDEN}.left": eccentricity, f"{HIDDEN}.phase_left": phase}
        drives.append(_drive(replace(robot, effects=hidden), rng, name))
    return DemoDrives((drives[0], drives[1]), drives[2], eccentricity)


Manoeuvre = tuple[str, float, float, float]
"""State, left and right command [1], duration [s]."""


def _manoeuvres(rng: np.random.Generator) -> Iterator[Manoeuvre]:
    """Yield shuttles, turns on the spot and arcs of random speed, a rest after each, for about `DURATION`."""
    total = 0.0
    while total < DURATION:
        u = float(rng.uniform(0.2, 0.45))
        kinds: tuple[list[Manoeuvre], ...] = (
            [("shuttle/forward", u, u, 2.2), ("shuttle/rest", 0.0, 0.0, REST), ("shuttle/back", -u, -u, 2.2)],
            [("turn", u, -u, 1.0)],
            [("arc/right", u, 0.6 * u, 2.0), ("arc/left", 0.6 * u, u, 2.0)],
        )
        for part in [*kinds[int(rng.integers(len(kinds)))], ("rest", 0.0, 0.0, REST)]:
            total += part[3]
            yield part


def _drive(robot: RobotSpec, rng: np.random.Generator, name: str) -> Recording:
    """Drive the robot over an empty floor and return what a camera above it would have recorded."""
    spec = WorldSpec(robot=robot, scene=SceneSpec(), start=Pose2(), seed=int(rng.integers(2**31)))
    world = make_world(spec)
    begun: list[tuple[float, float, float]] = []
    states: list[str] = []
    for state, left, right, duration in _manoeuvres(rng):
        begun.append((world.robot.now(), left, right))
        states.append(state)
        world.robot.command(WheelCommand(left, right))
        world.robot.wait(duration)
    path = world.truth.trace[::POSE_EVERY]
    noise = rng.standard_normal((len(path), 3)) * (POSITION_NOISE, POSITION_NOISE, HEADING_NOISE)
    nominal = WheelCalibration()
    time, left_level, right_level = np.array(begun).T
    return Recording(
        robot=RobotFacts("demo", nominal.wheel_radius, nominal.axle_length, nominal.motor_constant),
        command=CommandTrack(time, left_level, right_level),
        pose=PoseTrack(path[:, 0], *(path[:, 1:] + noise).T),
        state=StateTrack(time, tuple(states)),
        source=name,
    )
