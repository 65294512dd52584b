"""From a scenario to the frozen settings of the machines and the actions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from fsm_calib.actions.published import PUBLISHED as PUBLISHED_ACTIONS
from fsm_calib.actions.published import with_published as actions_as_published
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.scenario.machine import drawn_limits
from fsm_calib.scenario.models import Scenario
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, SceneSpec

MARKERS_AHEAD = 0.35
"""So much of the field must lie ahead of the robot at the end of a drive [m]: the camera sees the floor from about 0.15
m on, and two columns of markers, 0.15 m apart, in what is left."""


def limits_of(scenario: Scenario, scene: SceneSpec, machinery: Machinery = CALIBRATION) -> Any:
    """Return the machine's limits: the boards are the scene's, published behaviours are switched on."""
    given = scenario.scene.boards.start_board
    start = board_ahead(scene.boards) if given is None else given
    drawn = {"boards": max(len(scene.boards), 1), "start_board": start}
    limits = scenario.limits.build(**{name: drawn[name] for name in drawn_limits(machinery)})
    for name in scenario.published:
        limits = replace(limits, **machinery.published.get(name, {}))
    return limits


def board_ahead(boards: tuple[BoardPlacement, ...]) -> int:
    """Return the number of the board nearest to straight ahead of a robot at the origin facing +x."""
    azimuths = [abs(math.atan2(board.y, board.x)) for board in boards]
    return azimuths.index(min(azimuths)) if azimuths else 0


def actions_of(scenario: Scenario, scene: SceneSpec) -> ActionSettings:
    """Return the actions' settings; what the area's drawing tells is taken from it unless given.

    That is: the form of the boards, the size of the markers, how far the field lets the robot drive, the pitch and
    the reserved number of the lane's markers and the way from the field to the lane. A real robot's operator knows
    these from the drawing, too.
    """
    section = scenario.actions
    settings: ActionSettings = section.build(board=_board(scenario, scene))
    if scene.field is not None and "size" not in section.marker.model_fields_set:
        settings = replace(settings, marker=replace(settings.marker, size=scene.field.size))
    if scene.field is not None and "distance" not in section.drive.model_fields_set:
        distance = max(min(settings.drive.distance, field_reach(scene.field)), settings.drive.shortest)
        settings = replace(settings, drive=replace(settings.drive, distance=distance))
    if scene.road is not None:
        drawn = {"advance": scene.exit_advance, "marker_pitch": scene.road.marker_pitch}
        given = section.lane.model_fields_set
        lane: dict[str, Any] = {name: value for name, value in drawn.items() if name not in given}
        settings = replace(settings, lane=replace(settings.lane, **lane))
        if "lane_first" not in section.marker.model_fields_set:
            settings = replace(settings, marker=replace(settings.marker, lane_first=scene.road.first_id))
    return actions_as_published(settings, *(name for name in scenario.published if name in PUBLISHED_ACTIONS))


def field_reach(field: MarkerField) -> float:
    """Return how far a robot at the area's origin may drive over the field with markers left ahead of it [m]."""
    return abs(field.last_x) - MARKERS_AHEAD


def _board(scenario: Scenario, scene: SceneSpec) -> object:
    """Return the form of the boards."""
    return scene.boards[0].board if scene.boards else scenario.scene.boards.board.build()
