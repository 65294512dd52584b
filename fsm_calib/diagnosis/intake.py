"""What a diagnosis takes in: recordings of any form become short drives with poses.

- Displacements (scan matching, visual odometry) are chained to poses of the base, once the robot's wheels and the
  sensor's place on it are identified; outliers among them are bridged by the wheels' own motion.
- A yaw rate alone is integrated to headings; positions stay unmeasured.
- Long recordings are cut to stretches, evenly spread, so that a quarter of an hour costs no more than some minutes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.between_samples import with_bends
from fsm_calib.diagnosis.fine_clocks import with_fine_clocks
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.diagnosis.identify.result import Identification
from fsm_calib.diagnosis.inputs import with_input
from fsm_calib.diagnosis.rate_stamps import with_stamps
from fsm_calib.diagnosis.replay.kinematics import body_motion, sensor_motion
from fsm_calib.diagnosis.replay.prepared import NOMINAL_AXLE
from fsm_calib.diagnosis.replay.wheels import wheels_of
from fsm_calib.diagnosis.sampled_commands import with_changes_placed
from fsm_calib.diagnosis.sized import identified_facts, sized
from fsm_calib.diagnosis.wandering_clocks import with_steady_clocks
from fsm_calib.diagnosis.wiring import as_wired
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

LONGEST_IN_ALL = 240.0  # s of driving that are fitted whole: the time bar is set for two minutes
STRETCHES_IN_ALL = 160.0  # s that are fitted of longer recordings
SHORTEST_STRETCH = 40.0  # s: slow effects need tens of seconds
POSE_RATE = 31.0  # Hz: faster trackers repeat themselves (their errors are correlated)
OUTLIER_DEVIATIONS = 5.0  # robust standard deviations from the wheels' motion


@dataclass(frozen=True)
class Intake:
    """Recordings ready to be prepared: those to fit, those to judge on, and sentences on what was done to them."""

    train: tuple[Recording, ...]
    holdout: tuple[Recording, ...]
    notes: tuple[str, ...] = ()


def take_in(
    recordings: Sequence[Recording], holdouts: Sequence[Recording] = (), processes: int = 1
) -> Intake:
    """Return the recordings as drives with poses; the robot is identified from `recordings` alone.

    processes : so many recordings are worked on side by side.

    Raises
    ------
    DataError
        None was given, or one has no poses and nothing to make them from.
    """
    if not recordings:
        raise DataError("no recording was given")
    recordings, holdouts, notes = as_wired(recordings, holdouts)
    robot: Identification | None = None
    if any(r.pose is None and r.displacement is not None for r in recordings):
        robot = identify(recordings)
        notes.append("the wheels and the sensor's place on the robot were identified first")
    size, sentence = identified_facts(recordings)
    notes += [sentence] if sentence else []
    train = [with_input(with_poses(sized(r, size), robot)) for r in recordings]
    new = [with_input(with_poses(sized(r, size), robot)) for r in holdouts]
    for mended in (with_steady_clocks, with_fine_clocks):
        laid, told = mended([*train, *new], processes)
        train, new = laid[: len(train)], laid[len(train) :]
        notes += told
    train, new, told = with_changes_placed(train, new, processes)
    notes += told
    train, new, sentence = with_stamps(train, new)
    notes += [sentence] if sentence else []
    if any(r.pose is not None and not r.pose.has_heading for r in train):
        notes.append("no heading was measured: it is reckoned from the path and the wheels, and not scored")
    total = sum(duration(r) for r in train)
    if total > LONGEST_IN_ALL:
        train = [piece for r in train for piece in stretches(r, STRETCHES_IN_ALL * duration(r) / total)]
        kept = sum(duration(r) for r in train)
        notes.append(
            f"{kept:.0f} of {total:.0f} s are fitted, in {len(train)} stretches; predictions are judged on all"
        )
    train, new, sentence = with_bends(list(map(thinned, train)), list(map(thinned, new)))
    notes += [sentence] if sentence else []
    return Intake(tuple(train), tuple(new), tuple(notes))


def duration(recording: Recording) -> float:
    """Return the time [s] from the first pose to the last."""
    time = recording.pose.time if recording.pose is not None else np.zeros(0)
    return float(time[-1] - time[0]) if len(time) else 0.0


def stretches(recording: Recording, seconds: float) -> list[Recording]:
    """Cut evenly spread stretches that last `seconds` [s] in all; the recording itself when it is no longer."""
    whole = duration(recording)
    count = max(1, int(seconds / SHORTEST_STRETCH))
    length = max(seconds / count, SHORTEST_STRETCH)
    if whole <= count * length or recording.pose is None:
        return [recording]
    begin = float(recording.pose.time[0])
    starts = begin + (np.arange(count) + 0.5) * whole / count - 0.5 * length
    return [_stretch(recording, t, t + length) for t in map(float, starts)]


def _stretch(recording: Recording, start: float, end: float) -> Recording:
    """Return the part from start to end [s], its clock set to zero at the start."""
    part = recording.window(start, end)
    moved = {name: replace(channel, time=channel.time - start) for name, channel in part.channels.items()}
    return replace(part, source=f"{recording.source} ({start:.0f} to {end:.0f} s)", **moved)  # type: ignore[arg-type]


def thinned(recording: Recording) -> Recording:
    """Leave out poses so that at most `POSE_RATE` remain a second."""
    pose = recording.pose
    if pose is None or len(pose) < 2:
        return recording
    every = int(np.floor(1.0 / (POSE_RATE * float(np.median(np.diff(pose.time)))) + 0.5))
    return replace(recording, pose=pose.rows(slice(None, None, every))) if every > 1 else recording


def with_poses(recording: Recording, robot: Identification | None) -> Recording:
    """Return the recording with a pose channel, from whatever tells how the robot moved."""
    if recording.pose is not None:
        return recording
    if recording.displacement is not None and robot is not None:
        return chained(recording, robot)
    if recording.yaw_rate is not None and _has_wheels(recording):
        return replace(recording, pose=headings(recording))
    raise DataError(
        f"{recording.source or recording.robot.name}: no poses, and no displacements or yaw rate beside wheel speeds",
        cure="Record x, y and theta of the robot, or displacements or a yaw rate with the wheels.",
    )


def _has_wheels(recording: Recording) -> bool:
    return any(t is not None for t in (recording.wheel_rate, recording.wheel_speed, recording.wheel_angle))


def chained(recording: Recording, robot: Identification) -> Recording:
    """Chain displacements to poses of the base, and state the identified wheels and axle as the robot's own."""
    track = recording.displacement
    if track is None:
        raise DataError("no displacement was recorded")
    facts = recording.robot
    radius, axle = facts.wheel_radius or 1.0, facts.axle_length or NOMINAL_AXLE
    left_radius = _known(robot, "wheel_radius_left", radius)
    right_radius = _known(robot, "wheel_radius_right", radius)
    axle = _known(robot, "axle_length", axle)
    sensor = np.zeros(3)
    if track.of == "sensor":
        sensor = np.array([_known(robot, f"sensor.{key}", 0.0) for key in ("x", "y", "theta")])
    wheels = wheels_of(recording)
    ends = np.append(track.time, track.time[-1] + track.duration[-1])
    left, right = wheels.between(ends)
    d, dtheta = body_motion(left, right, left_radius, right_radius, axle)
    predicted = sensor_motion(d, dtheta, sensor)
    measured = np.column_stack([track.dx, track.dy, track.dtheta])
    steps = np.where(outliers(measured - predicted)[:, None], predicted, measured)
    x, y, theta = chain(base_steps(steps, sensor))
    known = replace(facts, wheel_radius=0.5 * (left_radius + right_radius), axle_length=axle)
    return replace(recording, robot=known, pose=PoseTrack(ends, x, y, theta))


