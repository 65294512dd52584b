"""What commands share about files: places refused before the work, files written after it, findings told."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from fsm_calib.errors import InputError, shown, shown_lines
from fsm_calib.journal import write_atomically

if TYPE_CHECKING:
    from fsm_calib.recording.recording import Recording

STANDARD_OUTPUT = Path("-")


def check_places(*files: Path | None) -> None:
    """Refuse files that cannot be written, before the work rather than after it.

    None and `-`, standard output, are no files.

    Raises
    ------
    InputError
        The folder is missing, is no folder or may not be written to, or the file is a folder.
    """
    for path in files:
        if path is None or path == STANDARD_OUTPUT:
            continue
        folder = path.parent
        if not folder.is_dir():
            raise InputError(
                "cannot be written: no such folder", where=str(path), cure=f"Create {folder} first."
            )
        if path.is_dir() or not os.access(path if path.exists() else folder, os.W_OK):
            raise InputError("cannot be written", where=str(path), cure="Give a file that may be written.")


def check_folders(*folders: Path | None) -> None:
    """Refuse folders that cannot be made, before the work rather than after it; None is no folder.

    Whether a folder can be made is told by making it; what was made is taken away again.

    Raises
    ------
    InputError
        A folder cannot be made, or may not be written to.
    """
    for folder in folders:
        if folder is None:
            continue
        made = [place for place in (folder, *folder.parents) if not place.exists()]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"no folder can be made here: {error.strerror}", where=str(folder)) from error
        finally:
            for place in made:
                if place.is_dir():
                    place.rmdir()
        if folder.exists() and not os.access(folder, os.W_OK):
            raise InputError(
                "cannot be written", where=str(folder), cure="Give a folder that may be written to."
            )


def write_file(path: Path, text: str) -> None:
    """Write a text file whole, or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    try:
        write_atomically(path, text.encode())
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", where=str(path)) from error


def tell_result(plain: Mapping[str, Any], words: str, json_file: Path | None) -> None:
    """Print a result in words and write it as JSON; with `-` for the file print the JSON instead."""
    if json_file is None:
        typer.echo(shown_lines(words))
        return
    text = json.dumps(plain, indent=1, allow_nan=False)
    if json_file == STANDARD_OUTPUT:
        typer.echo(text)
        return
    typer.echo(shown_lines(words))
    write_file(json_file, text + "\n")


def print_findings(recordings: Iterable[Recording]) -> None:
    """Print what the recordings' checks found, to standard error."""
    for recording in recordings:
        for finding in recording.checks:
            typer.echo(shown(f"{recording.source}: {finding}"), err=True)
