"""After an investigation: the calibration driven in the improved world, and beside it without what was found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from fsm_calib.runner.progress import Observer
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.models import RobotSection, Scenario

FOLDER = "calibration"
TAKEN = ("source", "wheel_ratio", "speed", "base", "effects")
"""What the improved world says of the robot; where it starts and what it knows stays the calibration's own."""


def calibrated_afterwards(
    calibration: Scenario, world: str, directory: Path, observer: Observer
) -> dict[str, Any]:
    """Drive a calibration with the robot of `world` (the text of world.yaml), with and without its effects.

    Returns for `improved` and `without` how it ended, k found and true [1], and how far off the robot is after 2 m [m];
    the runs lie in `directory`.

    Raises
    ------
    InputError
        The improved world cannot be built.
    """
    robot = yaml.safe_load(world)["robot"]
    found = {}
    for name, effects in (("improved", robot["effects"]), ("without", {})):
        said = calibration.robot.model_dump(mode="json", exclude_unset=True)
        said |= {key: robot[key] for key in TAKEN if key in robot} | {"effects": effects}
        scenario = calibration.model_copy(update={"robot": RobotSection.model_validate(said)})
        result = run_scenario(scenario, directory / FOLDER / name, observer=observer).result
        wheels = result["wheels"] or {}
        told = ("wheel_ratio", "true_wheel_ratio", "deviation_2m_m", "iterations")
        found[name] = {"outcome": result["outcome"]} | {key: wheels.get(key) for key in told}
    return found
