"""The journal: one JSON line per event, and the checkpoint from which a killed run goes on.

A run is a chain of events: an activity ran, its outcome fired a transition. Each event is one line of
``journal.jsonl`` (JSON Lines, https://jsonlines.org), keys sorted, so that two runs of one seed are equal
byte for byte; nothing in it depends on wall time. After each event ``checkpoint.json`` is replaced whole, so
that it is either the old or the new one, never half of one; it holds the length of the journal that it
belongs to. On `--resume` the journal is cut to that length: a torn last line, or a line whose checkpoint was
never written, goes, and its activity runs again.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from fsm_calib.errors import DataError, InputError

JOURNAL_NAME = "journal.jsonl"
CHECKPOINT_NAME = "checkpoint.json"
SCHEMA = "fsm-calib/journal@1"


def plain(value: Any) -> Any:
    """Return `value` as plain JSON values: numpy values as numbers and lists, nan and inf as null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def encode(record: Mapping[str, Any]) -> bytes:
    """Return `record` as one line of JSON with sorted keys; floats keep every digit."""
    try:
        text = _ENCODER.encode(record)
    except ValueError:  # a nan or an infinity, which JSON has not
        text = _ENCODER.encode(plain(record))
    return text.encode() + b"\n"


def _convert(value: Any) -> Any:
    """Return what the encoder does not know as something that it knows."""
    if isinstance(value, Mapping) or hasattr(value, "tolist"):
        return plain(value)
    raise TypeError(f"{type(value).__name__} cannot be journalled")


_ENCODER = json.JSONEncoder(
    sort_keys=True, allow_nan=False, ensure_ascii=False, separators=(",", ":"), default=_convert
)


class Journal:
    """Writes ``journal.jsonl`` and ``checkpoint.json`` in a directory.

    Parameters
    ----------
    directory : Path
        Where the files are; must exist.
    length : int
        Bytes of an existing journal that are kept; the rest is cut off. Zero starts a new one.
    """

    def __init__(self, directory: Path, length: int = 0) -> None:
        self.directory = directory
        path = directory / JOURNAL_NAME
        path.touch()
        self._file: BinaryIO = path.open("r+b")
        self._file.truncate(length)
        self._file.seek(length)

    @property
    def length(self) -> int:
        """Bytes written so far."""
        return self._file.tell()

    def append(self, record: Mapping[str, Any]) -> None:
        """Add one event and hand it to the operating system, so that a killed process loses nothing."""
        self._file.write(encode(record))
        self._file.flush()

    def checkpoint(self, state: Mapping[str, Any], *, durable: bool = False) -> None:
        """Replace the checkpoint by `state`; `durable` also survives a power cut (10 ms of disk)."""
        if durable:
            os.fsync(self._file.fileno())
        content = {"schema": SCHEMA, "journal_length": self.length, **state}
        write_atomically(self.directory / CHECKPOINT_NAME, encode(content), durable=durable)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def write_atomically(path: Path, content: bytes, *, durable: bool = False) -> None:
    """Write a file so that a reader, or a crash, sees the old content or the new, never a part."""
    temporary = path.with_name(f".{path.name}.tmp")
    with temporary.open("wb") as file:
        file.write(content)
        if durable:
            file.flush()
            os.fsync(file.fileno())
    os.replace(temporary, path)


def read_checkpoint(directory: Path) -> dict[str, Any] | None:
    """Return the checkpoint of a run, or None when the run was killed before its first one.

    Raises
    ------
    InputError
        The directory holds no run.
    DataError
        The checkpoint is damaged or of another version.
    """
    if not directory.is_dir():
        raise InputError("no such directory", where=str(directory), cure="Give the --out directory of a run.")
    path = directory / CHECKPOINT_NAME
    if not path.exists():
        return None
    try:
        state = json.loads(path.read_bytes())
    except ValueError as error:
        cure = "Remove it and run again without --resume."
        raise DataError(f"{path} is damaged: {error}", cure=cure) from error
    if not isinstance(state, dict) or state.get("schema") != SCHEMA:
        raise DataError(f"{path} is not of the form {SCHEMA}", cure="Run again without --resume.")
    return state


def read_journal(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the events of a journal; a torn last line is left out.

    Raises
    ------
    DataError
        A line other than the last is damaged.
    """
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                return
            try:
                yield json.loads(line)
            except ValueError as error:
                problem = f"{path}:{number}: not a line of JSON"
                raise DataError(problem, cure="Run again without --resume.") from error
