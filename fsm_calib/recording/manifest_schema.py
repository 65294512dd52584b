"""The schema of a manifest `fsm-calib/recording@1`, and every mistake in one with its place.

One class for each section; unknown keys are errors. Lengths in m, times in s, unless a section's `length_unit` or
`time_unit` says otherwise.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fsm_calib.errors import InputError, ManyErrors, nearest_names
from fsm_calib.recording.yaml_places import KEY, PlacedYaml

FORMAT = "fsm-calib/recording@1"
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Fact = Annotated[float, Field(gt=1e-9, lt=1e6, allow_inf_nan=False)]
"""A robot's size, rate or step in SI units: far beyond any robot at both ends, and no number overflows later."""
Name = Annotated[str, Field(min_length=1, max_length=200)]


class Section(BaseModel):
    """A part of a manifest: unknown keys are errors, nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class RobotSection(Section):
    """What is known: wheel_radius, axle_length [m], max_wheel_rate [rad/s], metres_per_tick [m]."""

    name: Name = "robot"
    wheel_radius: Fact | None = None
    axle_length: Fact | None = None
    max_wheel_rate: Fact | None = None
    metres_per_tick: Fact | None = None


class ChannelSection(Section):
    """A file and its time column, or a column of interval lengths; `time_unit` [s], `length_unit` [m] per
    unit.
    """

    file: Name
    time: Name | None = None
    duration: Name | None = None
    time_unit: Positive | None = None
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
