"""`read_recording`: whatever a path points at, as a `Recording`."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from fsm_calib.errors import InputError
from fsm_calib.recording.manifest import read_manifest
from fsm_calib.recording.named import NOTHING, Named
from fsm_calib.recording.places import (
    BAG_FOLDER,
    BAG_SUFFIXES,
    MANIFEST_END,
    MANIFEST_SUFFIXES,
    is_bag,
    is_table,
    manifest_in,
    recordings_in,
)
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.robot_files import with_facts

if TYPE_CHECKING:
    from fsm_calib.recording.tag_poses import TagMap

TABLES = "A table needs a manifest that says what its columns are: fsm-calib recording init FILE.csv... writes one."


def read_recording(path: str | Path, tag_map: str | Path | None = None, named: Named = NOTHING) -> Recording:
    """Read a manifest, a folder that holds one (``recording.yaml``, or a single one of any name), a ROS 1 ``.bag``, a
    ROS 2 bag folder or a ``.mcap``; NAME stands for ``NAME.recording.yaml``.

    `tag_map` names a YAML file with the places of tags, for bags that hold tag detections and no poses; `named` says
    which topics of a bag to read, and facts of the robot that the recording itself does not state.

    Raises
    ------
    InputError
        Nothing is there, or it is none of these, or it is damaged; the sentence says file and line.
    """
    path = Path(path)
    full = path.with_name(path.name + MANIFEST_END) if path.name else path
    if not path.exists() and full.is_file():
        path = full
    if not path.exists():
        raise InputError("the recording does not exist", where=str(path))
    if path.is_dir():
        path = manifest_in(path) or path
    if path.is_file() and path.suffix in MANIFEST_SUFFIXES and path.name != BAG_FOLDER:
        if named.any_topic:
            raise InputError(
                "topics are named for a manifest, which names its channels itself",
                where=str(path),
                cure="Give the bag in place of the manifest, or name the topics in the manifest.",
            )
        recording = read_manifest(path, _tags(tag_map))
        robot = recording.robot if named.robot is None else with_facts(recording.robot, named.robot)
        return dataclasses.replace(recording, robot=robot)
    if path.suffix in BAG_SUFFIXES or is_bag(path):
        # bags need a heavy library that manifests do not
        from fsm_calib.recording.bags import read_bag

        return read_bag(path, _tags(tag_map), named)
    cure = TABLES if is_table(path) else _inside(path) if path.is_dir() else ""
    raise InputError(
        "not a recording: expected a manifest (.yaml), a .bag, a .mcap or a bag folder",
        where=str(path),
        cure=cure,
    )


def _inside(folder: Path) -> str:
    """Return a sentence with some of the recordings that a folder holds; empty where it holds none."""
    found = [path.name for path in recordings_in(folder)]
    return f"It holds {', '.join(found[:3])}{' ...' if len(found) > 3 else ''}: name those." if found else ""


def _tags(tag_map: str | Path | None) -> TagMap | None:
    if tag_map is None:
        return None
    from fsm_calib.recording.tag_poses import read_tag_map

    return read_tag_map(Path(tag_map))
