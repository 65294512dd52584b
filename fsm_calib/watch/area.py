"""What the page draws the path on: boards, tags, road and walls of an area, as plain JSON in the run's folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.journal import write_atomically
from fsm_calib.report.palette import BOARD_COLOURS, PHASE_COLOURS
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.scene import scene_of
from fsm_calib.world2d.outlines import SHOULDER, board_outline, marker_squares, road_band
from fsm_calib.world2d.scene import Road, SceneSpec

AREA_NAME = "area.json"
"""Below the run's folder; written before the run begins."""


def write_area(directory: Path, scenario: Scenario) -> None:
    """Write what the page needs to know of a scenario into the run's folder, which is made when it is missing.

    Raises
    ------
    InputError
        The folder cannot be made or written to.
    """
    content = json.dumps(area_of(scenario)).encode()
    try:
        directory.mkdir(parents=True, exist_ok=True)
        write_atomically(directory / AREA_NAME, content)
    except OSError as error:
        raise InputError(f"cannot be written to: {error.strerror}", where=str(directory)) from error


def area_of(scenario: Scenario) -> dict[str, Any]:
    """Return name, plan, colours and outlines, each of shape (n, 2) [m], of a scenario's area."""
    scene = scene_of(scenario)
    return {
        "name": scenario.name,
        "robot": scenario.robot.name,
        "seed": scenario.seed,
        "plan": list(scenario.plan),
        "colours": PHASE_COLOURS,
        "board_colours": BOARD_COLOURS,
        "shapes": shapes_of(scene),
    }


def shapes_of(scene: SceneSpec) -> list[dict[str, Any]]:
    """Return everything in an area as `kind` and `outline`, what covers others last."""
    found = _road_shapes(scene.road) if scene.road is not None else []
    if scene.field is not None:
        found += [_shape("tag", square) for square in marker_squares(scene.field)]
    found += [_shape("board", board_outline(board)) for board in scene.boards]
    found += [_shape("wall", [(wall.x0, wall.y0), (wall.x1, wall.y1)]) for wall in scene.walls]
    return found


def _road_shapes(road: Road) -> list[dict[str, Any]]:
    middle, edge = road.centre_offset, road.half_width - 0.5 * road.white_width
    found = [_shape("road", road_band(road, middle, 2.0 * (road.half_width + SHOULDER)))]
    found += [_shape("white", road_band(road, middle + side, road.white_width)) for side in (-edge, edge)]
    begins = np.arange(0.0, road.length - road.dash, road.dash + road.gap).tolist()
    dashes = [road_band(road, middle, road.yellow_width, begin, begin + road.dash) for begin in begins]
    return found + [_shape("yellow", dash) for dash in dashes]


def _shape(kind: str, outline: Any) -> dict[str, Any]:
    return {"kind": kind, "outline": np.round(np.asarray(outline, dtype=float), 4).tolist()}
