"""Reads a scenario file: every error at once, each with its place and the nearest valid name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from fsm_calib.errors import InputError
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.scenario.explain import input_error
from fsm_calib.scenario.machine import scenario_model
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.scene import boards_of
from fsm_calib.scenario.yaml_source import YamlDocument, read_yaml
from fsm_calib.statechart.machinery import Machinery

Model = TypeVar("Model", bound=BaseModel)


def load_scenario(path: str | Path) -> Scenario:
    """Return the scenario in a YAML file.

    Raises
    ------
    InputError
        With ``file:line:column`` for everything that is wrong; `ManyErrors` when there are several.
    """
    return scenario_from(read_yaml(path))


def scenario_from(document: YamlDocument, machinery: Machinery = CALIBRATION) -> Scenario:
    """Return the scenario of a machine in a parsed YAML document; see `load_scenario` for the errors."""
    scenario = checked(document, scenario_model(machinery), "a scenario", "scenarios/full_calibration.yaml")
    _check_together(scenario, document)
    return scenario


def checked(document: YamlDocument, model: type[Model], noun: str, example: str) -> Model:
    """Return a parsed YAML document as a `model`.

    The values are checked with the strictness of JSON: a list may fill a tuple, but the text '1' is no
    number and `true` is not 1.

    Raises
    ------
    InputError
        With ``file:line:column`` for everything that is wrong; `noun` is what the file should hold, `example` a
        file that does.
    """
    if not isinstance(document.data, dict):
        cure = f"Start with 'name: ...', or look at {example}."
        raise InputError(f"{noun} is a mapping of settings", where=document.where(), cure=cure)
    try:
        return model.model_validate_json(json.dumps(document.data), strict=True)
    except ValidationError as error:
        raise input_error(error, document, model) from error


def _check_together(scenario: Scenario, document: YamlDocument) -> None:
    """Raise `InputError` where settings are right one by one and wrong together."""
    robot = scenario.robot
    if robot.start is not None and robot.start_in_lane is not None:
        where = document.where(("robot", "start_in_lane"))
        raise InputError("start and start_in_lane name two places", where=where, cure="Give one of them.")
    if robot.known.wheel_ratio is not None and robot.known.ratio_drift is not None:
        where = document.where(("robot", "known", "ratio_drift"))
        raise InputError("wheel_ratio and ratio_drift tell k twice", where=where, cure="Give one of them.")
    start, boards = scenario.scene.boards.start_board, len(boards_of(scenario.scene.boards))
    if start is not None and start >= boards:
        cure = f"Boards are numbered from 0 to {boards - 1}, counter-clockwise."
        where = document.where(("scene", "boards", "start_board"))
        raise InputError(f"start_board is {start}, and there are {boards} boards", where=where, cure=cure)
