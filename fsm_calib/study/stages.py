"""The working directory of one robot: finished stages are kept, and one process at a time works in it.

A robot that was interrupted, by a killed worker or a killed command, takes up its finished stages and, inside
the automatic calibration, the last whole event. A worker that has outlived its command keeps the lock until
its robot is done, so that a resumed command waits for it and does not do the work twice.
"""

from __future__ import annotations

import fcntl
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsm_calib.journal import plain, write_atomically

LOCK_NAME = "lock"
"""File whose lock the working process holds."""
STARTS_NAME = "starts"
"""File with one byte for each time that work on the robot was begun."""


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Hold the directory for this process (or thread) until the `with` block ends; it is made when missing."""
    directory.mkdir(parents=True, exist_ok=True)
    with (directory / LOCK_NAME).open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # released when the file is closed, also by a kill
        yield


def count_start(directory: Path) -> int:
    """Note that work in `directory` begins, and return how often it has begun."""
    with (directory / STARTS_NAME).open("ab") as file:
        file.write(b".")
    return starts(directory)


def starts(directory: Path) -> int:
    """Return how often work in `directory` has begun; zero for a directory that is not there."""
    path = directory / STARTS_NAME
    return path.stat().st_size if path.exists() else 0


@dataclass
class Stages:
    """The stages of one robot, each computed at most once.

    Parameters
    ----------
    directory : Path
        Where finished stages are kept as JSON files, written whole.
    cost : dict
        Filled with wall and processor time of each stage [s].
    """

    directory: Path
    cost: dict[str, dict[str, float]]

    def run(self, name: str, compute: Callable[[], Any]) -> Any:
        """Return the stored result of the stage `name`, or compute and store it (plain JSON values).

        The cost of a stage that was interrupted is that of its last part.
        """
        path = self.directory / f"{name}.json"
        if not path.exists():
            wall, cpu = time.perf_counter(), time.thread_time()
            result = plain(compute())
            cost = {"wall": time.perf_counter() - wall, "cpu": time.thread_time() - cpu}
            content = json.dumps({"result": result, "cost": cost}).encode()
            write_atomically(path, content, durable=True)
        stored = json.loads(path.read_bytes())
        self.cost[name] = stored["cost"]
        return stored["result"]
