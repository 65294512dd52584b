"""Where recordings lie: which file is a manifest, a bag or a table, and which manifest a folder holds."""

from __future__ import annotations

from pathlib import Path

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
BAG_FOLDER = "metadata.yaml"
"""What makes a folder a ROS 2 bag."""
MANIFEST_SUFFIXES = (".yaml", ".yml")
MANIFEST_NAME = "recording.yaml"
MANIFEST_END = ".recording.yaml"
LONGEST_HEAD = 4096
"""Characters in which a manifest names its format."""


def is_manifest(path: Path) -> bool:
    """Return whether a file says that it is a recording's manifest."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            head = stream.read(LONGEST_HEAD)
    except (OSError, ValueError):
        return False
    return any(line.startswith("format:") and "fsm-calib/recording" in line for line in head.splitlines())


def is_table(path: Path) -> bool:
    """Return whether a file is a table by its name: numbers, of which only a manifest says what they are."""
    return path.name.lower().removesuffix(".gz").endswith((".csv", ".tsv", ".txt"))


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag: a file by its name, a folder by what it holds."""
    return (path / BAG_FOLDER).is_file() if path.is_dir() else path.is_file() and path.suffix in BAG_SUFFIXES


def manifest_in(folder: Path) -> Path | None:
    """Return the manifest that a folder stands for: ``recording.yaml``, or its only one where no bag lies beside it."""
    if (folder / MANIFEST_NAME).is_file():
        return folder / MANIFEST_NAME
    held = recordings_in(folder)
    return held[0] if len(held) == 1 and held[0].suffix in MANIFEST_SUFFIXES else None


def recordings_in(folder: Path) -> list[Path]:
    """Return the bags and manifests that lie in a folder, in order."""
    return [path for path in sorted(folder.iterdir()) if is_bag_or_manifest(path)]


def is_bag_or_manifest(path: Path) -> bool:
    """Return whether a path is a bag, or a manifest by its name or by what it says."""
    if is_bag(path):
        return True
    by_name = path.name.endswith((MANIFEST_END, MANIFEST_NAME))
    return path.is_file() and (by_name or (path.suffix in MANIFEST_SUFFIXES and is_manifest(path)))
