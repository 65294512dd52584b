"""The journal: one JSON line per event, and the checkpoint from which a killed run goes on.

A run is a chain of events: an activity ran, its outcome fired a transition. Each event is one line of
``journal.jsonl`` (JSON Lines, https://jsonlines.org), keys sorted, so that two runs of one seed are equal
byte for byte; nothing in it depends on wall time. After each event ``checkpoint.json`` is replaced whole, so
that it is either the old or the new one, never half of one; it holds the length and the chain of the journal that it
belongs to, and the one before it stays as ``checkpoint.previous.json``. On `--resume` the journal is cut to that
length: a torn last line, or a line whose checkpoint was never written, goes, and its activity runs again.

Journal and checkpoint are sealed (`fsm_calib.sealed`): a run whose files had any byte changed or lost is not gone on
with, since what follows from a wrong number looks like a result.
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from fsm_calib.errors import DataError, InputError
from fsm_calib.sealed import START, sealed, unsealed

JOURNAL_NAME = "journal.jsonl"
CHECKPOINT_NAME = "checkpoint.json"
PREVIOUS_NAME = "checkpoint.previous.json"
SCHEMA = "fsm-calib/journal@2"
START_AGAIN = "Start again: the same command without --resume."


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
    chain : str
        The journal's chain at that length (`read_checkpoint` gives both).
    """

    def __init__(self, directory: Path, length: int = 0, chain: str = START) -> None:
        self.directory, self._chain = directory, chain
        for name in (CHECKPOINT_NAME, PREVIOUS_NAME):  # a killed process may have left what it was writing
            _temporary(directory / name).unlink(missing_ok=True)
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
        line, self._chain = sealed(encode(record), self._chain)
        self._file.write(line)
        self._file.flush()

    def checkpoint(self, state: Mapping[str, Any], *, durable: bool = False) -> None:
        """Replace the checkpoint by `state`; `durable` also survives a power cut (10 ms of disk)."""
        if durable:
            os.fsync(self._file.fileno())
        content = {"schema": SCHEMA, "journal_length": self.length, "journal_chain": self._chain, **state}
        path = self.directory / CHECKPOINT_NAME
        if path.exists():
            previous = self.directory / PREVIOUS_NAME
            kept = _temporary(previous)
            kept.unlink(missing_ok=True)
            try:
                os.link(path, kept)
            except OSError:  # a file system without links
                shutil.copyfile(path, kept)
            os.replace(kept, previous)
            kept.unlink(missing_ok=True)  # two names of one file, as a kill may leave them, are not replaced
        write_atomically(path, sealed(encode(content))[0], durable=durable)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def write_atomically(path: Path, content: bytes, *, durable: bool = False) -> None:
    """Write a file so that a reader, or a crash, sees the old content or the new, never a part.

    A place that is no file (a pipe, a device) is written to as it is; a link is followed.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    path = path.resolve() if path.is_symlink() else path
    temporary = _temporary(path)
    try:
        with temporary.open("wb") as file:
            file.write(content)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _temporary(path: Path) -> Path:
    """Return where a file is written before it takes its name."""
    return path.with_name(f".{path.name}.tmp")


def read_checkpoint(directory: Path) -> dict[str, Any] | None:
    """Return the checkpoint of a run, or None when the run was killed before its first one.

    Raises
    ------
    InputError
        The directory holds no run.
    DataError
        The checkpoint or the journal up to it is damaged, cut, or of another version.
    """
    if not directory.is_dir():
        raise InputError("no such directory", where=str(directory), cure="Give the --out directory of a run.")
    path = directory / CHECKPOINT_NAME
    if not path.exists():
        return None
    state = _sealed_state(path)
    if state is None:
        raise DataError(f"{path} is damaged, cut short, or of another version", cure=_cure(directory))
    problem = _journal_problem(directory, state)
    if problem:
        raise DataError(problem, cure=_cure(directory))
    return state


def _sealed_state(path: Path) -> dict[str, Any] | None:
    """Return a checkpoint's content; None where it is not there or not as it was written."""
    try:
        found = unsealed(path.read_bytes())
    except (OSError, ValueError):
        return None
    return found[0] if found and found[0].get("schema") == SCHEMA else None


def _journal_problem(directory: Path, state: Mapping[str, Any]) -> str:
    """Return what is wrong with the journal up to the checkpoint `state`; empty where nothing is."""
    path, length, chain, end = directory / JOURNAL_NAME, state["journal_length"], START, 0
    try:
        events = _chained(path)
        while end < length:
            _, chain, end = next(events, (None, chain, length + 1))
    except OSError as error:
        return f"{path} cannot be read: {error.strerror}"
    except DataError as error:
        return error.problem
    if (end, chain) != (length, state["journal_chain"]):
        return f"{path} does not hold the {length} bytes of whole events that its checkpoint belongs to"
    return ""


def _cure(directory: Path) -> str:
    """Return what can be done about damage: go back one event where the files before it are whole, or start again."""
    previous = directory / PREVIOUS_NAME
    state = _sealed_state(previous)
    if state is None or _journal_problem(directory, state):
        return START_AGAIN
    back = f"mv {previous} {directory / CHECKPOINT_NAME}"
    return f"Go back to the last whole event: {back}, then --resume. Or start again."


def read_journal(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the events of a journal; a torn last line is left out.

    Raises
    ------
    DataError
        A line other than a torn last one is not as it was written.
    """
    for event, _, _ in _chained(path):
        yield event


def _chained(path: Path) -> Iterator[tuple[dict[str, Any], str, int]]:
    """Yield each event with the chain and the number of bytes up to its end."""
    chain, end = START, 0
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                return
            found = unsealed(line, chain)
            if found is None:
                raise DataError(f"{path}:{number}: the line is not as it was written", cure=START_AGAIN)
            event, chain = found
            end += len(line)
            yield event, chain, end
