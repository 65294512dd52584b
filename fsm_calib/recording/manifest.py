"""The manifest `fsm-calib/recording@1`: which columns of which files are which channels.

A manifest is a YAML file beside CSV files (plain or .gz). `Manifest` is its schema; `read_manifest` turns one
into a `Recording` in SI units. Every mistake in a manifest is told at once, each with file, line and column.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fsm_calib.errors import InputError, ManyErrors, nearest_names
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
from fsm_calib.recording.checks import checked
from fsm_calib.recording.csv_table import Table, read_table
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.yaml_places import KEY, PlacedYaml, read_yaml
from fsm_calib.types import FloatArray

FORMAT = "fsm-calib/recording@1"
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=200)]


class Section(BaseModel):
    """A part of a manifest: unknown keys are errors, nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class RobotSection(Section):
    """What is known: wheel_radius, axle_length [m], max_wheel_rate [rad/s], metres_per_tick [m]."""

    name: Name = "robot"
    wheel_radius: Positive | None = None
    axle_length: Positive | None = None
    max_wheel_rate: Positive | None = None
    metres_per_tick: Positive | None = None


class ChannelSection(Section):
    """A file and its time column, or a column of interval lengths; `time_unit` [s], `length_unit` [m] per
    unit.
    """

    file: Name
    time: Name | None = None
    duration: Name | None = None
    time_unit: Positive = 1.0
    length_unit: Positive = 1.0

    @model_validator(mode="after")
    def _one_clock(self) -> ChannelSection:
        if (self.time is None) == (self.duration is None):
            raise ValueError("give either time or duration")
        return self


class CommandSection(ChannelSection):
    """Commands of the wheels (left, right) or of the robot (v, omega; unit twist); each holds until the next
    row.
    """

    left: Name | None = None
    right: Name | None = None
    v: Name | None = None
    omega: Name | None = None
    unit: Literal["normalized", "rad/s", "twist"] = "normalized"
    stale_after: Positive | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> CommandSection:
        wheels, twist = (self.left, self.right), (self.v, self.omega)
        wanted, other = (twist, wheels) if self.unit == "twist" else (wheels, twist)
        if None in wanted or other != (None, None):
            raise ValueError("unit twist needs v and omega, the other units need left and right")
        return self


class PoseSection(ChannelSection):
    """Columns of the measured pose; theta may be missing."""

    x: Name
    y: Name
    theta: Name | None = None


class WheelAngleSection(ChannelSection):
    """Wheel angles; ticks become radians where `ticks_per_turn` is given."""

    left: Name
    right: Name
    unit: Literal["rad", "tick"] = "rad"
    ticks_per_turn: Positive | None = None


class WheelRateSection(ChannelSection):
    """Wheel rates."""

    left: Name
    right: Name
    unit: Literal["rad/s"] = "rad/s"


class WheelSpeedSection(ChannelSection):
    """Rim speeds of the wheels."""

    left: Name
    right: Name
    unit: Literal["m/s"] = "m/s"


class YawRateSection(ChannelSection):
    """A gyro."""

    value: Name
    unit: Literal["rad/s"] = "rad/s"


class DisplacementSection(ChannelSection):
    """Motion over intervals, of the sensor or of the base."""

    dx: Name
    dy: Name
    dtheta: Name
    of: Literal["sensor", "base"] = "sensor"


class StateSection(ChannelSection):
    """The machine's state path."""

    state: Name


class ChannelsSection(Section):
    """The channels; at least one."""

    command: CommandSection | None = None
    pose: PoseSection | None = None
    wheel_angle: WheelAngleSection | None = None
    wheel_rate: WheelRateSection | None = None
    wheel_speed: WheelSpeedSection | None = None
    yaw_rate: YawRateSection | None = None
    displacement: DisplacementSection | None = None
    state: StateSection | None = None

    @model_validator(mode="after")
    def _any(self) -> ChannelsSection:
        if not any(value is not None for _, value in self):
            raise ValueError("no channel is named")
        return self


class Manifest(Section):
    """A whole manifest."""

    format: Literal["fsm-calib/recording@1"]
    robot: RobotSection = RobotSection()
    channels: ChannelsSection


def read_manifest(path: Path) -> Recording:
    """Read a manifest and its CSV files.

    Raises
    ------
    InputError
        One sentence with file and line for a mistake in the manifest or in a table; `ManyErrors` for several.
    """
    placed = read_yaml(path)
    manifest = validate_manifest(placed)
    channels: dict[str, Any] = {}
    tables: dict[str, Table] = {}
    for name, section in manifest.channels:
        if section is None:
            continue
        table = _read_section(path, section, placed.place(("channels", name, "file")))
        slot = "twist" if name == "command" and section.unit == "twist" else name
        channels[slot] = _channel(name, section, table)
        tables[slot] = table
    recording = Recording(robot=RobotFacts(**manifest.robot.model_dump()), source=str(path), **channels)
    return checked(recording, tables)


