"""Reads a run's folder while another program writes it: new events, kept frames, the end.

Everything comes from files that the run writes for itself, so that watching can neither slow a run nor stop it.
"""

from __future__ import annotations

import json
from pathlib import Path
from threading import Lock
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.journal import CHECKPOINT_NAME, JOURNAL_NAME
from fsm_calib.watch.area import AREA_NAME

RESULT_NAME = "result.json"
SHOWN = ("seq", "time", "phase", "path", "dest", "trigger", "activity", "sentence", "cure", "pose", "board")
"""What the page is told of an event, beside its figures."""
FIGURES = ("wheel_ratio", "k_i")
"""Evidence that the page draws."""


class Follower:
    """The events of a run so far; `read` looks for new ones.

    Parameters
    ----------
    directory : Path
        A run's folder.

    Raises
    ------
    InputError
        The folder is missing.
    """

    def __init__(self, directory: Path) -> None:
        if not directory.is_dir():
            raise InputError("no such folder", where=str(directory), cure="Give the --out folder of a run.")
        self.directory = directory
        self._events: list[dict[str, Any]] = []
        self._read = 0
        self._lock = Lock()

    def read(self) -> list[dict[str, Any]]:
        """Return every event so far, each as the page needs it; a journal that began anew is read anew."""
        path = self.directory / JOURNAL_NAME
        with self._lock:
            size = path.stat().st_size if path.exists() else 0
            if size < self._read:
                self._events, self._read = [], 0
            if size > self._read:
                with path.open("rb") as file:
                    file.seek(self._read)
                    self._take(file.read(size - self._read))
            return list(self._events)

    def _take(self, content: bytes) -> None:
        """Keep the whole lines of what is new; a line that is still being written is read next time."""
        whole = content.rfind(b"\n") + 1
        for line in content[:whole].splitlines():
            if event := _object_in(line):
                self._events.append(shown(event))
        self._read += whole

    def pictures(self) -> list[dict[str, Any]]:
        """Return the kept frames: file, time [s], state, size [px] and points found in them [px]."""
        state = self._json(CHECKPOINT_NAME)
        gallery = state.get("gallery", [])
        return gallery if isinstance(gallery, list) else []

    def area(self) -> dict[str, Any]:
        """Return what `area.write_area` wrote, or nothing."""
        return self._json(AREA_NAME)

    def result(self) -> dict[str, Any]:
        """Return the run's result, or nothing while it runs."""
        return self._json(RESULT_NAME)

    def _json(self, name: str) -> dict[str, Any]:
        """Return an object from a file of the run; an empty one where there is none yet."""
        try:
            return _object_in((self.directory / name).read_bytes())
        except OSError:
            return {}


def _object_in(text: bytes) -> dict[str, Any]:
    """Return the JSON object that a text is, an empty one where it is none.

    The page shows what can be read; `run --resume` is where damage is told.
    """
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def shown(event: dict[str, Any]) -> dict[str, Any]:
    """Return what the page is told of an event of the journal."""
    evidence = event.get("evidence") or {}
    return {name: event.get(name) for name in SHOWN} | {
        name: evidence[name] for name in FIGURES if name in evidence
    }
