"""A machine from a Python file that a user names (docs/own-machine.md)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.python_file import module_of
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.validate import check

NAME = "MACHINE"


def machinery_from(file: Path) -> Machinery:
    """Return the machine that a Python file declares, its tables checked.

    The file is code and runs with the user's rights.

    Raises
    ------
    InputError
        The file cannot be loaded or declares no machine; `ManyErrors` when the tables are not sound.
    """
    found = getattr(module_of(file.resolve(), declares=NAME), NAME, None)
    if not isinstance(found, Machinery):
        cure = f"Give it {NAME} = Machinery(root, guards, actions, contract, ...); docs/own-machine.md has a whole one."
        raise InputError("declares no machine", where=str(file), cure=cure)
    check(found)
    return replace(found, home=found.home or file.name, limits_home=found.limits_home or file.name)