def validate_manifest(placed: PlacedYaml) -> Manifest:
    """Return the manifest, or raise every error in it with its place."""
    if not isinstance(placed.data, dict):
        raise InputError(
            "the manifest holds no mapping", where=placed.place(()), cure=f"Begin with 'format: {FORMAT}'."
        )
    try:
        return Manifest.model_validate(placed.data)
    except ValidationError as error:
        errors = [_input_error(placed, detail) for detail in error.errors()]
        raise errors[0] if len(errors) == 1 else ManyErrors(errors) from error


def _input_error(placed: PlacedYaml, detail: Any) -> InputError:
    path = tuple(detail["loc"])
    key = ".".join(str(part) for part in path) or "manifest"
    cure = ""
    if detail["type"] == "extra_forbidden":
        cure = nearest_names(str(path[-1]), _known_keys(path[:-1]))
        return InputError(f"unknown key {key!r}", where=placed.place((*path, KEY)), cure=cure)
    message = str(detail["msg"]).removeprefix("Value error, ")
    return InputError(f"{key}: {message[:1].lower()}{message[1:]}", where=placed.place(path), cure=cure)


def _known_keys(path: tuple[Any, ...]) -> list[str]:
    model: Any = Manifest
    for part in path:
        annotation = model.model_fields[part].annotation
        arguments = getattr(annotation, "__args__", (annotation,))
        model = next(kind for kind in arguments if isinstance(kind, type) and issubclass(kind, BaseModel))
    return list(model.model_fields)


def _read_section(manifest: Path, section: ChannelSection, place: str) -> Table:
    columns = {
        "time",
        "duration",
        "left",
        "right",
        "v",
        "omega",
        "x",
        "y",
        "theta",
        "value",
        "dx",
        "dy",
        "dtheta",
    }
    numeric = [v for k, v in section if k in columns and isinstance(v, str)]
    text = [section.state] if isinstance(section, StateSection) else []
    file = manifest.parent / section.file
    if "\0" in section.file or not file.is_file():
        raise InputError(
            f"the file {section.file!r} does not exist",
            where=place,
            cure="Names are relative to the manifest.",
        )
    return read_table(file, list(dict.fromkeys(numeric)), text)


def _clock(section: ChannelSection, table: Table) -> tuple[FloatArray, FloatArray | None]:
    """Return time [s] and, for a channel of intervals, duration [s]; refuse intervals that do not last."""
    if section.time is not None:
        return table.numbers[section.time] * section.time_unit, None
    duration = table.numbers[str(section.duration)] * section.time_unit
    if (duration <= 0).any():
        row = int(np.argmax(duration <= 0))
        raise InputError(
            f"the interval lasts {duration[row]:g} s; expected more than 0", where=table.where(row)
        )
    return np.concatenate([[0.0], np.cumsum(duration)[:-1]]), duration


def _channel(name: str, section: Any, table: Table) -> Channel:
    time, duration = _clock(section, table)

    def column(key: str, scale: float = 1.0) -> FloatArray:
        return table.numbers[getattr(section, key)] * scale

    metre = section.length_unit
    if name == "command" and section.unit == "twist":
        return TwistTrack(time, column("v", metre), column("omega"), section.stale_after)
    if name == "command":
        return CommandTrack(time, column("left"), column("right"), section.unit, section.stale_after)
    if name == "pose":
        theta = column("theta") if section.theta else np.full(len(time), math.nan)
        return PoseTrack(time, column("x", metre), column("y", metre), theta)
    if name == "wheel_angle":
        scale, unit, step = _angle_unit(section)
        return WheelPair(time, column("left", scale), column("right", scale), unit, step, duration)
    if name in ("wheel_rate", "wheel_speed"):
        scale = metre if name == "wheel_speed" else 1.0
        return WheelPair(time, column("left", scale), column("right", scale), section.unit, 0.0, duration)
    if name == "yaw_rate":
        return YawRateTrack(time, column("value"), duration)
    if name == "displacement":
        length = duration if duration is not None else _intervals(time)
        return DisplacementTrack(
            time, length, column("dx", metre), column("dy", metre), column("dtheta"), section.of
        )
    return StateTrack(time, table.words[section.state])


def _angle_unit(section: WheelAngleSection) -> tuple[float, str, float]:
    """Return scale, unit and resolution of wheel angles."""
    if section.unit == "rad":
        return 1.0, "rad", 0.0
    if section.ticks_per_turn is None:
        return 1.0, "tick", 1.0
    return 2.0 * math.pi / section.ticks_per_turn, "rad", 2.0 * math.pi / section.ticks_per_turn


def _intervals(time: FloatArray) -> FloatArray:
    """Return the time to the next row [s]; the last row lasts as long as the one before."""
    if len(time) < 2:
        return np.ones(len(time))
    step = np.diff(time)
    return np.append(step, step[-1])
