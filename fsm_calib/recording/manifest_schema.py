"""The schema of a manifest `fsm-calib/recording@1`, and every mistake in one with its place.

One class for each section; unknown keys are errors. Lengths in m, times in s, unless a section's `length_unit` or
`time_unit` says otherwise.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from fsm_calib.errors import InputError, ManyErrors, nearest_names
from fsm_calib.recording.channels import Stamp
from fsm_calib.recording.recording import LARGEST_FACT
from fsm_calib.recording.yaml_places import KEY, PlacedYaml

FORMAT = "fsm-calib/recording@1"
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Fact = Annotated[float, Field(gt=1e-9, lt=LARGEST_FACT, allow_inf_nan=False)]
"""A robot's size, rate or step in SI units: far beyond any robot at both ends, and no number overflows later."""
Name = Annotated[str, Field(min_length=1, max_length=200)]


class Section(BaseModel):
    """A part of a manifest: unknown keys are errors, nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class RobotSection(Section):
    """What is known: wheel_radius, axle_length [m], max_wheel_rate [rad/s], metres_per_tick [m], mass [kg], inertia
    [kg m2]; `urdf` names a URDF or SDF file that says what is not given here.
    """

    name: Name = "robot"
    wheel_radius: Fact | None = None
    axle_length: Fact | None = None
    max_wheel_rate: Fact | None = None
    metres_per_tick: Fact | None = None
    mass: Fact | None = None
    inertia: Fact | None = None
    urdf: Name | None = None


class ChannelSection(Section):
    """A file and its time column, or a column of interval lengths; `time_unit` [s], `length_unit` [m] per
    unit; `only` the rows with these words in these columns.
    """

    file: Name
    only: dict[Name, str] | None = None
    time: Name | None = None
    duration: Name | None = None
    time_unit: Positive | None = None
    length_unit: Positive | None = None

    @model_validator(mode="after")
    def _one_clock(self) -> ChannelSection:
        if (self.time is None) == (self.duration is None):
            raise ValueError("give either time or duration")
        return self


class CommandSection(ChannelSection):
    """Commands of the wheels (left, right) or of the robot (v, omega; unit twist); each holds until the next
    row. `full` is the number that stands for full command (1, or 100 for percent, 255 for eight bits); `lost`
    counts the commands before a row that never reached the log.
    """

    left: Name | None = None
    right: Name | None = None
    v: Name | None = None
    omega: Name | None = None
    unit: Literal["normalized", "rad/s", "rpm", "twist"] = "normalized"
    full: Positive | None = None
    angle_unit: Literal["rad", "deg"] | None = None
    stale_after: Positive | None = None
    lost: Name | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> CommandSection:
        wheels, twist = (self.left, self.right), (self.v, self.omega)
        wanted, other = (twist, wheels) if self.unit == "twist" else (wheels, twist)
        if None in wanted or other != (None, None):
            raise ValueError("unit twist needs v and omega, the other units need left and right")
        if self.full is not None and self.unit != "normalized":
            raise ValueError(f"full belongs to unit normalized; commands in {self.unit} have no full number")
        return self


class PoseSection(ChannelSection):
    """Columns of the measured pose; theta may be missing, or be a quaternion's four columns x, y, z, w."""

    x: Name
    y: Name
    theta: Name | None = None
    quaternion: tuple[Name, Name, Name, Name] | None = None
    angle_unit: Literal["rad", "deg"] | None = None

    @model_validator(mode="after")
    def _one_heading(self) -> PoseSection:
        if self.theta is not None and self.quaternion is not None:
            raise ValueError("give theta or quaternion, not both")
        return self


class WheelAngleSection(ChannelSection):
    """Wheel angles; ticks become radians where `ticks_per_turn` is given."""

    left: Name
    right: Name
    unit: Literal["rad", "deg", "tick"] = "rad"
    ticks_per_turn: Positive | None = None


class RateSection(ChannelSection):
    """Rates of both wheels: samples (stamp: middle), means since the row before (end), or until the next (start)."""

    left: Name
    right: Name
    stamp: Stamp | None = None

    @model_validator(mode="after")
    def _one_interval(self) -> RateSection:
        if self.duration is not None and self.stamp is not None:
            raise ValueError("duration says already which interval a row is the mean of; leave stamp out")
        return self


