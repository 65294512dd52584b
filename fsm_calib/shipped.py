"""Finds the files that come with the program: scenarios and diagrams, from a wheel or from the source tree.

A wheel holds both below `fsm_calib/_shipped/` (see `setup.py`); in the source tree they are at the top of the house.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fsm_calib.errors import DataError, UnknownNameError

PACKAGE = Path(__file__).parent
SUFFIX = ".yaml"


def shipped_folder(name: str) -> Path:
    """Return the folder `scenarios` or `diagrams` that came with the program.

    Raises
    ------
    DataError
        The installation is without it.
    """
    for folder in (PACKAGE / "_shipped" / name, PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise DataError(f"this installation has no folder {name}", cure="Install fsm-calib again.")


def scenario_names() -> list[str]:
    """Return the names of the shipped scenarios and studies, in order."""
    return sorted(path.stem for path in _scenario_files())


def _scenario_files() -> Iterator[Path]:
    yield from shipped_folder("scenarios").glob(f"*{SUFFIX}")


def scenario_path(given: Path) -> Path:
    """Return the file that is meant: one that exists, or the shipped scenario of that name.

    Only a bare name (`full_calibration`, with or without `.yaml`) is looked up; a path is a path.

    Raises
    ------
    UnknownNameError
        A bare name that is neither a file nor shipped, with the nearest names.
    """
    if given.exists() or given.parent != Path() or given.suffix not in ("", SUFFIX):
        return given
    for path in _scenario_files():
        if path.stem == given.stem:
            return path
    if given.suffix:
        return given
    raise UnknownNameError("scenario", str(given), scenario_names())
