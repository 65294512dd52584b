"""Runs the robots of a study in parallel; every row is on disk before the next one is looked at.

What can go wrong costs one robot: an error in it is its row; a worker process that dies takes its robot back
to its last event and no further. A robot whose work was begun `MOST_STARTS` times without an end runs alone
afterwards, so that it can take no other with it, and if the process then dies once more, that is its row.
A command that is killed goes on where it was when it is given again.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from fsm_calib.errors import InputError
from fsm_calib.journal import write_atomically
from fsm_calib.study.backends import Backend, Crew, death_errors, end_local_workers, results_of, workers
from fsm_calib.study.load import study_text
from fsm_calib.study.models import Study
from fsm_calib.study.pace import Pace, Work, stages_of
from fsm_calib.study.stages import starts
from fsm_calib.study.store import Key, Store, key_of
from fsm_calib.study.task import SESSION_NAME, WORK_NAME, Task, Trial, error_row, read_session, run_task
from fsm_calib.study.trial import run_trial
from fsm_calib.study.variants import BASE, variants_of

LOCK_NAME = "command.lock"
"""File whose lock the command holds that is at work in a study's directory."""
COMMANDS_NAME = "commands.jsonl"
"""One line for each command that has worked on the study: how long, how many workers, how many robots."""
MOST_STARTS = 3
"""So often a robot's work may begin among others [1]: twice may be another's fault."""


APART = 2
"""Workers asked for to run one robot alone [1]: with one, joblib would run it in this process."""


class Watcher(Protocol):
    """Whoever watches a fleet."""

    def begin(self, done: int, total: int, workers: int, foreseen: Pace) -> None:
        """Note: `done` of `total` robots are on disk, `workers` take up the rest; `foreseen` tells the time left."""
        ...

    def row(self, row: dict[str, Any]) -> None:
        """Take note of a robot that has ended."""
        ...

    def death(self, suspects: list[str]) -> None:
        """Take note that a worker has died with one of these robots."""
        ...


class Unwatched:
    """A watcher that shows nothing."""

    def begin(self, done: int, total: int, workers: int, foreseen: Pace) -> None:
        """Do nothing."""

    def row(self, row: dict[str, Any]) -> None:
        """Do nothing."""

    def death(self, suspects: list[str]) -> None:
        """Do nothing."""


@dataclass(frozen=True, slots=True)
class CommandCost:
    """What one command did.

    robots : robots that it finished; wall : its wall time [s]; busy : wall time inside the workers' robots,
    summed [s]; workers : robots at a time.
    """

    robots: int
    wall: float
    busy: float
    workers: int

    @property
    def robots_per_hour(self) -> float:
        """Robots an hour [1/h]."""
        return 3600.0 * self.robots / self.wall

    @property
    def overhead(self) -> float:
        """Share of the workers' time in which they had no robot [1]: start-up, waiting, the last robot's tail."""
        return 1.0 - self.busy / (self.workers * self.wall)


def run_fleet(
    study: Study,
    directory: Path,
    crew: Crew | None = None,
    watcher: Watcher | None = None,
    trial: Trial = run_trial,
) -> Store:
    """Run what is not on disk yet of a study, and return all its rows.

    Parameters
    ----------
    study : Study
    directory : Path
        Where rows are kept; made when it is missing. On a cluster, best on a file system that it shares.
    crew : Crew or None
        Who does the work; all local cores by default.
    watcher : Watcher or None
        Who watches.
    trial : callable
        What is done with a robot.

    Raises
    ------
    InputError
        When the directory holds another study, or another command is at work in it.
    MissingExtraError
        When the cluster's package is not installed.
    """
    crew, watcher = crew or Crew(), watcher or Unwatched()
    began = time.perf_counter()
    with _sole_command(directory) as session:
        store = Store(directory, study)
        tasks = tasks_of(study, directory, session)
        pending = {key: task for key, task in tasks.items() if key not in store.rows}
        _sweep(directory, pending)
        if not pending:
            return store
        with workers(crew.backend, crew.jobs, crew.address) as count:
            pace = pace_of(study, pending, store, count)
            watcher.begin(len(tasks) - len(pending), len(tasks), count, pace)
            busy, robots = _Rounds(store, pending, crew.backend, count, watcher, trial, pace).run()
        _note_command(directory, CommandCost(robots, time.perf_counter() - began, busy, count))
    return store