class WheelRateSection(RateSection):
    """Wheel rates."""

    unit: Literal["rad/s", "deg/s", "rpm"] | None = None


class WheelSpeedSection(RateSection):
    """Rim speeds of the wheels."""

    unit: Literal["m/s"] = "m/s"


class YawRateSection(ChannelSection):
    """A gyro."""

    value: Name
    unit: Literal["rad/s", "deg/s"] | None = None


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


class TopicSection(Section):
    """A topic of a bag."""

    topic: Name


class CommandTopic(TopicSection):
    """Commands; one older than `stale_after` [s] says nothing."""

    stale_after: Positive | None = None


class WheelTopic(TopicSection):
    """Wheels: JointState with the names of the left and the right joint, encoders or an odometry; `stamp` says which
    time a rate stands for.
    """

    left: Name | None = None
    right: Name | None = None
    stamp: Stamp | None = None

    @model_validator(mode="after")
    def _both(self) -> WheelTopic:
        if (self.left is None) != (self.right is None):
            raise ValueError("give both joints, left and right")
        return self


class TopicsSection(Section):
    """Channels of a bag; those that are not named are found by type and name."""

    command: CommandTopic | None = None
    pose: TopicSection | None = None
    wheel_angle: WheelTopic | None = None
    wheel_rate: WheelTopic | None = None
    wheel_speed: WheelTopic | None = None
    yaw_rate: TopicSection | None = None
    state: TopicSection | None = None

    @model_validator(mode="after")
    def _one_of_wheels(self) -> TopicsSection:
        if sum(part is not None for part in (self.wheel_angle, self.wheel_rate, self.wheel_speed)) > 1:
            raise ValueError("name one topic of the wheels; what it holds says what it becomes")
        return self


class BagManifest(Section):
    """A manifest over a bag: channels name topics."""

    format: Literal["fsm-calib/recording@1"]
    bag: Name
    robot: RobotSection = RobotSection()
    channels: TopicsSection = TopicsSection()


def validate_manifest(placed: PlacedYaml) -> Manifest | BagManifest:
    """Return the manifest, or raise every error in it with its place."""
    if not isinstance(placed.data, dict):
        raise InputError(
            "the manifest holds no mapping", where=placed.place(()), cure=f"Begin with 'format: {FORMAT}'."
        )
    kind: type[Manifest] | type[BagManifest] = BagManifest if "bag" in placed.data else Manifest
    try:
        return kind.model_validate(placed.data)
    except ValidationError as error:
        errors = [_input_error(placed, detail, kind) for detail in error.errors()]
        raise errors[0] if len(errors) == 1 else ManyErrors(errors) from error


def manifest_schema_text() -> str:
    """Return the JSON Schema of manifests, of tables and of bags, for editors."""
    plain = TypeAdapter(Manifest | BagManifest).json_schema()
    plain["title"] = f"Manifest {FORMAT}"
    return json.dumps(plain, indent=1) + "\n"


def _input_error(placed: PlacedYaml, detail: Any, kind: type[BaseModel]) -> InputError:
    path = tuple(detail["loc"])
    key = ".".join(str(part) for part in path) or "manifest"
    cure = ""
    if detail["type"] == "extra_forbidden":
        cure = nearest_names(str(path[-1]), _known_keys(path[:-1], kind))
        return InputError(f"unknown key {key!r}", where=placed.place((*path, KEY)), cure=cure)
    message = str(detail["msg"]).removeprefix("Value error, ")
    return InputError(f"{key}: {message[:1].lower()}{message[1:]}", where=placed.place(path), cure=cure)


def _known_keys(path: tuple[Any, ...], kind: type[BaseModel]) -> list[str]:
    model: Any = kind
    for part in path:
        annotation = model.model_fields[part].annotation
        arguments = getattr(annotation, "__args__", (annotation,))
        model = next(kind for kind in arguments if isinstance(kind, type) and issubclass(kind, BaseModel))
    return list(model.model_fields)
