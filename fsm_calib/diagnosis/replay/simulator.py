"""Replay: what the roll-out says a recording's sensors should have seen, as increments from event to event."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit

from fsm_calib.diagnosis.replay.prepared import NOMINAL_AXLE, NOMINAL_RADIUS, Prepared
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import held
from fsm_calib.types import FloatArray
from fsm_calib.world2d.dynamics import small_rotation
from fsm_calib.world2d.effects import per_catalogue, registry
from fsm_calib.world2d.effects.vocabulary import POSE_HOOKS
from fsm_calib.world2d.observation import observe, robot_time, smoothed
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.path import Path
from fsm_calib.world2d.rollout import Drive, Flags, active_flags, simulate_many
from fsm_calib.world2d.scale import Scale

NOMINAL_WHEEL_RATE = (
    20.0  # rad/s at command 1: Duckietown DB18 on its nominal battery (27 is the unloaded motor)
)
LEAD_TIME = 1.2  # s simulated before the first event, so that a delayed command and a moving start are known
GRID_STEP = 0.01  # s between stored states; cubic interpolation in between
AT_A_TIME = 8  # parameter vectors whose states are held at once: half a megabyte a minute each
SMALL_RADIUS = 0.05  # m: larger wheels are taken to have the same share of the robot's mass at their rims
LOWEST_INPUT_LAG = (
    0.005  # s: measured wheel speeds need no motor; they begin earlier by the shortest lag that it has
)


@dataclass(frozen=True, eq=False)
class Simulator:
    """One recording's commands, sample times and exogenous track, ready to be rolled out again and again.

    measured_input : the drive is made of measured wheel speeds, not of commands. full_speed [m/s]: rim speed of
    command 1. world: physics that the simulation has beyond the base robot, values by full name. cut : commands end at
    full command (`drive_of`).
    """

    prepared: Prepared
    drive: Drive
    grid: FloatArray
    track: FloatArray
    full_speed: float
    measured_input: bool
    world: Mapping[str, float] = field(default_factory=dict)
    cut: bool = True

    def increments(self, values: FloatArray) -> FloatArray:
        """Return increments (forward, left [m], turn, wheel left, right [rad]) of k parameter vectors.

        Parameters
        ----------
        values : array, shape (k, p)

        Returns
        -------
        array, shape (k, n, 5)
            In the sensor's own frame at the event before, as `Prepared.step`; row 0 is zero.
        """
        p = self.prepared
        last = len(p.time) - 1
        return self.increments_between(values, 0, last, self.grid, p.reference[0], self.drive, self._path)

    @cached_property
    def _path(self) -> Path:
        return Path.of(self.track, self.grid)

    def increments_between(
        self,
        values: FloatArray,
        first: int,
        last: int,
        grid: FloatArray,
        start: FloatArray,
        drive: Drive,
        track: FloatArray | Path,
    ) -> FloatArray:
        """Return increments (k, last - first + 1, 5) of the events from `first` to `last` alone; row 0 is zero.

        grid : (g,) [s], every `GRID_STEP`, from where the robot stands at `start` (pose, or pose and twist); drive and
        track : what of both acts then.
        """
        if len(values) > AT_A_TIME:
            parts = [values[i : i + AT_A_TIME] for i in range(0, len(values), AT_A_TIME)]
            return np.concatenate(
                [self.increments_between(v, first, last, grid, start, drive, track) for v in parts]
            )
        p, part = self.prepared, slice(first, last + 1)
        on = active_flags(values)
        states = simulate_many(values, drive, grid, start, track, p.settings.simulation_step, on)
        time, reference = p.time[part], p.reference[part]
        out = np.empty((len(values), len(time), 5))
        clocked, filtered, mounted, mapped = (_acts(on, hook) for hook in POSE_HOOKS)
        seen = mounted | mapped
        for i, vector in enumerate(values):
            seen_at = np.ascontiguousarray(robot_time(vector, p.time, on[i])[part]) if clocked[i] else time
            if filtered[i]:
                through_filter(vector, grid, states[i], on[i])
            sample_increments(states[i], grid[0], GRID_STEP, seen_at, time, out[i])
            if seen[i]:
                through_sensor(vector, time, reference, out[i], on[i])
        return out


def through_filter(vector: FloatArray, grid: FloatArray, states: FloatArray, on: Flags) -> None:
    """Give states (g, 12) at the times `grid` (g,) [s] the poses and twists that the pose sensor's filter has."""
    poses = smoothed(vector, grid, states[:, :3], on)
    if not np.array_equal(poses, states[:, :3]):  # a delay alone is none
        retrace(states, poses, GRID_STEP)


def through_sensor(
    vector: FloatArray, time: FloatArray, reference: FloatArray, out: FloatArray, on: Flags
) -> None:
    """Turn the robot's increments into the sensor's: s' = c(k-1)^-1 s c(k), c = sensor pose seen from the robot.

    Place is taken from the reference path, so that open-loop drift does not matter; time (n,) [s] from the stamps.
    """
    mount_and_compose(reference, observe(vector, time, reference, reference[:, :2], on), out)