def tasks_of(study: Study, directory: Path, session: int) -> dict[Key, Task]:
    """Return every task of a study: all robots as they are, the first `variant_robots` of each variant."""
    text = study_text(study)
    tasks: dict[Key, Task] = {}
    for variant in variants_of(study):
        robots = study.robots if variant.name == BASE else min(study.robots, study.variant_robots)
        for robot in range(robots):
            place = str(directory.resolve())
            tasks[variant.name, robot] = Task(text, variant, robot, place, session, os.getpid())
    return tasks


def pace_of(study: Study, pending: Mapping[Key, Task], store: Store, workers: int) -> Pace:
    """Return who knows what is left of a study."""
    left = {
        key: Work(task.work.name, stages_of(study.parts, task.variant.name), task.work)
        for key, task in pending.items()
    }
    return Pace(left, store.rows.values(), workers)


@contextmanager
def _sole_command(directory: Path) -> Iterator[int]:
    """Hold the directory against other commands, and yield this command's number."""
    directory.mkdir(parents=True, exist_ok=True)
    with (directory / LOCK_NAME).open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            cure = "Wait for it, or give another --out."
            problem = "another command is at work in this directory"
            raise InputError(problem, where=str(directory), cure=cure) from error
        session = read_session(directory) + 1
        write_atomically(directory / SESSION_NAME, str(session).encode(), durable=True)
        yield session


def _sweep(directory: Path, pending: dict[Key, Task]) -> None:
    """Remove working directories of robots whose rows are on disk."""
    kept = {task.work for task in pending.values()}
    folder = directory.resolve() / WORK_NAME
    for work in folder.iterdir() if folder.exists() else ():
        if work not in kept:
            shutil.rmtree(work, ignore_errors=True)


def _note_command(directory: Path, cost: CommandCost) -> None:
    """Add a line on what this command did."""
    names = ("robots", "wall", "busy", "workers", "robots_per_hour", "overhead")
    with (directory / COMMANDS_NAME).open("a") as file:
        file.write(json.dumps({name: getattr(cost, name) for name in names}) + "\n")


@dataclass
class _Rounds:
    """The pending robots, given to the workers again and again until none is left."""

    store: Store
    pending: dict[Key, Task]
    backend: Backend
    count: int
    watcher: Watcher
    trial: Trial
    pace: Pace
    busy: float = 0.0
    robots: int = 0

    def run(self) -> tuple[float, int]:
        """Run to the end; return the workers' busy time [s] and the number of robots."""
        try:
            while self.pending:
                crowd = [task for task in self.pending.values() if starts(task.work) < MOST_STARTS]
                self._together(crowd) if crowd else self._alone(next(iter(self.pending.values())))
        except BaseException:
            if self.backend == "loky":
                end_local_workers()
            raise
        return self.busy, self.robots

    def _together(self, tasks: list[Task]) -> None:
        """Run tasks until they are done or a worker dies."""
        try:
            self._take(tasks, self.count)
        except death_errors(self.backend):
            begun = [task for task in self.pending.values() if starts(task.work)]
            self.watcher.death([task.work.name for task in begun])

    def _alone(self, task: Task) -> None:
        """Run a task with no other at its side; when its worker dies, that is its result."""
        try:
            self._take([task], APART)
        except death_errors(self.backend):
            reason = f"Its worker process died {starts(task.work)} times."
            self._keep(error_row(task, "WorkerDied", reason))

    def _take(self, tasks: list[Task], count: int) -> None:
        """Give tasks to the workers and keep every row as it comes."""
        for row in results_of(run_task, [(task, self.trial) for task in tasks], count):
            if row is not None:
                self._keep(row)

    def _keep(self, row: dict[str, Any]) -> None:
        """Put a row on disk, then remove the robot's working directory."""
        self.store.append(row)
        task = self.pending.pop(key_of(row))
        shutil.rmtree(task.work, ignore_errors=True)
        self.busy += row.get("worker", {}).get("seconds", 0.0)
        self.robots += 1
        self.pace.ended(key_of(row), row)
        self.watcher.row(row)
