"""A recording made ready for the likelihood: one time line of events, the reference path, what was seen when."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.replay.heading_reckoned import headed_by_wheels
from fsm_calib.diagnosis.replay.heading_unwrap import unwound
from fsm_calib.diagnosis.replay.kinematics import dead_reckon
from fsm_calib.diagnosis.replay.lateness import heard_anew, speed_changes
from fsm_calib.diagnosis.replay.settings import DEFAULT_SETTINGS, Settings
from fsm_calib.diagnosis.replay.smoothing import SmoothTrack, lone_spikes, smooth_track
from fsm_calib.diagnosis.replay.wheels import wheels_of
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.chord_noise import chord_noise
from fsm_calib.recording.leaps import FEW_JUMPS, fastest_of, leaps
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.unknown_commands import unknown_spans
from fsm_calib.types import FloatArray

FEWEST_FRAMES = 20  # poses: below it not even the base robot can be fitted
NOMINAL_AXLE = 0.100  # m, Duckiebot DB18 (Duckietown kinematic calibration, default file)
NOMINAL_RADIUS = 0.0318  # m, the same file
SURELY_GONE = 6.0  # standard deviations of the poses' noise: no robot at rest seems to go so far
REST_TIME = 0.6  # s in which disturbances fade after a stop: their memory, and three drive time constants


@dataclass(frozen=True, eq=False)
class Poses:
    """The measured poses that are used: time [s], x, y [m], theta [rad, unwrapped], shape (n,); dropped rows.

    placed : whether x, y were measured; if not they are where the wheels would have brought the robot. headed :
    whether theta was measured; if not it is where the robot looked by its path and its wheels.
    """

    time: FloatArray
    x: FloatArray
    y: FloatArray
    theta: FloatArray
    dropped: int = 0
    placed: bool = True
    headed: bool = True


@dataclass(frozen=True, eq=False)
class Prepared:
    """One recording on a time line of n events (pose frames and encoder samples).

    time : (n,) [s]; dt : (n,) [s] since the event before. reference : (n, 3) smoothed x, y [m], theta [rad].
    wheels : (n, 2) reference wheel angles [rad]. rotation : (n, 2) cos, sin of the reference's turn since the
    event before; step : (n, 5) reference increments (forward, left [m], turn, wheels [rad]). seen : (n, 5) bool;
    y : (n, 5) measured - reference in the body frame; restart : (n,) bool; moving : (n,) in [0, 1].
    surge : (n, 2) `speed_changes`; anew : (n,) `heard_anew`.
    track : the smoothed path at a fine grid, exogenous to every fit. geometry : half axle length, wheel radius [m],
    frame interval [s].
    """

    name: str
    recording: Recording
    poses: Poses
    track: SmoothTrack
    time: FloatArray
    dt: FloatArray
    reference: FloatArray
    rotation: FloatArray
    step: FloatArray
    seen: np.ndarray
    y: FloatArray
    restart: np.ndarray
    moving: FloatArray
    surge: FloatArray
    anew: np.ndarray
    geometry: FloatArray
    settings: Settings = field(default=DEFAULT_SETTINGS)

    @property
    def has_encoders(self) -> bool:
        """Whether wheel angles were recorded."""
        return bool(self.seen[:, 3].any())

    @cached_property
    def scored(self) -> np.ndarray:
        """Mask (n, 5) of the innovations that enter the likelihood."""
        return np.asarray(self.seen & ~self.restart[:, None])

    @cached_property
    def innovations(self) -> int:
        """The number N of innovations that enter the likelihood."""
        return int(self.scored.sum())


def clean_poses(recording: Recording) -> Poses:
    """Return the finite poses without lone spikes.

    Raises
    ------
    DataError
        The recording has no poses, no headings and nothing to reckon them from, or fewer than 20 poses.
    """
    track = recording.pose
    if track is None:
        raise DataError(
            f"{recording.source or recording.robot.name}: no pose channel", cure="Record x, y and theta."
        )
    headed = track.has_heading
    track = track if headed else headed_by_wheels(recording, track)
    placed = bool(np.isfinite(track.x).any())
    track = track if placed else placed_by_wheels(recording, track)
    good = np.isfinite(track.x) & np.isfinite(track.y) & np.isfinite(track.theta)
    time, x, y = track.time[good], track.x[good], track.y[good]
    theta = unwound(recording, time, track.theta[good])
    dropped = int((~good).sum())
    for _ in range(2):  # the second look sees spikes that stood beside another
        spikes = lone_spikes(time, x) | lone_spikes(time, y) | lone_spikes(time, theta, turning=True)
        time, x, y, theta = time[~spikes], x[~spikes], y[~spikes], theta[~spikes]
        theta = unwound(recording, time, theta)
        dropped += int(spikes.sum())
    if len(time) < FEWEST_FRAMES:
        raise DataError(
            f"{recording.source or recording.robot.name}: {len(time)} usable poses, {FEWEST_FRAMES} are needed",
            cure="Record a longer drive.",
        )
    return Poses(time, x, y, theta, dropped, placed, headed)


def is_usable(recording: Recording) -> bool:
    """Return whether a recording has poses enough to be diagnosed."""
    try:
        clean_poses(recording)
    except DataError:
        return False
    return True


def placed_by_wheels(recording: Recording, track: PoseTrack) -> PoseTrack:
    """Return the headings with positions reckoned from the wheels: they tell where, but are no measurement."""
    known = np.isfinite(track.theta)
    time, theta = track.time[known], unwound(recording, track.time[known], track.theta[known])
    wheels = wheels_of(recording)
    left, right = wheels.between(time)
    scale = wheels.nominal or wheels.size
    x, y, _ = dead_reckon(0.5 * scale * (left + right), np.diff(theta), (0.0, 0.0, float(theta[0])))
    return PoseTrack(time, x, y, theta)


def prepare(recording: Recording, settings: Settings = DEFAULT_SETTINGS) -> Prepared:
    """Lay a recording on its time line.

    Raises
    ------
    DataError
        Poses with headings are missing or too few.
    """
    poses = clean_poses(recording)
    axle = recording.robot.axle_length or NOMINAL_AXLE
    encoder_time, angles = _encoders(recording, poses, settings)
    time, where = np.unique(np.concatenate([poses.time, encoder_time]), return_inverse=True)
    at_pose, at_encoder = where[: len(poses.time)], where[len(poses.time) :]
    grid = np.unique(np.concatenate([time, np.arange(time[0], time[-1], 0.02)]))
    leap = _leaps(recording, poses)
    track = smooth_track(poses.time, poses.x, poses.y, poses.theta, grid, leap)
    picked = np.searchsorted(grid, time)
    reference = np.column_stack([track.x, track.y, track.theta])[picked]
    wheels = np.zeros((len(time), 2))
    if len(encoder_time):
        wheels = np.column_stack([np.interp(time, encoder_time, angles[:, i]) for i in range(2)])
    seen = np.zeros((len(time), 5), dtype=bool)
    seen[at_pose, :2] = poses.placed
    seen[at_pose, 2] = poses.headed
    moving = _moving(track, picked, axle, settings)
    seen[at_encoder, 3:] = _fresh(wheels[at_encoder], moving[at_encoder])[:, None]
    in_motion = _begins_in_motion(poses, track, float(moving[0]), recording, settings)
    moving = _coming_to_rest(time, moving)
    y = np.zeros((len(time), 5))
    y[at_pose, :3] = _in_frame(reference[at_pose], np.column_stack([poses.x, poses.y, poses.theta]))
    dt = np.diff(time, prepend=time[0])
    radius, frame = recording.robot.wheel_radius or NOMINAL_RADIUS, float(np.median(np.diff(poses.time)))
    return Prepared(
        name=recording.source or recording.robot.name,
        recording=recording,
        poses=poses,
        track=track,
        time=time,
        dt=dt,
        reference=reference,
        rotation=_turn(reference[:, 2]),
        step=_steps(reference, wheels),
        seen=seen,
        y=y,
        restart=_restarts(time, poses.time, leap, recording, settings, in_motion),
        moving=moving,
        surge=speed_changes(track, picked),
        anew=heard_anew(recording, time, frame),
        geometry=np.array([axle / 2.0, radius, frame]),
        settings=settings,
    )


def _leaps(recording: Recording, poses: Poses) -> np.ndarray:
    """Return a mask (n,) of poses that no robot reached from the one before: few, or they are something else."""
    found = leaps(poses.time, poses.x, poses.y, poses.theta, fastest_of(recording))
    return found if found.sum() <= FEW_JUMPS * len(found) else np.zeros_like(found)


def _in_frame(frame: FloatArray, pose: FloatArray) -> FloatArray:
    """Return `pose` (n, 3) in the moving frames `frame` (n, 3)."""
    c, s = np.cos(frame[:, 2]), np.sin(frame[:, 2])
    dx, dy = pose[:, 0] - frame[:, 0], pose[:, 1] - frame[:, 1]
    return np.column_stack([c * dx + s * dy, c * dy - s * dx, pose[:, 2] - frame[:, 2]])


def _turn(theta: FloatArray) -> FloatArray:
    turn = np.diff(theta, prepend=theta[0])
    return np.column_stack([np.cos(turn), np.sin(turn)])


def _steps(reference: FloatArray, wheels: FloatArray) -> FloatArray:
    before = np.vstack([reference[:1], reference[:-1]])
    return np.column_stack([_in_frame(before, reference), np.diff(wheels, axis=0, prepend=wheels[:1])])


def _moving(track: SmoothTrack, picked: np.ndarray, axle: float, settings: Settings) -> FloatArray:
    """Return the share in [0, 1] that the robot moves at each event, from the rim speed of its faster wheel."""
    rim = np.hypot(track.vx, track.vy)[picked] + 0.5 * axle * np.abs(track.omega[picked])
    ramp = np.clip((rim - settings.still_speed) / (settings.moving_speed - settings.still_speed), 0.0, 1.0)
    return np.asarray(ramp * ramp * (3.0 - 2.0 * ramp))


def _coming_to_rest(time: FloatArray, moving: FloatArray) -> FloatArray:
    """Return `moving` (n,) as it fades after a stop: what disturbs a robot does so until it has come to rest.

    A robot that coasts its last millimetres is slower than a tracker can tell from standing; without the delay its
    turning then looks like a push.
    """
    out, fading = np.empty_like(moving), 0.0
    for k, (dt, share) in enumerate(zip(np.diff(time, prepend=time[:1]), moving, strict=True)):
        fading = max(float(share), fading - float(dt) / REST_TIME)
        out[k] = fading
    return out


def _encoders(recording: Recording, poses: Poses, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Return times and angles [rad] of the encoders, thinned, inside the span of the poses."""
    pair = recording.wheel_angle
    if pair is None or pair.unit != "rad" or len(pair) < 2:
        return np.empty(0), np.empty((0, 2))
    every = max(1, int(np.floor(1.0 / (settings.encoder_rate * float(np.median(np.diff(pair.time)))) + 0.5)))
    rows = np.arange(0, len(pair), every)
    inside = rows[(pair.time[rows] >= poses.time[0]) & (pair.time[rows] <= poses.time[-1])]
    return pair.time[inside], np.column_stack([pair.left[inside], pair.right[inside]])