@per_catalogue
def _with_hook(hook: str) -> Flags:
    """Return one flag an effect: whether it has a hook."""
    return np.array([hook in effect.hooks for effect in registry().values()])


def _acts(on: Flags, hook: str) -> Flags:
    """Return which rows of flags (k, effects) have an effect with a hook of `POSE_HOOKS`, (k,)."""
    return np.asarray((on & _with_hook(hook)).any(axis=1))


@njit(cache=True)
def retrace(states, poses, step):  # type: ignore[no-untyped-def]
    """Put `poses` (g, 3), a `step` [s] apart, into states (g, 12), with the twists [m/s, m/s, rad/s] between them."""
    last = len(poses) - 1
    for k in range(last + 1):
        before, after = max(k - 1, 0), min(k + 1, last)
        span = (after - before) * step
        c, s = np.cos(poses[k, 2]), np.sin(poses[k, 2])
        dx = (poses[after, 0] - poses[before, 0]) / span
        dy = (poses[after, 1] - poses[before, 1]) / span
        states[k, 0], states[k, 1], states[k, 2] = poses[k, 0], poses[k, 1], poses[k, 2]
        states[k, 3], states[k, 4] = c * dx + s * dy, c * dy - s * dx
        states[k, 5] = (poses[after, 2] - poses[before, 2]) / span


@njit(cache=True)
def mount_and_compose(robot, sensor, out):  # type: ignore[no-untyped-def]
    """Replace robot increments `out` (n, 5) by a sensor's whose poses are `sensor` when the robot's are `robot`."""
    n = len(out)
    c = np.empty((n, 3))
    for k in range(n):
        cs, sn = np.cos(robot[k, 2]), np.sin(robot[k, 2])
        dx, dy = sensor[k, 0] - robot[k, 0], sensor[k, 1] - robot[k, 1]
        c[k, 0], c[k, 1] = cs * dx + sn * dy, cs * dy - sn * dx
        c[k, 2] = sensor[k, 2] - robot[k, 2]
    for k in range(n - 1, 0, -1):
        cs, sn = np.cos(out[k, 2]), np.sin(out[k, 2])
        x = out[k, 0] + cs * c[k, 0] - sn * c[k, 1] - c[k - 1, 0]
        y = out[k, 1] + sn * c[k, 0] + cs * c[k, 1] - c[k - 1, 1]
        cs, sn = np.cos(c[k - 1, 2]), np.sin(c[k - 1, 2])
        out[k, 0], out[k, 1] = cs * x + sn * y, cs * y - sn * x
        out[k, 2] += c[k, 2] - c[k - 1, 2]


@njit(cache=True)
def sample_increments(states, begin, step, pose_time, wheel_time, out):  # type: ignore[no-untyped-def]
    """Fill `out` (n, 5) with increments between the states at the given times (cubic Hermite interpolation).

    states : (g, 12), `rollout.COLUMNS`, every `step` [s] from `begin` [s].
    """
    last = len(states) - 2
    px = py = pt = pl = pr = 0.0
    pc, ps = 1.0, 0.0
    for k in range(len(pose_time)):
        place = (pose_time[k] - begin) / step
        i = min(max(int(place), 0), last)
        u = place - i
        h10, h11 = u * (1 - u) ** 2 * step, u * u * (u - 1) * step
        h01 = u * u * (3 - 2 * u)
        a, b = states[i], states[i + 1]
        ca, sa = np.cos(a[2]), np.sin(a[2])
        dc, ds = small_rotation(b[2] - a[2])
        cb, sb = ca * dc - sa * ds, sa * dc + ca * ds
        x = a[0] + h01 * (b[0] - a[0]) + h10 * (ca * a[3] - sa * a[4]) + h11 * (cb * b[3] - sb * b[4])
        y = a[1] + h01 * (b[1] - a[1]) + h10 * (sa * a[3] + ca * a[4]) + h11 * (sb * b[3] + cb * b[4])
        turn = h01 * (b[2] - a[2]) + h10 * a[5] + h11 * b[5]
        t = a[2] + turn
        place = (wheel_time[k] - begin) / step
        i = min(max(int(place), 0), last)
        u = place - i
        left = states[i, 6] + u * (states[i + 1, 6] - states[i, 6])
        right = states[i, 7] + u * (states[i + 1, 7] - states[i, 7])
        if k == 0:
            out[0, :] = 0.0
        else:
            out[k, 0] = pc * (x - px) + ps * (y - py)
            out[k, 1] = pc * (y - py) - ps * (x - px)
            out[k, 2] = t - pt
            out[k, 3] = left - pl
            out[k, 4] = right - pr
        px, py, pt, pl, pr = x, y, t, left, right
        dc, ds = small_rotation(turn)
        pc, ps = ca * dc - sa * ds, sa * dc + ca * ds


