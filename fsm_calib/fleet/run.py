"""Runs a fleet of real robots in parallel; each robot's row is a file of its own before the next one is looked at."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

from fsm_calib.errors import DataError
from fsm_calib.fleet.folders import RobotFiles
from fsm_calib.fleet.robot import robot_row
from fsm_calib.journal import write_atomically
from fsm_calib.study.backends import Backend, Crew, death_errors, end_local_workers, results_of, workers
from fsm_calib.study.orphans import end_with

ROWS = "robots"
"""Folder of the robots' files."""
Row = dict[str, Any]


class Watcher(Protocol):
    """Whoever watches a fleet."""

    def begin(self, done: int, total: int, workers: int) -> None:
        """Take note: `done` of `total` robots are on disk already, `workers` take up the rest."""
        ...

    def row(self, row: dict[str, Any]) -> None:
        """Take note of a robot that has ended."""
        ...


def run_robots(
    robots: Sequence[RobotFiles],
    directory: Path,
    watcher: Watcher,
    *,
    diagnosed: bool = False,
    crew: Crew | None = None,
) -> list[Row]:
    """Return the rows of all robots, worst first; those that `directory` holds already are not found out again.

    A row is kept where it answers the same question about files that have not changed; an error is tried again. On a
    cluster, the workers must see the recordings under the same paths.

    Raises
    ------
    DataError
        A worker process died.
    InputError
        No cluster answers.
    """
    crew = crew or Crew()
    (directory / ROWS).mkdir(parents=True, exist_ok=True)
    rows, calls = [], []
    for robot in robots:
        stamp = robot.stamp
        kept = kept_row(directory / ROWS / f"{robot.name}.json", diagnosed, stamp)
        if kept is None:
            calls.append((robot, diagnosed, stamp, os.getpid()))
        else:
            rows.append(kept)
    if calls:
        with workers(crew.backend, crew.jobs, crew.address) as count:
            watcher.begin(len(rows), len(robots), count)
            rows += _found_out(calls, directory / ROWS, crew.backend, count, watcher)
    return sorted(rows, key=worst_first)


def _found_out(
    calls: list[tuple[Any, ...]], folder: Path, backend: Backend, count: int, watcher: Watcher
) -> list[Row]:
    rows = []
    try:
        for row in results_of(work, calls, count):
            text = json.dumps(row, indent=1, allow_nan=False) + "\n"
            write_atomically(folder / f"{row['robot']}.json", text.encode())
            rows.append(row)
            watcher.row(row)
    except death_errors(backend) as error:
        cure = "Give the same command with a smaller --jobs: it goes on with the robots that are left."
        raise DataError("a worker process died, as it does when memory runs out", cure=cure) from error
    except BaseException:
        if backend == "loky":
            end_local_workers()
        raise
    return rows


def work(robot: RobotFiles, diagnosed: bool, stamp: list[list[str | int]], command: int) -> Row:
    """Find out about one robot, in a process that ends with the command that asked for it."""
    end_with(command)
    return robot_row(robot, diagnosed, stamp)


def kept_row(path: Path, diagnosed: bool, stamp: list[list[str | int]]) -> Row | None:
    """Return the row on disk; None where there is none, it is an error's or damaged, or it answers another question."""
    try:
        row = json.loads(path.read_text("utf-8"))
        asked = row["asked"]
        same = asked["files"] == stamp and (asked["diagnose"] or not diagnosed)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return row if same and "error" not in row else None


def worst_first(row: Row) -> tuple[bool, bool, bool, float, str]:
    """Return what sorts rows: robots with more than the base can explain, then those that turn most; then those
    whose pull is not told, errors at the end.
    """
    straight = row.get("straight")
    departs = (row.get("diagnosis") or {}).get("verdict") in ("explained", "unexplained")
    size = 0.0 if straight is None else abs(straight["turned_rad"])
    return "error" in row, not departs, straight is None, -size, row["robot"]
