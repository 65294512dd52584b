"""From a scenario's `scene` to the frozen specification of the world."""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.scenario.models import BoardsSection, Scenario
from fsm_calib.world2d.layout import calibration_area, lane_beyond, mixed_boards, upright_boards
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec


def scene_of(scenario: Scenario) -> SceneSpec:
    """Return the calibration area of a scenario; the lane lies beyond the marker field."""
    section = scenario.scene
    field = section.field.build()
    road = lane_beyond(
        field, **{name: getattr(section.road, name) for name in type(section.road).model_fields}
    )
    area = calibration_area(boards_of(section.boards), field, road)
    return replace(area, walls=tuple(wall.build() for wall in section.walls))


def boards_of(section: BoardsSection) -> tuple[BoardPlacement, ...]:
    """Return the boards, counted counter-clockwise: those placed one by one, or a layout."""
    if section.placed is not None:
        return tuple(board.build() for board in section.placed)
    layout = {"mixed": mixed_boards, "upright": upright_boards}[section.layout]
    return layout(section.count, section.board.build())
