"""The run's own drive as a recording, so that `identify` and `diagnose` can look at it.

Commands and states come from the journal. Poses are those that a camera over the area would have measured:
the true path of the base with white noise (`output.pose_noise`, `output.heading_noise`); the robot itself
never sees them. Nobody measured the poses of a real robot: its recording has none.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.recording.channels import CommandTrack, PoseTrack, StateTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.runner.session import Session
from fsm_calib.scenario.models import OutputSection
from fsm_calib.types import FloatArray, WheelCalibration

FOLDER = "recording"
POSE_EVERY = 2
"""Every second pose of the true path (0.02 s apart) is measured: 25 Hz, a camera's rate."""
NOISE_STREAM = 7
"""Which random stream of the seed the measurement noise is drawn from."""


def write_drive(directory: Path, session: Session) -> Path:
    """Write the drive below ``recording/`` as a manifest with CSV files, and as a bag unless that is not wanted.

    Returns the manifest's path.
    """
    from fsm_calib.recording.writers import write_bag, write_recording

    recording = recording_of(session, list(read_journal(directory / JOURNAL_NAME)))
    path = write_recording(recording, directory / FOLDER)
    kind = session.scenario.output.bag
    if kind != "none":
        bag = directory / FOLDER / ("drive.bag" if kind == "ros1" else "drive_ros2")
        if bag.is_dir():
            shutil.rmtree(bag)  # what an earlier end of the same run left
        bag.unlink(missing_ok=True)
        write_bag(recording, bag, f"/{session.scenario.robot.name}")
    return path


def recording_of(session: Session, events: Sequence[Mapping[str, Any]]) -> Recording:
    """Return the drive of a finished session."""
    nominal = WheelCalibration()
    facts = RobotFacts(
        name=session.scenario.robot.name,
        wheel_radius=nominal.wheel_radius,
        axle_length=nominal.axle_length,
        max_wheel_rate=nominal.motor_constant,
    )
    poses = None
    if session.world is not None:
        rng = np.random.default_rng([session.scenario.seed, NOISE_STREAM])
        poses = poses_of(session.connection.track(), session.scenario.output, rng)
    return Recording(
        robot=facts,
        command=commands_of(events),
        pose=poses,
        state=states_of(events),
    )


def commands_of(events: Sequence[Mapping[str, Any]]) -> CommandTrack:
    """Return the commands of a journal; of several at one time the last one acted."""
    held = {time: (left, right) for event in events for time, left, right in event["commands"]}
    times = np.array(list(held), dtype=float)
    values = np.array(list(held.values()), dtype=float).reshape(-1, 2)
    return CommandTrack(times, values[:, 0], values[:, 1])


def states_of(events: Sequence[Mapping[str, Any]]) -> StateTrack:
    """Return which state was active from when on; a state left at the time it was entered is not kept."""
    begun: dict[float, str] = {}
    begin = 0.0
    for event in events:
        begun[begin] = event["path"]
        begin = float(event["time"])
    if events:
        begun[begin] = events[-1]["dest"]
    return StateTrack(np.array(list(begun), dtype=float), tuple(begun.values()))


def poses_of(trace: FloatArray, output: OutputSection, rng: np.random.Generator) -> PoseTrack:
    """Return measured poses of a true path, shape (n, 4): time [s], x, y [m], theta [rad]."""
    seen = trace[::POSE_EVERY]
    noise = rng.standard_normal((len(seen), 3)) * (output.pose_noise, output.pose_noise, output.heading_noise)
    x, y, theta = (seen[:, 1:] + noise).T
    return PoseTrack(seen[:, 0], x, y, theta)
