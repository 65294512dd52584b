"""The manifest `fsm-calib/recording@1`: which columns of which files are which channels.

A manifest is a YAML file beside CSV files (plain or .gz). `read_manifest` turns one
into a `Recording` in SI units. `manifest_schema` holds the schema; every mistake in a manifest is told at once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording.channels import (
    Channel,
    CommandTrack,
    CommandUnit,
    DisplacementTrack,
    PoseTrack,
    StateTrack,
    TwistTrack,
    WheelPair,
    YawRateTrack,
)
from fsm_calib.recording.checks import checked
from fsm_calib.recording.csv_table import Table, read_table
from fsm_calib.recording.inside import named_file
from fsm_calib.recording.manifest_schema import (
    BagManifest,
    ChannelSection,
    PoseSection,
    RobotSection,
    StateSection,
    WheelAngleSection,
    validate_manifest,
)
from fsm_calib.recording.named import Named
from fsm_calib.recording.recording import Finding, Recording, RobotFacts
from fsm_calib.recording.robot_files import read_robot_file, with_facts
from fsm_calib.recording.stamps import Stamps, read_stamps, refuse_long, zero_told, zeros_of
from fsm_calib.recording.yaml_places import read_yaml
from fsm_calib.types import FloatArray

if TYPE_CHECKING:
    from fsm_calib.recording.tag_poses import TagMap

NUMERIC = frozenset(
    ("duration", "left", "right", "v", "omega", "x", "y", "theta", "value", "dx", "dy", "dtheta", "lost")
)
"""Keys of a channel that name columns of numbers."""
ANGLES = {None: 1.0, "rad": 1.0, "deg": math.radians(1.0)}
"""rad per unit."""
RATES = {None: 1.0, "rad/s": 1.0, "deg/s": math.radians(1.0), "rpm": 2.0 * math.pi / 60.0}
"""rad/s per unit."""


def read_manifest(path: Path, tag_map: TagMap | None = None) -> Recording:
    """Read a manifest and its CSV files, or the bag that it names.

    Raises
    ------
    InputError
        One sentence with file and line for a mistake in the manifest or in a table; `ManyErrors` for several.
    """
    placed = read_yaml(path)
    manifest = validate_manifest(placed)
    facts = _robot_of(path, manifest.robot, placed.place(("robot", "urdf")))
    if isinstance(manifest, BagManifest):
        return _bag(path, manifest, facts, tag_map, placed.place(("bag",)))
    sections: dict[str, ChannelSection] = {n: s for n, s in manifest.channels if s is not None}
    tables = {n: _read_section(path, s, placed.place(("channels", n, "file"))) for n, s in sections.items()}
    clocks = {n: _stamps(s, tables[n]) for n, s in sections.items() if s.time is not None}
    zeros = zeros_of(clocks, intervals=len(clocks) < len(sections))
    channels: dict[str, Any] = {}
    sources: dict[str, Table] = {}
    for name, section in sections.items():
        if name in clocks:
            time, duration = clocks[name].since(zeros[name]), None
            refuse_long(time, tables[name].where(0))
        else:
            time, duration = _intervals_of(section, tables[name])
        slot = "twist" if name == "command" and section.unit == "twist" else name  # type: ignore[attr-defined]
        channels[slot] = _channel(name, section, tables[name], time, duration)
        sources[slot] = tables[name]
    zero = float(zeros.get("pose", min(zeros.values(), default=0)))
    recording = Recording(
        robot=facts,
        source=str(path),
        clock_zero=zero,
        checks=(*zero_told(zero), *_lost_told(sources)),
        **channels,
    )
    return checked(recording, sources, _stated(sections))


def _lost_told(sources: Mapping[str, Table]) -> list[Finding]:
    """Return a sentence for each channel with rows in which nothing was measured."""
    return [
        Finding(
            name,
            "lost",
            f"{table.lost} rows are empty or NaN: nothing was measured",
            "dropped",
            table.lost,
            0.0,
        )
        for name, table in sources.items()
        if table.lost
    ]


def _stated(sections: Mapping[str, ChannelSection]) -> set[str]:
    """Return the quantities whose unit a manifest states, by the names of `unit_guesses`."""
    settings = {name: section.model_fields_set for name, section in sections.items()}
    keys = {
        "wheel_rate": ("wheel_rate", "unit"),
        "wheel_angle": ("wheel_angle", "unit"),
        "wheel_speed": ("wheel_speed", "length_unit"),
        "yaw_rate": ("yaw_rate", "unit"),
        "twist.v": ("command", "length_unit"),
        "twist.omega": ("command", "angle_unit"),
        "pose.length": ("pose", "length_unit"),
        "pose.theta": ("pose", "angle_unit"),
    }
    return {name for name, (section, key) in keys.items() if key in settings.get(section, ())}


def _robot_of(path: Path, section: RobotSection, place: str) -> RobotFacts:
    """Return what the manifest says of the robot, and what the description that it names says besides."""
    facts = RobotFacts(**section.model_dump(exclude={"urdf"}))
    if section.urdf is None:
        return facts
    return with_facts(facts, read_robot_file(named_file(path, section.urdf, place)))


def _bag(
    path: Path, manifest: BagManifest, facts: RobotFacts, tag_map: TagMap | None, place: str
) -> Recording:
    """Read the bag of a manifest, its topics as named there."""
    # bags need a heavy library that tables do not
    from fsm_calib.recording.bags import read_bag

    bag = named_file(path, manifest.bag, place)
    if not bag.exists():
        raise InputError(
            f"the bag {manifest.bag!r} does not exist",
            where=place,
            cure="Names are relative to the manifest.",
        )
    part = manifest.channels
    wheels = part.wheel_angle or part.wheel_rate or part.wheel_speed
    named = Named(
        command=part.command.topic if part.command else None,
        pose=part.pose.topic if part.pose else None,
        wheels=wheels.topic if wheels else None,
        yaw_rate=part.yaw_rate.topic if part.yaw_rate else None,
        state=part.state.topic if part.state else None,
        joints=(wheels.left, wheels.right) if wheels and wheels.left and wheels.right else None,
        stamp=wheels.stamp if wheels else None,
        stale_after=part.command.stale_after if part.command else None,
        robot=facts,
    )
    return replace(read_bag(bag, tag_map, named), source=str(path))


def _read_section(manifest: Path, section: ChannelSection, place: str) -> Table:
    numeric = [v for k, v in section if k in NUMERIC and isinstance(v, str)]
    numeric += list(getattr(section, "quaternion", None) or ())
    text = [section.state] if isinstance(section, StateSection) else []
    text += [section.time] if section.time is not None else []
    file = named_file(manifest, section.file, place)
    if not file.is_file():
        raise InputError(
            f"the file {section.file!r} does not exist",
            where=place,
            cure="Names are relative to the manifest.",
        )
    seen = [name for name in numeric if name != section.duration] if isinstance(section, PoseSection) else []
    return read_table(file, list(dict.fromkeys(numeric)), text, seen, section.only)


def _stamps(section: ChannelSection, table: Table) -> Stamps:
    """Return a channel's times as written; refuse what is no time."""
    cells = table.words[str(section.time)]
    try:
        return read_stamps(cells, section.time_unit)
    except ValueError as error:
        row = int(error.args[0])
        raise InputError(
            f"column {section.time!r} holds {cells[row][:40]!r}; expected a finite number or an ISO 8601 time",
            where=table.where(row),
        ) from error


