"""`read_recording`: whatever a path points at, as a `Recording`."""

from __future__ import annotations

from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.manifest import read_manifest
from fsm_calib.recording.recording import Recording

MANIFEST_SUFFIXES = (".yaml", ".yml")
BAG_SUFFIXES = (".bag", ".mcap", ".db3")
MANIFEST_NAME = "recording.yaml"
MANIFEST_END = ".recording.yaml"


def read_recording(path: str | Path, tag_map: str | Path | None = None) -> Recording:
    """Read a manifest, a folder that holds ``recording.yaml``, a ROS 1 ``.bag``, a ROS 2 bag folder or a
    ``.mcap``; NAME stands for ``NAME.recording.yaml``.

    `tag_map` names a YAML file with the places of tags, for bags that hold tag detections and no poses.

    Raises
    ------
    InputError
        Nothing is there, or it is none of these, or it is damaged; the sentence says file and line.
    """
    path = Path(path)
    named = path.with_name(path.name + MANIFEST_END) if path.name else path
    if not path.exists() and named.is_file():
        path = named
    if not path.exists():
        raise InputError("the recording does not exist", where=str(path))
    if path.is_dir() and (path / MANIFEST_NAME).is_file():
        path = path / MANIFEST_NAME
    if path.is_file() and path.suffix in MANIFEST_SUFFIXES and path.name != "metadata.yaml":
        return read_manifest(path)
    if path.suffix in BAG_SUFFIXES or (path.is_dir() and (path / "metadata.yaml").is_file()):
        # bags need a heavy library that manifests do not
        from fsm_calib.recording.bags import read_bag
        from fsm_calib.recording.tag_poses import read_tag_map

        return read_bag(path, None if tag_map is None else read_tag_map(Path(tag_map)))
    raise InputError(
        "not a recording: expected a manifest (.yaml), a .bag, a .mcap or a bag folder", where=str(path)
    )
