"""What a state does: ask the robot, call perception, return a typed outcome. One verb per function.

`ACTIVITIES` maps the names that the machines' states use to these functions; each takes the run's `Bench`
and returns one `Outcome`. The contract (what each does and may return) is `machines.activities`.
"""

from __future__ import annotations

from collections.abc import Callable

from fsm_calib.actions.aligning import measure_marker, turn_clockwise, turn_counterclockwise, turn_to_marker
from fsm_calib.actions.bench import Bench, KeptFrame
from fsm_calib.actions.focusing import measure_sharpness
from fsm_calib.actions.judging import judge_views
from fsm_calib.actions.lane_driving import follow_lane, seek_lane
from fsm_calib.actions.leaving import drive_off, hand_over
from fsm_calib.actions.notebook import Notebook
from fsm_calib.actions.published import PUBLISHED, with_published
from fsm_calib.actions.refining import drive_to_next_marker, judge_refinement, refine_ratio
from fsm_calib.actions.scanning import (
    look_for_board,
    search_clockwise,
    search_counterclockwise,
    step_clockwise,
    step_counterclockwise,
)
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.actions.solving import move_to_standpoint, solve_camera
from fsm_calib.actions.stopping import stop_wheels
from fsm_calib.actions.wheel_runs import drive_back, drive_forward, measure_ratio, update_ratio
from fsm_calib.outcome import Outcome

ACTIVITIES: dict[str, Callable[[Bench], Outcome]] = {
    action.__name__: action
    for action in (
        stop_wheels,
        measure_sharpness,
        look_for_board,
        step_clockwise,
        step_counterclockwise,
        search_clockwise,
        search_counterclockwise,
        judge_views,
        solve_camera,
        move_to_standpoint,
        turn_to_marker,
        turn_clockwise,
        turn_counterclockwise,
        measure_marker,
        drive_forward,
        drive_back,
        measure_ratio,
        update_ratio,
        drive_off,
        hand_over,
        seek_lane,
        follow_lane,
        drive_to_next_marker,
        refine_ratio,
        judge_refinement,
    )
}
"""Every do-activity by its name."""

__all__ = ["ACTIVITIES", "PUBLISHED", "ActionSettings", "Bench", "KeptFrame", "Notebook", "with_published"]
