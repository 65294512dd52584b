"""The recordings that a command was given: the options that read them, and what is refused or said before any work."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from fsm_calib.commands.files import print_findings

if TYPE_CHECKING:
    from fsm_calib.recording.recording import Recording

TagMapFile = Annotated[
    str | None,
    typer.Option("--tag-map", metavar="FILE", help="Places of tags, for bags without poses."),
]


def recordings_given(
    paths: Sequence[str], holdout: Sequence[str] = (), *, tag_map: str | None = None
) -> tuple[list[Recording], list[Recording]]:
    """Return the recordings to fit and those to judge on; tell on standard error what was found in them.

    Raises
    ------
    InputError
        One cannot be read, or is both fitted and held out.
    """
    from fsm_calib.recording import read_recording
    from fsm_calib.recording.alike import refuse_shared, robot_warnings

    fitted = [read_recording(path, tag_map) for path in paths]
    new = [read_recording(path, tag_map) for path in holdout]
    refuse_shared(fitted, new)
    print_findings(fitted + new)
    for sentence in robot_warnings(fitted + new):
        typer.echo(f"warning: {sentence}", err=True)
    return fitted, new
