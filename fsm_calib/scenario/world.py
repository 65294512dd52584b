"""From a scenario to the specification of its world."""

from __future__ import annotations

from pathlib import Path

from fsm_calib.scenario.load import load_scenario
from fsm_calib.scenario.models import RobotSection, Scenario
from fsm_calib.scenario.robot import robot_of
from fsm_calib.scenario.scene import scene_of
from fsm_calib.types import Pose2
from fsm_calib.world2d.robot import WorldSpec
from fsm_calib.world2d.scene import SceneSpec


def start_of(section: RobotSection, scene: SceneSpec) -> Pose2:
    """Return where the robot begins: as given, in the lane, or at the origin between the boards."""
    if section.start_in_lane is not None and scene.road is not None:
        return scene.road.start.then(Pose2(section.start_in_lane))
    return Pose2() if section.start is None else section.start.build()


def world_of(scenario: Scenario) -> WorldSpec:
    """Return robot, area, start, sensor, faults and wear of a scenario."""
    robot, scene = robot_of(scenario), scene_of(scenario)
    return WorldSpec(
        robot=robot,
        scene=scene,
        start=start_of(scenario.robot, scene),
        sensor=scenario.sensor.build(defocus=robot.defocus),
        settings=scenario.world.build(),
        faults=tuple(fault.build() for fault in scenario.faults),
        wear=scenario.wear.build(),
        seed=scenario.seed,
    )


def physics_of(path: str | Path) -> dict[str, float]:
    """Return what a scenario file's robot has beyond wheels and camera: values by full name (``floor_tilt.slope_x``).

    Raises
    ------
    InputError
        The file is no scenario; with ``file:line:column``.
    """
    return dict(robot_of(load_scenario(path)).effects)