def _intervals_of(section: ChannelSection, table: Table) -> tuple[FloatArray, FloatArray]:
    """Return start and duration [s] of a channel's intervals; refuse those that do not last."""
    duration = table.numbers[str(section.duration)] * (section.time_unit or 1.0)
    if (duration <= 0).any():
        row = int(np.argmax(duration <= 0))
        raise InputError(
            f"the interval lasts {duration[row]:g} s; expected more than 0", where=table.where(row)
        )
    return np.concatenate([[0.0], np.cumsum(duration)[:-1]]), duration


def _channel(name: str, section: Any, table: Table, time: FloatArray, duration: FloatArray | None) -> Channel:
    def column(key: str, scale: float = 1.0) -> FloatArray:
        return table.numbers[getattr(section, key)] * scale

    metre = section.length_unit or 1.0
    if name == "command":
        lost = None if section.lost is None else column("lost")
    if name == "command" and section.unit == "twist":
        v, omega = column("v", metre), column("omega", ANGLES[section.angle_unit])
        return TwistTrack(time, v, omega, section.stale_after, lost)
    if name == "command":
        one = 1.0 / (section.full or 1.0) if section.unit == "normalized" else RATES[section.unit]
        left, right = (column(side, one) for side in ("left", "right"))
        kind: CommandUnit = "normalized" if section.unit == "normalized" else "rad/s"
        return CommandTrack(time, left, right, kind, section.stale_after, lost)
    if name == "pose":
        return PoseTrack(time, column("x", metre), column("y", metre), _heading(section, table))
    if name == "wheel_angle":
        scale, unit, step = _angle_unit(section)
        return WheelPair(time, column("left", scale), column("right", scale), unit, step, duration)
    if name in ("wheel_rate", "wheel_speed"):
        scale = metre if name == "wheel_speed" else RATES[section.unit]
        unit = "m/s" if name == "wheel_speed" else "rad/s"
        return WheelPair(
            time, column("left", scale), column("right", scale), unit, 0.0, duration, section.stamp
        )
    if name == "yaw_rate":
        return YawRateTrack(time, column("value", RATES[section.unit]), duration)
    if name == "displacement":
        length = duration if duration is not None else _intervals(time)
        return DisplacementTrack(
            time, length, column("dx", metre), column("dy", metre), column("dtheta"), section.of
        )
    return StateTrack(time, table.words[section.state])


def _heading(section: PoseSection, table: Table) -> FloatArray:
    """Return headings [rad], of a column or of a quaternion's four; NaN where none is named."""
    if section.quaternion is not None:
        x, y, z, w = (table.numbers[name] for name in section.quaternion)
        return np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    if section.theta is None:
        return np.full(len(table.lines), math.nan)
    return table.numbers[section.theta] * ANGLES[section.angle_unit]


def _angle_unit(section: WheelAngleSection) -> tuple[float, str, float]:
    """Return scale, unit and resolution of wheel angles."""
    if section.unit in ("rad", "deg"):
        return (1.0 if section.unit == "rad" else math.radians(1.0)), "rad", 0.0
    if section.ticks_per_turn is None:
        return 1.0, "tick", 1.0
    return 2.0 * math.pi / section.ticks_per_turn, "rad", 2.0 * math.pi / section.ticks_per_turn


def _intervals(time: FloatArray) -> FloatArray:
    """Return the time to the next row [s]; the last row lasts as long as the one before."""
    if len(time) < 2:
        return np.ones(len(time))
    step = np.diff(time)
    return np.append(step, step[-1])
