"""`fsm-calib diagrams`, and what `validate` says of a machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fsm_calib.commands.options import MachinesOption, machinery_of
from fsm_calib.errors import InputError, ManyErrors

if TYPE_CHECKING:
    from fsm_calib.statechart.machinery import Machinery


def register(app: typer.Typer) -> None:
    """Add `diagrams` to the command line."""
    app.command()(diagrams)


def diagrams(
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; fail when a diagram is stale.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Where the diagrams are (default: diagrams, or NAME-diagrams for a FILE.py).",
            show_default=False,
        ),
    ] = None,
    machines: MachinesOption = None,
) -> None:
    """Draw the machines: Mermaid text, DOT text and a picture of each, from their tables."""
    from fsm_calib.statechart.diagrams import stale_diagrams, write_diagrams

    folder = out or Path("diagrams" if machines is None else f"{machines.stem}-diagrams")
    drawn = _drawn(folder, machines)
    if not check:
        for place, machinery in drawn.items():
            write_diagrams(machinery, place)
        typer.echo(f"diagrams written to {folder}/")
        return
    stale = [str(path) for place, machinery in drawn.items() for path in stale_diagrams(machinery, place)]
    if stale:
        again = "fsm-calib diagrams" if machines is None else f"fsm-calib diagrams --machines {machines}"
        typer.echo(f"stale: {', '.join(stale)}. Run: {again}", err=True)
        raise typer.Exit(1)
    typer.echo(f"{folder}/ is current")


def _drawn(folder: Path, machines: Path | None) -> dict[Path, Machinery]:
    """Return what is drawn where: the machine of the file, or the project's own."""
    machinery = machinery_of(machines)
    if machines is not None:
        return {folder: machinery}
    from fsm_calib.machines.investigate import INVESTIGATE
    from fsm_calib.statechart.validate import check

    check(INVESTIGATE)
    return {folder: machinery, folder / INVESTIGATE.root.name: INVESTIGATE}


def tell_checked(machinery: Machinery, file: Path) -> None:
    """Check a machine in every configuration that it can reach, and print how many those are.

    Raises
    ------
    ManyErrors
        With everything that is wrong.
    """
    from fsm_calib.statechart.exhaustive import check_exhaustively

    findings = check_exhaustively(machinery)
    if findings.problems:
        raise ManyErrors(InputError(problem.rstrip("."), where=str(file)) for problem in findings.problems)
    typer.echo(
        f"{file}: valid ({machinery.root.name}: {len(machinery.transitions)} transitions; all are taken, and "
        f"every run ends, in {findings.configurations} configurations with {findings.outcomes} outcomes)"
    )
