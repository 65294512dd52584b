"""From a scenario's `robot` to the robot as it truly is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.scenario.models import RobotSection, Scenario
from fsm_calib.world2d.effects import effect as effect_of
from fsm_calib.world2d.fleet import RobotSpec, draw_robot, nominal_robot

ROBOT_STREAM = 1
"""Which random stream of the seed draws the robot; the world's own noise has others."""


def robot_of(scenario: Scenario) -> RobotSpec:
    """Return the scenario's robot: nominal or drawn with the seed, then what the file gives."""
    section = scenario.robot
    if section.source == "nominal":
        robot = nominal_robot(section.name)
    else:
        robot = draw_robot(np.random.default_rng([scenario.seed, ROBOT_STREAM]), section.name)
    if section.camera is not None:
        robot = replace(robot, camera=section.camera.build())
    if section.mount is not None:
        robot = replace(robot, mount=section.mount.build())
    if section.wheel_ratio is not None:
        robot = replace(robot, wheel_ratio=section.wheel_ratio)
    if section.speed is not None:
        robot = replace(robot, speed=section.speed)
    base = section.base.model_dump(exclude_none=True)
    if "axle_length" in base:
        robot = replace(robot, axle_length=base["axle_length"])
    return replace(robot, effects=base | effect_values(section))


def effect_values(section: RobotSection) -> dict[str, float]:
    """Return the values of the effects that are switched on, by full name (``battery_sag.per_charge``)."""
    values: dict[str, float] = {}
    for name in type(section.effects).model_fields:
        effect = getattr(section.effects, name)
        if effect is not None:
            given = effect.model_dump(exclude_none=True) or typical_values(name)
            values |= {f"{name}.{key}": value for key, value in given.items()}
    return values


def typical_values(name: str) -> dict[str, float]:
    """Return the typical size of an effect, as its file declares it."""
    return {parameter.name: parameter.typical for parameter in effect_of(name).parameters}