def _fresh(angles: FloatArray, moving: FloatArray) -> np.ndarray:
    """Mark the encoder samples that tell something: a count repeated at rest is no second measurement."""
    changed = np.abs(np.diff(angles, axis=0, prepend=angles[:1])).max(axis=1, initial=0.0) > 0.0
    fresh = changed | (moving > 0.5)
    fresh[:1] = True
    return np.asarray(fresh)


def _restarts(
    time: FloatArray,
    pose_time: FloatArray,
    leap: np.ndarray,
    recording: Recording,
    settings: Settings,
    in_motion: bool,
) -> np.ndarray:
    """Mark the events at which the chain of increments is broken.

    That is after gaps and leaps of the poses, and while nobody knows the commands.
    """
    restart = np.zeros(len(time), dtype=bool)
    restart[0] = True
    broken = leap | (np.diff(pose_time, prepend=pose_time[0]) > settings.longest_gap)
    restart[np.searchsorted(time, pose_time[broken])] = True
    commands = recording.commands
    if commands is None or not len(commands):
        return restart
    for start, end in unknown_spans(commands):
        restart |= (time > start) & (time <= end + settings.settle_time)
    if commands.stale_after is not None or in_motion:
        restart |= time <= commands.time[0] + settings.settle_time
    return restart