def make_simulator(
    prepared: Prepared, world: Mapping[str, float] | None = None, *, cut: bool = True
) -> Simulator:
    """Return the simulator of a recording; `world` is physics that it has beyond the base robot, by full name, and
    `cut` tells whether its commands end at full command (`drive_of`).

    Raises
    ------
    DataError
        The recording has neither commands nor wheel speeds.
    """
    recording = prepared.recording
    full = full_speed(recording)
    drive, measured = drive_of(recording, full, cut)
    grid = np.arange(prepared.time[0] - LEAD_TIME, prepared.time[-1] + 2 * GRID_STEP, GRID_STEP)
    return Simulator(prepared, drive, grid, track_of(prepared), full, measured, dict(world or {}), cut)


def scale_of(simulator: Simulator) -> Scale:
    """Return by how much the robot is larger and faster than the small ones for which bounds are declared."""
    return Scale.of(2.0 * float(simulator.prepared.geometry[0]), simulator.full_speed)


def track_of(prepared: Prepared) -> FloatArray:
    """Return time [s], x, y [m], theta [rad] of the path, and the wheels' angles [rad] where they were measured."""
    track = prepared.track.poses()
    if not prepared.has_encoders:
        return track
    angles = np.cumsum(prepared.step[:, 3:], axis=0)
    turned = [np.interp(prepared.track.time, prepared.time, angles[:, side]) for side in range(2)]
    return np.column_stack([track, *turned])


def full_speed(recording: Recording) -> float:
    """Return the nominal rim speed [m/s] of command 1."""
    robot = recording.robot
    return (robot.max_wheel_rate or NOMINAL_WHEEL_RATE) * (robot.wheel_radius or NOMINAL_RADIUS)


def drive_of(recording: Recording, full: float, cut: bool = True) -> tuple[Drive, bool]:
    """Return the wheel commands in units of command 1, and whether they are measured wheel speeds instead; these
    begin when what they stand for does (`wheel_stamps`).

    cut : shares of full command end at full command, as duties do: a logger notes what was asked for, and what was
    asked beyond it is no finding. A controller may follow it (`candidates/beyond_full.py`).
    """
    robot = recording.robot
    half = 0.5 * (robot.axle_length or NOMINAL_AXLE)
    radius = robot.wheel_radius or NOMINAL_RADIUS
    if recording.command is not None:
        track = recording.command
        if track.unit == "normalized":
            most = 1.0 if cut else np.inf
            return Drive(
                track.time, np.clip(track.left, -most, most), np.clip(track.right, -most, most)
            ), False
        return Drive(track.time, track.left * radius / full, track.right * radius / full), False
    if recording.twist is not None:
        twist = recording.twist
        turn = half * twist.omega
        return Drive(twist.time, (twist.v - turn) / full, (twist.v + turn) / full), False
    for pair, scale in ((recording.wheel_rate, radius), (recording.wheel_speed, 1.0)):
        if pair is not None:
            time, left, right = held(pair)
            return Drive(time - LOWEST_INPUT_LAG, left * scale / full, right * scale / full), True
    raise DataError(
        f"{recording.source or robot.name}: neither commands nor wheel speeds were recorded",
        cure="Log the wheel commands, or the encoders' rates.",
    )


def rotor_scale(radius: float) -> float:
    """Return by how much [1] the wheels' rotating inertia differs from a Duckiebot's on wheels of `radius` [m].

    Its share of the robot's mass at the rims, inertia / radius^2, falls from smaller wheels to larger ones up to
    `SMALL_RADIUS` and is the same beyond; below a Duckiebot's wheels it is a Duckiebot's, half of the robot's mass at
    both rims: a smaller robot's motor is geared for its own mass.
    """
    return min(1.0, radius / NOMINAL_RADIUS) ** 2 * max(1.0, radius / SMALL_RADIUS) ** 2


def nominal_values(simulators: Sequence[Simulator]) -> FloatArray:
    """Return the parameter vector of the robot as its manifest states it, with the effects that its world has."""
    table = parameter_table()
    robot = simulators[0].prepared.recording.robot
    axle = robot.axle_length or NOMINAL_AXLE
    values = np.maximum(table.null, [entry.of_axle * axle or -np.inf for entry in table.entries])
    for name, value in simulators[0].world.items():
        values[table.place(name)] = value
    for side in ("left", "right"):
        values[table.place(f"gain_{side}")] = simulators[0].full_speed
        values[table.place(f"wheel_radius_{side}")] = robot.wheel_radius or NOMINAL_RADIUS
    values[table.place("axle_length")] = axle
    values[table.place("wheel_inertia")] *= rotor_scale(robot.wheel_radius or NOMINAL_RADIUS)
    if simulators[0].measured_input:
        values[table.place("tau_forward")] = LOWEST_INPUT_LAG
        values[table.place("tau_turn")] = LOWEST_INPUT_LAG
    return values
