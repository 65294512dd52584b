"""The results of a study on disk: one JSON line per robot, appended whole, as they come.

A line is written by one call and made durable; a torn last line, left by a power cut, is cut off when the
study is taken up again. A header says to which study and version the lines belong.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.journal import encode, write_atomically
from fsm_calib.study.load import study_text
from fsm_calib.study.models import Study

RESULTS_NAME = "results.jsonl"
HEADER_NAME = "study.lock.json"
Key = tuple[str, int]
"""What names a row: the variant and the robot's number."""


def identity(study: Study) -> dict[str, str]:
    """Return what rows must have in common to stand in one file: everything but how many robots."""
    same = study.model_copy(update={"robots": 1, "variant_robots": 1, "title": ""})
    every = json.dumps(same.model_dump(mode="json"), sort_keys=True)  # defaults may differ between versions
    text = study_text(same) + every
    return {"study": hashlib.sha256(text.encode()).hexdigest(), "version": version("fsm-calib")}


def result_of_row(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return what follows from study and robot alone: a row without what the work cost and who did it."""
    return {name: value for name, value in row.items() if name not in ("cost", "worker")}


def key_of(row: Mapping[str, Any]) -> Key:
    """Return the variant and the robot of a row."""
    return str(row["variant"]), int(row["robot"])


class Store:
    """The rows of one study in a directory.

    Parameters
    ----------
    directory : Path
        Made when it is missing; what an earlier run of the same study left there is kept.
    study : Study

    Raises
    ------
    InputError
        When the directory holds the results of another study, seed or version.
    """

    def __init__(self, directory: Path, study: Study) -> None:
        directory.mkdir(parents=True, exist_ok=True)
        self.directory = directory
        self._path = directory / RESULTS_NAME
        self._claim(study)
        self.rows: dict[Key, dict[str, Any]] = {key_of(row): row for row in self._read()}

    def _claim(self, study: Study) -> None:
        """Write the header, or check that the one that is there is ours."""
        header, wanted = self.directory / HEADER_NAME, identity(study)
        if header.exists():
            found = json.loads(header.read_bytes())
            for name, value in wanted.items():
                if found.get(name) != value:
                    what = "study or seed" if name == "study" else "version of fsm-calib"
                    cure = "Give another --out, or the same study and seed."
                    raise InputError(
                        f"it holds results of another {what}", where=str(self.directory), cure=cure
                    )
        elif self._path.exists():
            raise InputError(
                "it holds results without a header", where=str(self.directory), cure="Give another --out."
            )
        else:
            write_atomically(header, (json.dumps(wanted, indent=2) + "\n").encode(), durable=True)

    def _read(self) -> list[dict[str, Any]]:
        """Return the rows that are there; a torn last line is cut off the file."""
        if not self._path.exists():
            return []
        content = self._path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            with self._path.open("r+b") as file:
                file.truncate(len(whole))
        return [json.loads(line) for line in whole.splitlines()]

    def append(self, row: dict[str, Any]) -> None:
        """Add a row, in one write, and make it durable."""
        descriptor = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(descriptor, encode(row))
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        self.rows[key_of(row)] = row