def _known(robot: Identification, name: str, fallback: float) -> float:
    estimate = robot.estimates.get(name)
    return fallback if estimate is None or estimate.value is None else float(estimate.value)


def outliers(residual: FloatArray) -> np.ndarray:
    """Return a mask (n,) of rows of `residual` (n, 3) that leave the middle by many robust deviations."""
    off = np.abs(residual - np.nanmedian(residual, axis=0))
    spread = 1.4826 * np.nanmedian(off, axis=0)
    return np.asarray(np.any(~(off <= OUTLIER_DEVIATIONS * np.maximum(spread, 1e-9)), axis=1))


def base_steps(steps: FloatArray, sensor: FloatArray) -> FloatArray:
    """Turn displacements of a sensor at `sensor` (x, y, theta) on the base into the base's, shape (n, 3)."""
    x, y, theta = sensor
    c, s = np.cos(theta), np.sin(theta)
    turn = steps[:, 2]
    ahead, left = c * steps[:, 0] - s * steps[:, 1] + x, s * steps[:, 0] + c * steps[:, 1] + y
    ct, st = np.cos(turn), np.sin(turn)
    return np.column_stack([ahead - ct * x + st * y, left - st * x - ct * y, turn])


def chain(steps: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Chain displacements (n, 3), each in the frame at its start; return x, y [m], theta [rad], shape (n + 1,)."""
    theta = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(theta[:-1]), np.sin(theta[:-1])
    x = np.concatenate([[0.0], np.cumsum(c * steps[:, 0] - s * steps[:, 1])])
    y = np.concatenate([[0.0], np.cumsum(s * steps[:, 0] + c * steps[:, 1])])
    return x, y, theta


def headings(recording: Recording) -> PoseTrack:
    """Integrate the yaw rate to headings (trapezoidal rule, or mean values); positions are not measured (NaN)."""
    track = recording.yaw_rate
    if track is None:
        raise DataError("no yaw rate was recorded")
    if track.duration is not None:
        time = np.append(track.time, track.time[-1] + track.duration[-1])
        turn = track.value * track.duration
    else:
        time = track.time
        turn = 0.5 * np.diff(time) * (track.value[1:] + track.value[:-1])
    unknown = np.full(len(time), np.nan)
    return PoseTrack(time, unknown, unknown, np.concatenate([[0.0], np.cumsum(turn)]))