def _begins_in_motion(
    poses: Poses, track: SmoothTrack, moving: float, recording: Recording, settings: Settings
) -> bool:
    """Return whether the robot had commands before the first one that was logged.

    It has gone further by then than its poses' noise tells; where the log begins with a command it is `moving` there,
    a share in [0, 1].
    """
    commands = recording.commands
    if commands is None or not len(commands):
        return False
    before = track.time <= commands.time[0]
    if not np.any(track.time <= commands.time[0] - settings.settle_time):
        return moving > 0.5
    half = 0.5 * (recording.robot.axle_length or NOMINAL_AXLE)
    x, y, theta = (series[before] - series[0] for series in (track.x, track.y, track.theta))
    noise = np.hypot(chord_noise(poses.x), chord_noise(poses.y))
    noise += half * chord_noise(poses.theta)
    least = max(SURELY_GONE * noise, settings.moving_speed * settings.settle_time)
    return bool(np.max(np.hypot(x, y) + half * np.abs(theta)) > least)


def expected(recording: Recording, rates: FloatArray, settings: Settings = DEFAULT_SETTINGS) -> Prepared:
    """Lay a drive that has not been driven on its time line: its poses are those that are expected, without noise.

    rates : (n, 3) expected vx, vy [m/s] in the world and omega [rad/s] at each pose.
    """
    track = recording.pose
    if track is None:
        raise DataError("an expected drive has no poses")
    smooth = SmoothTrack(track.time, track.x, track.y, track.theta, *rates.T)
    axle, picked = recording.robot.axle_length or NOMINAL_AXLE, np.arange(len(track))
    reference = np.column_stack([track.x, track.y, track.theta])
    moving = _coming_to_rest(track.time, _moving(smooth, picked, axle, settings))
    dt = np.diff(track.time, prepend=track.time[0])
    frame = float(np.median(dt[1:]))
    seen = np.zeros((len(track), 5), dtype=bool)
    seen[:, :3] = True
    return Prepared(
        name=recording.source,
        recording=recording,
        poses=Poses(track.time, track.x, track.y, track.theta),
        track=smooth,
        time=track.time,
        dt=dt,
        reference=reference,
        rotation=_turn(reference[:, 2]),
        step=_steps(reference, np.zeros((len(track), 2))),
        seen=seen,
        y=np.zeros((len(track), 5)),
        restart=np.arange(len(track)) == 0,
        moving=moving,
        surge=speed_changes(smooth, picked),
        anew=heard_anew(recording, track.time, frame),
        geometry=np.array([axle / 2.0, recording.robot.wheel_radius or NOMINAL_RADIUS, frame]),
        settings=settings,
    )
