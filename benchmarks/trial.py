"""One calibration of one simulated robot, from the machines, the actions and the world alone; scored by the truth."""

from __future__ import annotations

import os
import time
from collections import Counter
from dataclasses import dataclass, field, replace

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import cv2
import numpy as np

from fsm_calib.actions import ACTIVITIES, ActionSettings, Bench
from fsm_calib.actions import PUBLISHED as PUBLISHED_ACTIONS
from fsm_calib.actions import with_published as actions_as_published
from fsm_calib.machines.limits import PUBLISHED as PUBLISHED_LIMITS
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.limits import with_published as limits_as_published
from fsm_calib.machines.runtime import CalibrationMachine
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.types import STOP
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.fleet import draw_robot
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.robot import World, WorldSpec, make_world
from fsm_calib.world2d.scene import SceneSpec

PLAN = ("scan", "orientation", "wheels", "exit", "lane")


@dataclass
class Trial:
    """What is run: which robot (`seed`), which area, plan, limits, settings, and what is changed in the world."""

    seed: int
    scene: SceneSpec = field(default_factory=calibration_area)
    plan: tuple[str, ...] = PLAN
    published: tuple[str, ...] = ()
    limits: Limits | None = None
    settings: ActionSettings = field(default_factory=ActionSettings)
    world: dict = field(default_factory=dict)
    robot: dict = field(default_factory=dict)
    watch: object = None


def start_board(scene: SceneSpec) -> int:
    azimuths = [abs(np.arctan2(board.y, board.x)) for board in scene.boards]
    return int(np.argmin(azimuths)) if azimuths else 0


def run_trial(trial: Trial) -> dict:
    """Return what came out, as plain values."""
    cv2.setNumThreads(1)
    robot = replace(draw_robot(np.random.default_rng(trial.seed)), **trial.robot)
    world = make_world(WorldSpec(robot=robot, scene=trial.scene, seed=trial.seed, **trial.world))
    limits = trial.limits or Limits(
        boards=max(len(trial.scene.boards), 1), start_board=start_board(trial.scene)
    )
    limits = limits_as_published(limits, *(name for name in trial.published if name in PUBLISHED_LIMITS))
    settings = actions_as_published(
        trial.settings, *(name for name in trial.published if name in PUBLISHED_ACTIONS)
    )
    settings = replace(settings, lane=replace(settings.lane, advance=trial.scene.exit_advance))
    if trial.scene.road is not None:
        settings = replace(settings, marker=replace(settings.marker, lane_first=trial.scene.road.first_id))
    machine, bench = CalibrationMachine(limits, trial.plan), Bench(world.robot, settings)
    return drive_machine(trial, world, machine, bench)


def drive_machine(trial: Trial, world: World, machine: CalibrationMachine, bench: Bench) -> dict:
    begun, spent, counts = time.perf_counter(), Counter(), Counter()
    while machine.activity is not None:
        name, bench.briefing = machine.activity, machine.briefing
        before = time.perf_counter()
        outcome = ACTIVITIES[name](bench)
        bench.frames.clear()
        spent[name] += time.perf_counter() - before
        counts[name] += 1
        if trial.watch is not None:
            trial.watch(world, machine, bench, name, outcome)
        machine.fire(outcome)
    world.robot.command(STOP)
    wall = time.perf_counter() - begun
    return score(trial, world, machine, bench) | {
        "wall": wall,
        "simulated": world.robot.now(),
        "frames": world.robot.frames_taken,
        "events": machine.books.ticks,
        "spent": {name: round(value, 2) for name, value in spent.most_common()},
        "counts": dict(counts),
    }


def score(trial: Trial, world: World, machine: CalibrationMachine, bench: Bench) -> dict:
    notebook, parameters = bench.notebook, world.truth.parameters
    before = notebook.lane_before
    result = {
        "seed": trial.seed,
        "state": machine.state,
        "failure": machine.failure.name if machine.failure else "",
        "from": machine.failure.state if machine.failure else "",
        "true_ratio": world.truth.wheel_ratio,
        "wheel_ratio": notebook.wheel_ratio,
        "iterations": len(notebook.runs),
        "deviation": straight_deviation(parameters, notebook.wheel_ratio),
        "deviation_uncalibrated": straight_deviation(parameters, 1.0),
        "deviation_before_lane": None if before is None else straight_deviation(parameters, before),
        "applied": before is not None and before != notebook.wheel_ratio,
        "true_px": None,
    }
    if notebook.camera is not None and notebook.figures is not None:
        result["true_px"] = projection_difference(world.spec.robot.camera, notebook.camera).rms
        result |= {"predicted_px": notebook.figures.predicted_px, "rms_px": notebook.figures.rms_px}
        result["views"] = notebook.figures.views_per_board
    mount, true = notebook.mount, world.spec.robot.mount
    result["mount_deg"] = [
        round(float(np.degrees(getattr(mount, name) - getattr(true, name))), 2)
        for name in ("pitch", "roll", "yaw")
    ] + [round(1e3 * (mount.height - true.height), 1)]
    return result
