"""The sections of a scenario that mirror settings of other rooms, and the names those rooms declare."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import Field, create_model

from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.published import PUBLISHED as PUBLISHED_ACTIONS
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.machines.limits import PUBLISHED as PUBLISHED_LIMITS
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.scenario.section import Section, mirror, mirror_of
from fsm_calib.types import BoardSpec, CameraMount, Pose2
from fsm_calib.world2d.effects import Parameter, registry
from fsm_calib.world2d.faults import (
    BlurredCamera,
    DeadWheel,
    DroppedFrames,
    FrozenFrames,
    MissingBoard,
    MissingMarkers,
    Obstacle,
)
from fsm_calib.world2d.overhead import TrackerSettings
from fsm_calib.world2d.parameters import BASE, parameter_table
from fsm_calib.world2d.robot import Wear, WorldSettings
from fsm_calib.world2d.scale import LARGEST, Scale
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, Road, Wall
from fsm_calib.world2d.sensor import SensorSettings

GAINS = ("gain_left", "gain_right")
"""Parameters of the base that a scenario gives as `wheel_ratio` and `speed`."""

FAULT_KINDS: dict[str, type] = {
    "dead_wheel": DeadWheel,
    "frozen_frames": FrozenFrames,
    "dropped_frames": DroppedFrames,
    "missing_board": MissingBoard,
    "missing_markers": MissingMarkers,
    "obstacle": Obstacle,
    "blurred_camera": BlurredCamera,
}
"""How a scenario calls each fault of `world2d.faults`."""


def _physical(parameter: Parameter) -> tuple[Any, Any]:
    """Return type and field of one number of an effect or of the base robot."""
    said = (
        f"{parameter.symbol} [{parameter.unit}]; default {parameter.null:g}, typical {parameter.typical:g}."
    )
    low, high = LARGEST.bounds(parameter)
    return float | None, Field(default=None, ge=low, le=high, description=said)


def base_section() -> type[Section]:
    """Return the section with the base robot's physics; its gains follow from wheel ratio and speed."""
    values: dict[str, Any] = {
        parameter.name: _physical(parameter) for parameter in BASE if parameter.name not in GAINS
    }
    return create_model("BaseSection", __base__=Section, __doc__="Physics of the base robot.", **values)


def effects_section() -> type[Section]:
    """Return the section that switches on effects of the catalogue.

    An effect that is named without values has the typical size that its file declares; where some values
    are given, the others have the value that changes nothing.
    """
    parts: dict[str, Any] = {}
    for effect in registry().values():
        values: dict[str, Any] = {parameter.name: _physical(parameter) for parameter in effect.parameters}
        title = "".join(word.capitalize() for word in effect.name.split("_"))
        part = create_model(f"{title}Section", __base__=Section, **values)
        said = f"{effect.summary[0].upper()}{effect.summary[1:]}: {effect.equation}."
        parts[effect.name] = (part | None, Field(default=None, description=said))
    return create_model(
        "EffectsSection", __base__=Section, __doc__="Effects of the catalogue, by name.", **parts
    )


def beyond_size(base: Section, effects: Section, speed: float | None) -> str:
    """Return what is more than a robot of this axle and speed (a share of the nominal) may have; empty for none."""
    table, given = parameter_table(), base.model_dump(exclude_none=True)
    null = dict(zip(table.names, table.null, strict=True))
    axle = given.get("axle_length") or null["axle_length"]
    scale = Scale.of(axle, (speed or 1.0) * null["gain_left"])
    parts = effects.model_dump(exclude_none=True)
    given |= {f"{name}.{key}": value for name, part in parts.items() for key, value in part.items()}
    for full, value in given.items():
        entry = table.entries[table.place(full)]
        low, high = scale.bounds(entry)
        if not low <= value <= high:
            return (
                f"{full} is {value:g} {entry.unit}, not in {low:g} to {high:g} {entry.unit}, which a robot with an "
                f"axle of {axle:g} m may have"
            )
    return ""


if TYPE_CHECKING:  # what a mirror holds is known when it is made, not before
    Phase: TypeAlias = str
    Published: TypeAlias = str
    LimitsSection: TypeAlias = Any
    InvestigateSection: TypeAlias = Any
    TrackerSection: TypeAlias = Any
    ActionsSection: TypeAlias = Any
    FieldSection: TypeAlias = Any
    RoadSection: TypeAlias = Any
    PlacedBoard: TypeAlias = Any
    BoardSection: TypeAlias = Any
    WallSection: TypeAlias = Any
    FaultSection: TypeAlias = Any
    SensorSection: TypeAlias = Any
    MountSection: TypeAlias = Any
    EffectsSection: TypeAlias = Any
    PoseSection: TypeAlias = Any
    BaseSection: TypeAlias = Any
    WearSection: TypeAlias = Any
    WorldSection: TypeAlias = Any
    LinkSection: TypeAlias = Any
    ServeSection: TypeAlias = Any
else:
    Phase = Literal[PHASES]
    Published = Literal[(*PUBLISHED_ACTIONS, *PUBLISHED_LIMITS)]
    LimitsSection = mirror(Limits, skip=("boards", "start_board"))
    ActionsSection = mirror(ActionSettings, skip=("board",))
    InvestigateSection = mirror(InvestigateSettings)
    TrackerSection = mirror(TrackerSettings)
    FieldSection = mirror_of(MarkerField)
    RoadSection = mirror(Road, skip=("start",))
    PlacedBoard = mirror_of(BoardPlacement)
    BoardSection = mirror_of(BoardSpec)
    WallSection = mirror_of(Wall)
    SensorSection = mirror(SensorSettings, skip=("defocus",))
    MountSection = mirror_of(CameraMount)
    EffectsSection = effects_section()
    BaseSection = base_section()
    PoseSection = mirror_of(Pose2)
    WearSection = mirror_of(Wear)
    WorldSection = mirror_of(WorldSettings)
    LinkSection = mirror_of(LinkSettings)
    ServeSection = mirror_of(ServeSettings)
    _faults = [mirror(target, kind=kind) for kind, target in FAULT_KINDS.items()]
    FaultSection = Annotated[reduce(or_, _faults), Field(discriminator="kind")]
