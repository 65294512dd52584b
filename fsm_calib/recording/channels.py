"""The channels of a recording: frozen, time-stamped arrays in SI units.

Every array is a read-only float64 copy of shape (n,). `time` [s] increases strictly and belongs to the
recording's one clock. A channel that was logged as mean values over intervals has `duration` [s] of shape
(n,) too, and `time` is then the start of each interval.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np

from fsm_calib.types import FloatArray, Pose2, read_only

CommandUnit = Literal["normalized", "rad/s"]
Stamp = Literal["start", "middle", "end"]
"""What the stamp of a rate is, of the time that the rate stands for (`wheel_stamps`)."""


@dataclass(frozen=True, eq=False)
class Channel:
    """What all channels share: read-only arrays, equality by value, slices of time."""

    time: FloatArray

    def __post_init__(self) -> None:
        """Copy the arrays and make them read-only."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray | list):
                object.__setattr__(self, field.name, read_only(value).ravel())

    def __eq__(self, other: object) -> bool:
        """Return whether `other` is the same kind of channel with the same numbers (NaN equals NaN)."""
        if type(self) is not type(other):
            return NotImplemented
        names = [field.name for field in dataclasses.fields(self)]
        return all(_same(getattr(self, name), getattr(other, name)) for name in names)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.time)

    def rows(self, index: Any) -> Self:
        """Return the channel with the rows that `index` (slice, mask or row numbers) selects."""
        changes = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                changes[field.name] = value[index]
            elif isinstance(value, tuple):
                changes[field.name] = tuple(np.array(value, dtype=object)[index])
        return dataclasses.replace(self, **changes)


def _same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return bool(np.array_equal(a, b, equal_nan=True))
    return bool(a == b)


@dataclass(frozen=True, eq=False)
class CommandTrack(Channel):
    """Wheel commands; each holds until the next row.

    left, right : normalized commands in [-1, 1] or wheel rates [rad/s], positive forward (`unit` says which);
    stale_after : a command older than this [s] says nothing about the wheels (the log had a gap); None =
    never. lost : how many commands before each row never reached the log; None = nobody counted. ended : 1 at a row
    after which the log had ended though the drive went on, else 0; None = nowhere.
    """

    left: FloatArray
    right: FloatArray
    unit: CommandUnit = "normalized"
    stale_after: float | None = None
    lost: FloatArray | None = None
    ended: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class TwistTrack(Channel):
    """Commanded forward speed v [m/s] and turn rate omega [rad/s, counter-clockwise]; each holds until the
    next. `stale_after`, `lost` and `ended` as of wheel commands.
    """

    v: FloatArray
    omega: FloatArray
    stale_after: float | None = None
    lost: FloatArray | None = None
    ended: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class PoseTrack(Channel):
    """Measured poses of the tracked point in `world`: x, y [m], theta [rad] as logged; NaN = not measured."""

    x: FloatArray
    y: FloatArray
    theta: FloatArray

    @property
    def has_heading(self) -> bool:
        """Whether any heading was measured."""
        return bool(np.isfinite(self.theta).any())

    @property
    def heading(self) -> FloatArray:
        """Heading [rad] unwrapped over the rows that have one; NaN elsewhere."""
        unwrapped = self.theta.copy()
        known = np.isfinite(unwrapped)
        unwrapped[known] = np.unwrap(unwrapped[known])
        return read_only(unwrapped)

    def pose(self, row: int) -> Pose2:
        """Return one row as a pose."""
        return Pose2(float(self.x[row]), float(self.y[row]), float(self.theta[row]))


@dataclass(frozen=True, eq=False)
class WheelPair(Channel):
    """One number for each wheel, positive forward: angles [rad or tick], rates [rad/s] or rim speeds [m/s].

    `resolution` is the step of an encoder in the same unit (0 = not known); `unit` names the unit. Ticks stay
    ticks where nobody knows how many make a turn. `stamp` says where in its time a rate's stamp lies; None: nobody
    said, read as a sample (middle).
    """

    left: FloatArray
    right: FloatArray
    unit: str = "rad"
    resolution: float = 0.0
    duration: FloatArray | None = None
    stamp: Stamp | None = None


@dataclass(frozen=True, eq=False)
class YawRateTrack(Channel):
    """Measured turn rate `value` [rad/s, counter-clockwise]."""

    value: FloatArray
    duration: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class DisplacementTrack(Channel):
    """Motion over intervals, in the moving frame at each interval's start.

    time : start of the interval [s]; duration [s]; dx, dy [m], dtheta [rad]; `of`: the sensor's or the base's
    motion.
    """

    duration: FloatArray
    dx: FloatArray
    dy: FloatArray
    dtheta: FloatArray
    of: Literal["sensor", "base"] = "sensor"


@dataclass(frozen=True, eq=False)
class StateTrack(Channel):
    """The machine's state: `path` (for instance ``wheels.shuttling.forward``) holds from `time` [s] to the
    next row.
    """

    path: tuple[str, ...] = ()

    def at(self, time: float) -> str:
        """Return the state that was active at `time` [s]; empty before the first row."""
        row = int(np.searchsorted(self.time, time, side="right")) - 1
        return self.path[row] if row >= 0 else ""
