"""From a scenario to the specification of its world."""

from __future__ import annotations

from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.robot import robot_of
from fsm_calib.scenario.scene import scene_of
from fsm_calib.world2d.robot import WorldSpec


def world_of(scenario: Scenario) -> WorldSpec:
    """Return robot, area, start, sensor, faults and wear of a scenario."""
    robot = robot_of(scenario)
    return WorldSpec(
        robot=robot,
        scene=scene_of(scenario),
        start=scenario.robot.start.build(),
        sensor=scenario.sensor.build(defocus=robot.defocus),
        settings=scenario.world.build(),
        faults=tuple(fault.build() for fault in scenario.faults),
        wear=scenario.wear.build(),
        seed=scenario.seed,
    )
