"""Effects from outside this package: Python files that a user names, and installed packages that announce them.

A file holds `EFFECT` or a tuple `EFFECTS`, as the modules of this package do. A package announces a module (or an
effect, or a tuple of them) under the entry-point group ``fsm_calib.effects``. Files are named by ``--effects`` or
`add_effects`; the environment variable ``FSM_CALIB_EFFECTS`` carries their paths to the processes that a command
starts. A file is code and runs with the user's rights: no folder is searched, only what is named is loaded.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.python_file import module_of, unloadable
from fsm_calib.world2d.effects.effect import Effect

GROUP = "fsm_calib.effects"
"""Entry-point group of packages that bring effects."""
VARIABLE = "FSM_CALIB_EFFECTS"
"""Environment variable with the files that are named, absolute, separated as in PATH."""


def named_files() -> tuple[Path, ...]:
    """Return the files that are named for this process and those it starts."""
    return tuple(Path(part) for part in os.environ.get(VARIABLE, "").split(os.pathsep) if part)


def name_files(files: Iterable[Path]) -> None:
    """Name files for this process and those it starts, beside those that are named already."""
    paths = dict.fromkeys([*named_files(), *(file.resolve() for file in files)])
    os.environ[VARIABLE] = os.pathsep.join(map(str, paths))


def outside_effects() -> Iterator[Effect]:
    """Yield the effects of installed packages, then those of the named files.

    Raises
    ------
    InputError
        A file or a package cannot be loaded, or holds no effect.
    """
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        where = f"entry point {point.name!r} of {GROUP}"
        try:
            loaded = point.load()
        except Exception as error:  # any code may raise anything
            raise unloadable(error, where, "Mend or uninstall the package.") from error
        yield from _effects_in(loaded, where)
    for file in named_files():
        yield from effects_of(file)


def effects_of(file: Path) -> list[Effect]:
    """Return the effects that a Python file declares; see `outside_effects` for the errors."""
    return _effects_in(module_of(file, declares="EFFECT"), str(file))


def _effects_in(loaded: Any, where: str) -> list[Effect]:
    """Return the effects of a module, or of a value that is one or several."""
    if isinstance(loaded, ModuleType):
        loaded = getattr(loaded, "EFFECTS", None) or getattr(loaded, "EFFECT", None)
    found = [loaded] if isinstance(loaded, Effect) else list(loaded or ())
    if not found or not all(isinstance(effect, Effect) for effect in found):
        raise InputError(
            "declares no effect",
            where=where,
            cure="Give it EFFECT = Effect(...), or a tuple EFFECTS of them.",
        )
    return found
