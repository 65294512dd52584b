"""Trials of no weight for the tests of the fleet: each leaves a mark on disk for every stage that it computes."""

import json
import os
import signal
import time

import numpy as np

from fsm_calib.study.models import Study
from fsm_calib.study.stages import Stages, starts
from fsm_calib.study.variants import seed_of

KILLER = 2


def study(robots=6, **more):
    return Study(name="tiny", seed=5, robots=robots, **more)


def marks(directory):
    """Return the marks of all stages computed: one `robot stage` a line."""
    path = directory / "marks.txt"
    return path.read_text().split("\n")[:-1] if path.exists() else []


def _stage(study_directory, robot, name, seed):
    with (study_directory / "marks.txt").open("a") as file:
        file.write(f"{robot} {name}\n")
    values = np.random.default_rng([seed, len(name)]).normal(size=(60, 60))
    return {"value": float(np.linalg.svd(values @ values.T, compute_uv=False).sum())}


def _row(study, variant, robot, directory, between=lambda: None):
    stages, seed = Stages(directory, {}), seed_of(study.seed, robot)
    home = directory.parent.parent
    row = {"variant": variant.name, "robot": robot, "seed": seed}
    row["first"] = stages.run("first", lambda: _stage(home, robot, "first", seed))
    between()
    row["second"] = stages.run("second", lambda: _stage(home, robot, "second", seed))
    return row | {"cost": stages.cost}


def plain(study, variant, robot, directory):
    return _row(study, variant, robot, directory)


def held(study, variant, robot, directory):
    """From the third robot on, stay between the stages until `let_go`."""
    home = directory.parent.parent

    def hold():
        (home / f"holds-{os.getpid()}").touch()
        while not (home / "go on").exists():
            time.sleep(0.01)

    return _row(study, variant, robot, directory, hold if robot >= 2 else lambda: None)


def holding(directory):
    """Return the processes that stay between two stages."""
    return [int(path.name.split("-")[1]) for path in directory.glob("holds-*")]


def let_go(directory):
    """Let every robot go on, and those that come."""
    (directory / "go on").touch()


def failing(study, variant, robot, directory):
    if robot == KILLER:
        raise ValueError("this robot has no wheels")
    return _row(study, variant, robot, directory)


def dying_once(study, variant, robot, directory):
    return _row(study, variant, robot, directory, lambda: _die(robot == KILLER and starts(directory) < 2))


def dying(study, variant, robot, directory):
    return _row(study, variant, robot, directory, lambda: _die(robot == KILLER))


def _die(now):
    if now:
        os.kill(os.getpid(), signal.SIGKILL)


def results(directory):
    """Return what follows from study and robot alone, as text, in the order of the robots."""
    from fsm_calib.study.store import result_of_row

    rows = [json.loads(line) for line in (directory / "results.jsonl").read_text().splitlines()]
    rows.sort(key=lambda row: (row["variant"], row["robot"]))
    return [json.dumps(result_of_row(row), sort_keys=True) for row in rows]
