"""Manifests of recordings: `fsm-calib recording init` writes a first draft, `fsm-calib validate` checks one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fsm_calib.commands.files import check_places, print_findings, write_file


def init_command(
    files: Annotated[list[Path], typer.Argument(metavar="BAG|CSV", help="One bag, or CSV files.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The manifest; default NAME.recording.yaml.")
    ] = None,
) -> None:
    """Write a manifest with its guesses and comments, to be looked through and completed."""
    from fsm_calib.errors import InputError
    from fsm_calib.recording.draft import draft_of_bag, draft_of_tables
    from fsm_calib.recording.places import BAG_FOLDER, MANIFEST_END, is_bag

    first = files[0]
    for file in files:
        if not file.exists():
            raise InputError("the file does not exist", where=str(file))
    target = out or first.with_name(first.name.split(".")[0] + MANIFEST_END)
    if target.exists():
        raise InputError(
            "the manifest exists already", where=str(target), cure="Remove it, or name another with --out."
        )
    check_places(target)
    bag = is_bag(first)
    if first.is_dir() and not bag:
        raise InputError(
            f"a folder without {BAG_FOLDER} is no ROS 2 bag",
            where=str(first),
            cure="Give a bag, or CSV files.",
        )
    if bag and len(files) > 1:
        raise InputError("a manifest is of one bag", where=str(files[1]), cure="Call it once for each bag.")
    beside = target.parent
    text = draft_of_bag(first, beside) if bag else draft_of_tables(files, beside)
    write_file(target, text)
    typer.echo(text, nl=False)
    typer.echo(f"written to {target}; look it through, then: fsm-calib validate {target}", err=True)


def is_recording(path: Path) -> bool:
    """Return whether a file is a recording's: a manifest by its first lines, a bag or a table by its name."""
    from fsm_calib.recording.places import is_bag, is_manifest, is_table

    return path.is_file() and (is_manifest(path) or is_bag(path) or is_table(path))


def validate_manifest_command(path: Path) -> None:
    """Read a manifest with everything that it names, and say what is in it.

    Raises
    ------
    InputError
        Something is wrong; `ManyErrors` for several mistakes in the manifest.
    """
    from fsm_calib.recording import read_recording
    from fsm_calib.recording.recording import called

    recording = read_recording(path)
    print_findings([recording])
    held = ", ".join(f"{called(name)} ({len(channel)} rows)" for name, channel in recording.channels.items())
    start, end = recording.span
    typer.echo(f"{path}: valid ({recording.robot.name}, {end - start:.1f} s: {held})")
