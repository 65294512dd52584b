"""Where a run's files go: never over those of an earlier run, unless it is said so."""

from __future__ import annotations

from itertools import count
from pathlib import Path

from fsm_calib.errors import InputError

DEFAULT_OUT = Path("out")
"""Where a run leaves its files when nothing else is said; `out-2`, `out-3`, ... when a run is there already."""


def run_directory(out: Path | None, resume: Path | None, *, overwrite: bool) -> Path:
    """Return the directory of a run, from the three options that tell it.

    Raises
    ------
    InputError
        The options contradict one another, or the directory holds an earlier run.
    """
    if resume is not None and out is not None and out != resume:
        raise InputError(
            "--out and --resume name two directories", where="--out", cure="Give --resume alone."
        )
    if resume is not None and overwrite:
        cure = "Give --resume to go on with the run, or --out with --overwrite to begin again."
        raise InputError("--resume keeps what --overwrite removes", where="--overwrite", cure=cure)
    if resume is not None:
        return resume
    if overwrite:
        return out or DEFAULT_OUT
    if out is None:
        return _next_free(DEFAULT_OUT)
    if found := _held(out):
        cure = f"Give another directory, --resume {out} to go on with that run, or --overwrite to replace its files."
        raise InputError(f"holds an earlier run ({', '.join(found)})", where=str(out), cure=cure)
    return out


def _held(directory: Path) -> list[str]:
    """Return the files and folders of an earlier run that a new one would replace."""
    from fsm_calib.runner.investigation.files import DRIVES, RESULT
    from fsm_calib.runner.run import RUN_FILES, RUN_FOLDERS

    if directory.exists() and not directory.is_dir():
        raise InputError("is a file", where=str(directory), cure="Give a directory.")
    return [name for name in (*RUN_FILES, *RUN_FOLDERS, RESULT, DRIVES) if (directory / name).exists()]


def _next_free(wanted: Path) -> Path:
    """Return `wanted`, or the first of `wanted-2`, `wanted-3`, ... that holds no run."""
    names = (wanted if number == 1 else wanted.with_name(f"{wanted.name}-{number}") for number in count(1))
    return next(path for path in names if not path.is_file() and not _held(path))
