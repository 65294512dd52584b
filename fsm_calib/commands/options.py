"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from fsm_calib.statechart.machinery import Machinery


def _add_effects(files: list[Path] | None) -> list[Path] | None:
    """Add the effects of the files to the catalogue before anything asks for it."""
    if files:
        from fsm_calib.world2d.effects import add_effects

        add_effects(files)
    return files


ScenarioArgument = Annotated[
    Path,
    typer.Argument(
        metavar="SCENARIO", help="A scenario file, or the name of one that is shipped.", show_default=False
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Where files go (default: the next free of out, out-2, ...)."),
]
ResumeOption = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Go on with what was begun in this directory.")
]
OverwriteOption = Annotated[
    bool, typer.Option("--overwrite", help="Replace the files of an earlier run in the directory.")
]
SeedOption = Annotated[int | None, typer.Option(metavar="N", help="Another seed than the scenario's.")]
RobotOption = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="A real robot instead: ros1:// or dtps://HOST[:PORT]/VEHICLE."),
]
YesOption = Annotated[bool, typer.Option("--yes", help="Do not ask before a real robot's wheels turn.")]
JsonOption = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", help="Write the result as JSON; - for standard output."),
]

MachinesOption = Annotated[
    Path | None,
    typer.Option(
        "--machines",
        metavar="FILE.py",
        help="Take the machine that this file declares in place of the calibration (docs/own-machine.md).",
        show_default=False,
    ),
]
"""A machine from outside; `machinery_of` reads it."""


def machinery_of(file: Path | None) -> Machinery:
    """Return the machine that a file declares, or the calibration when there is none; its tables are sound.

    Raises
    ------
    InputError
        The file cannot be loaded or declares no machine, or a table is not sound.
    """
    from fsm_calib.machines.calibration import CALIBRATION
    from fsm_calib.statechart.from_file import machinery_from
    from fsm_calib.statechart.validate import check

    if file is not None:
        return machinery_from(file)
    check(CALIBRATION)
    return CALIBRATION


JobsOption = Annotated[
    int | None,
    typer.Option("--jobs", metavar="N", help="Robots at a time (default: all cores).", show_default=False),
]
BackendOption = Annotated[
    str, typer.Option("--backend", metavar="NAME", help="loky, threading, dask or ray.")
]
AddressOption = Annotated[
    str | None,
    typer.Option(
        "--address", metavar="ADDRESS", help="Scheduler of a Dask or Ray cluster.", show_default=False
    ),
]
"""Where many robots are worked on; `study.backends.crew_of` checks them."""

EffectsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE.py",
        help="Add the effects that this file declares (docs/own-effect.md); repeatable.",
        callback=_add_effects,
        show_default=False,
    ),
]
"""Effects from outside; the catalogue has them when the command's body begins."""
