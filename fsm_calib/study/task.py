"""One unit of work of a fleet: one robot of one variant. It travels to a worker as text and comes back as a row.

Whatever happens to a robot is its row: a result, or the error that ended it. Only the death of the worker's
process has no row; the fleet sees to that.
"""

from __future__ import annotations

import os
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsm_calib.perception.opencv_threads import use_one_thread
from fsm_calib.study.load import study_of_text
from fsm_calib.study.models import Study
from fsm_calib.study.orphans import end_with
from fsm_calib.study.stages import count_start, locked
from fsm_calib.study.trial import run_trial
from fsm_calib.study.variants import Variant, robot_name

SESSION_NAME = "session"
"""File in the study's directory that holds the number of the command which is at work there."""
WORK_NAME = "work"
"""Folder of the robots' working directories, below the study's directory."""
Trial = Callable[[Study, Variant, int, Path], dict[str, Any]]
"""What is done with a robot: study, variant, number and working directory to a row (`trial.run_trial`)."""


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker is told.

    Parameters
    ----------
    study : str
        The study as text (`load.study_text`).
    variant : Variant
    robot : int
        Number of the robot.
    directory : str
        The study's directory; on machines that do not see it, work is done in a temporary one.
    session : int
        Number of the command that gave the task.
    command : int
        Its process; a worker that it started itself ends when it is gone. Zero: nobody is watched.
    """

    study: str
    variant: Variant
    robot: int
    directory: str
    session: int
    command: int = 0

    @property
    def work(self) -> Path:
        """The robot's working directory."""
        return Path(self.directory) / WORK_NAME / work_name(self.variant.name, self.robot)


def work_name(variant: str, robot: int) -> str:
    """Return the name of a robot's working directory."""
    safe = "".join(letter if letter.isalnum() or letter in "._=-" else "_" for letter in variant)
    return f"{safe}-{robot_name(robot)}"


def run_task(task: Task, trial: Trial = run_trial) -> dict[str, Any] | None:
    """Return the row of one robot; None when the command that gave the task is no longer at work."""
    use_one_thread()
    end_with(task.command)
    began = time.perf_counter()
    with ExitStack() as stack:
        work = task.work
        if Path(task.directory).is_dir():
            stack.enter_context(locked(work))
            if is_stale(task):
                return None
        else:
            work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="fsm-calib-")))
        count_start(work)
        row = _row_of(task, work, trial)
    return row | {"worker": {"process": os.getpid(), "seconds": time.perf_counter() - began}}


def _row_of(task: Task, work: Path, trial: Trial) -> dict[str, Any]:
    """Return the robot's result, or what ended it."""
    try:
        return trial(study_of_text(task.study), task.variant, task.robot, work)
    except Exception as error:  # one robot's failure is its own row, whatever it is
        return error_row(task, type(error).__name__, str(error), traceback.format_exc(limit=-4))


def error_row(task: Task, name: str, reason: str, trace: str = "") -> dict[str, Any]:
    """Return the row of a robot that has no result."""
    error = {"name": name, "reason": reason, "trace": trace}
    return {"variant": task.variant.name, "robot": task.robot, "error": error}


def is_stale(task: Task) -> bool:
    """Tell whether another command has taken over the study's directory since the task was given."""
    return read_session(Path(task.directory)) != task.session


def read_session(directory: Path) -> int:
    """Return the number of the last command that worked in a study's directory; zero before the first."""
    path = directory / SESSION_NAME
    return int(path.read_text()) if path.exists() else 0
