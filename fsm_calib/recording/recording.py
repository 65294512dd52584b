"""`Recording`: what one drive of one robot left behind, in one immutable value."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from fsm_calib.recording.channels import (
    Channel,
    CommandTrack,
    DisplacementTrack,
    PoseTrack,
    StateTrack,
    TwistTrack,
    WheelPair,
    YawRateTrack,
)
from fsm_calib.types import FloatArray, read_only

CHANNELS = (
    "command",
    "twist",
    "pose",
    "wheel_angle",
    "wheel_rate",
    "wheel_speed",
    "yaw_rate",
    "displacement",
    "state",
)
LARGEST_FACT = 1e6
"""What sizes, rates and masses stay below, in SI units: far beyond any robot, and no number overflows later."""
GAP_FACTOR = (
    3.0  # a gap is an interval this many times longer than the median one (a person's eye for a hole)
)


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """What is known of the robot beforehand; None = not known.

    wheel_radius, axle_length [m]; max_wheel_rate [rad/s at command 1]; metres_per_tick [m]; mass [kg]; inertia about
    the vertical [kg m2].
    """

    name: str = "robot"
    wheel_radius: float | None = None
    axle_length: float | None = None
    max_wheel_rate: float | None = None
    metres_per_tick: float | None = None
    mass: float | None = None
    inertia: float | None = None


def called(channel: str) -> str:
    """Return a channel's name as manifests have it: commands are `command` there, of the wheels or of the robot."""
    return "command" if channel == "twist" else channel


@dataclass(frozen=True, slots=True)
class Finding:
    """Something a person would want to know about the data.

    kind : for instance ``time_backwards``, ``jump``, ``gap``, ``frozen``, ``unit_slip``, ``clocks``;
    action : "dropped" where rows were left out, "kept" where the data stands and the reader is warned;
    rows : how many rows; time [s] of the first of them.
    """

    channel: str
    kind: str
    sentence: str
    action: Literal["dropped", "kept"] = "kept"
    rows: int = 0
    time: float | None = None

    def __str__(self) -> str:
        """Return the line that is printed."""
        return f"{called(self.channel)}: {self.sentence}"


@dataclass(frozen=True)
class Recording:
    """One drive: robot facts, channels that share one clock, and what was found wrong with them.

    A channel that was not recorded is None. `command` holds wheel commands, `twist` holds (v, omega)
    commands; a recording has at most one of them. `source` is the file that it came from, `clock_zero` [s] what its
    clock showed at time 0 (seconds since 1970 for most loggers). Equality compares facts and channels.
    """

    robot: RobotFacts = RobotFacts()
    command: CommandTrack | None = None
    twist: TwistTrack | None = None
    pose: PoseTrack | None = None
    wheel_angle: WheelPair | None = None
    wheel_rate: WheelPair | None = None
    wheel_speed: WheelPair | None = None
    yaw_rate: YawRateTrack | None = None
    displacement: DisplacementTrack | None = None
    state: StateTrack | None = None
    checks: tuple[Finding, ...] = field(default=(), compare=False)
    source: str = field(default="", compare=False)
    clock_zero: float = field(default=0.0, compare=False)

    @property
    def channels(self) -> dict[str, Channel]:
        """The channels that were recorded, by name."""
        found = {name: getattr(self, name) for name in CHANNELS}
        return {name: channel for name, channel in found.items() if channel is not None}

    @property
    def commands(self) -> CommandTrack | TwistTrack | None:
        """What the robot was told: its wheels, or the whole robot where nothing is logged of them."""
        return self.command or self.twist

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s] over all channels; (0, 0) when there is none."""
        times = [channel.time for channel in self.channels.values() if len(channel)]
        if not times:
            return 0.0, 0.0
        return min(float(t[0]) for t in times), max(float(t[-1]) for t in times)

    def window(self, start: float, end: float) -> Recording:
        """Return the part with start <= time < end [s].

        Values that hold (commands, states) keep the row that was active at `start`.
        """
        cut = {}
        for name, channel in self.channels.items():
            first, last = np.searchsorted(channel.time, [start, end], side="left")
            if name in ("command", "twist", "state") and first > 0 and not _starts_at(channel, first, start):
                first -= 1
            cut[name] = channel.rows(slice(int(first), int(max(first, last))))
        return dataclasses.replace(self, **cut)  # type: ignore[arg-type]

    def windows(self, length: float, step: float | None = None) -> list[Recording]:
        """Cut into whole windows of `length` [s], one every `step` [s] (default: end to end)."""
        start, end = self.span
        starts = np.arange(start, end - length + 1e-9, step or length)
        return [self.window(float(t), float(t) + length) for t in starts]

    def gaps(self, channel: str, longest: float | None = None) -> list[tuple[float, float]]:
        """Return the (start, end) [s] of every interval of a channel longer than `longest` [s].

        Without `longest`, three times the median interval counts as a gap.
        """
        time = self.channels[channel].time
        step = np.diff(time)
        if not len(step):
            return []
        limit = longest if longest is not None else GAP_FACTOR * float(np.median(step))
        return [(float(time[i]), float(time[i + 1])) for i in np.flatnonzero(step > limit)]


def _starts_at(channel: Channel, row: int, start: float) -> bool:
    return bool(row < len(channel.time) and channel.time[row] == start)


def resample_pose(track: PoseTrack, times: FloatArray, longest_gap: float | None = None) -> PoseTrack:
    """Interpolate a pose track linearly (heading unwrapped) at `times` [s].

    Rows outside the track, and rows inside an interval longer than `longest_gap` [s], are NaN.
    """
    times = np.asarray(times, dtype=float)
    columns = [_interpolate(times, track.time, column) for column in (track.x, track.y, track.heading)]
    if longest_gap is not None and len(track.time) > 1:
        row = np.clip(np.searchsorted(track.time, times, side="right"), 1, len(track.time) - 1)
        hole = (np.diff(track.time)[row - 1] > longest_gap) & ~np.isin(times, track.time)
        columns = [np.where(hole, np.nan, column) for column in columns]
    return PoseTrack(times, *columns)


def _interpolate(times: FloatArray, known_times: FloatArray, values: FloatArray) -> FloatArray:
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(times), np.nan)
    return np.interp(times, known_times[known], values[known], left=np.nan, right=np.nan)


def held_at(
    times: FloatArray, known_times: FloatArray, values: FloatArray, before: float = 0.0
) -> FloatArray:
    """Return held values at `times`: the last row at or before each time; `before` ahead of the first row."""
    row = np.searchsorted(known_times, times, side="right") - 1
    return read_only(np.where(row >= 0, np.asarray(values)[np.maximum(row, 0)], before))


def held_integral(known_times: FloatArray, values: FloatArray, end: float) -> tuple[FloatArray, FloatArray]:
    """Return times (n + 1,) and the integral of held values (n,) there: 0 at the first, the last held until `end`."""
    times = np.append(known_times, max(end, float(known_times[-1])))
    return times, np.concatenate([[0.0], np.cumsum(np.asarray(values) * np.diff(times))])
