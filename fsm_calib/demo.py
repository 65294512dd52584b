"""A first look without data: a robot with a wheel off its centre is driven, and the diagnosis must find it.

The robot lives in the rigid-body world. What is recorded is what a camera above the floor would see: commands,
and poses with white noise. The diagnosis gets the recordings and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

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
SHORT = 20.0
"""Length of a drive that is only written as tables to try things on [s]: enough, and each try is quick."""
REST = 0.4
"""Pause after a manoeuvre [s]."""


@dataclass(frozen=True, eq=False)
class DemoDrives:
    """Two drives to learn from, one to be judged by, and what the robot hid (share of the wheel's radius)."""

    learned: tuple[Recording, Recording]
    judged: Recording
    eccentricity: float


def drive_demo(
    seed: int, names: Sequence[str] = ("drive-1", "drive-2", "drive-3"), seconds: float = DURATION
) -> DemoDrives:
    """Drive a robot three times; the seed draws the wheel, the motors, the manoeuvres and the noise.

    `names` are what the recordings call their source; `seconds` is how long each drive lasts at least.
    """
    rng = np.random.default_rng(seed)
    eccentricity, ratio = float(rng.uniform(*ECCENTRICITY)), float(rng.uniform(*WHEEL_RATIO))
    robot = replace(nominal_robot("demo"), wheel_ratio=ratio)
    drives = []
    for name in names:
        phase = float(rng.uniform(0.0, 2.0 * np.pi))
        hidden = {f"{HIDDEN}.left": eccentricity, f"{HIDDEN}.phase_left": phase}
        drives.append(drive(replace(robot, effects=hidden), manoeuvres(rng, seconds), rng, name))
    return DemoDrives((drives[0], drives[1]), drives[2], eccentricity)


def write_tables(recording: Recording, folder: Path, name: str) -> tuple[Path, Path]:
    """Write a drive as two plain tables of the kind that anybody's own script logs, and return their paths.

    ``NAME-commands.csv`` holds time [s] and the commands of both wheels from -1 to 1, each until the next row;
    ``NAME-poses.csv`` holds time [s], x and y [mm] and the heading [deg]. No manifest says so: that is left to
    `fsm-calib recording init`.
    """
    command, pose = recording.command, recording.pose
    if command is None or pose is None or pose.theta is None:
        raise ValueError("a drive of the demo has commands and poses")
    tables = (
        ("commands", "time_s,left,right", (command.time, command.left, command.right)),
        (
            "poses",
            "time_s,x_mm,y_mm,theta_deg",
            (pose.time, 1e3 * pose.x, 1e3 * pose.y, np.degrees(pose.theta)),
        ),
    )
    paths = []
    for kind, header, columns in tables:
        paths.append(folder / f"{name}-{kind}.csv")
        np.savetxt(paths[-1], np.column_stack(columns), "%.4f", ",", header=header, comments="")
    return paths[0], paths[1]


Manoeuvre = tuple[str, float, float, float]
"""State, left and right command [1], duration [s]."""


def manoeuvres(rng: np.random.Generator, seconds: float = DURATION) -> Iterator[Manoeuvre]:
    """Yield shuttles, turns on the spot and arcs of random speed, a rest after each, for about so many seconds."""
    total = 0.0
    while total < seconds:
        u = float(rng.uniform(0.2, 0.45))
        kinds: tuple[list[Manoeuvre], ...] = (
            [("shuttle/forward", u, u, 2.2), ("shuttle/rest", 0.0, 0.0, REST), ("shuttle/back", -u, -u, 2.2)],
            [("turn", u, -u, 1.0)],
            [("arc/right", u, 0.6 * u, 2.0), ("arc/left", 0.6 * u, u, 2.0)],
        )
        for part in [*kinds[int(rng.integers(len(kinds)))], ("rest", 0.0, 0.0, REST)]:
            total += part[3]
            yield part


def drive(
    robot: RobotSpec, parts: Iterable[Manoeuvre], rng: np.random.Generator, name: str = "drive"
) -> Recording:
    """Drive a robot over an empty floor and return what a camera above it would have recorded.

    Parameters
    ----------
    robot : RobotSpec
        With the effects that it hides.
    parts : iterable of Manoeuvre
        What it is told to do, one after the other.
    rng : Generator
        Of the world's seed and of the poses' noise.
    name : str
        What the recording calls its source.
    """
    spec = WorldSpec(robot=robot, scene=SceneSpec(), start=Pose2(), seed=int(rng.integers(2**31)))
    world = make_world(spec)
    begun: list[tuple[float, float, float]] = []
    states: list[str] = []
    for state, left, right, duration in parts:
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
