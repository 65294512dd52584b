"""Every guard at both sides of its boundary; guards and bookkeeping are pure in what they may touch."""

from __future__ import annotations

import math
from copy import deepcopy

import pytest
from machine_case import LIMITS

from fsm_calib.machines.bookkeeping import ACTIONS
from fsm_calib.machines.books import Books
from fsm_calib.machines.guards import GUARDS
from fsm_calib.machines.limits import Limits

LATE = Limits(boards=3, passes=1, late_bound_check=True)
UP, DOWN = math.inf, -math.inf
NEXT = math.nextafter


# fmt: off
TABLE = [
    # guard, books, evidence, answer; the limits are those of the cases
    ("is_sharp", {}, {"sharp": True}, True),
    ("is_sharp", {}, {"sharp": False}, False),
    ("has_focus_looks_left", {"looks": 1}, {}, True),
    ("has_focus_looks_left", {"looks": 2}, {}, False),
    ("has_misses_left", {"misses": 0}, {}, True),
    ("has_misses_left", {"misses": 1}, {}, False),
    ("has_views_left", {"views": 4}, {}, True),
    ("has_views_left", {"views": 5}, {}, False),
    ("is_judgement_due", {"views": 4}, {"fresh_views": 3}, True),
    ("is_judgement_due", {"views": 4}, {"fresh_views": 2}, False),
    ("is_judgement_due", {"views": 5}, {"fresh_views": 3}, False),
    ("is_judgement_due", {}, {}, False),
    ("is_camera_precise", {"precise": 1}, {"precise": True}, True),
    ("is_camera_precise", {"precise": 1}, {"precise": False}, False),
    ("is_camera_precise", {"precise": 0}, {"precise": True}, False),
    ("is_camera_known", {"cameras": 1}, {}, True),
    ("is_camera_known", {"cameras": 0}, {}, False),
    ("has_board_clockwise", {"board": 1}, {}, True),
    ("has_board_clockwise", {"board": 0}, {}, False),
    ("has_board_counterclockwise", {"board": 1}, {}, True),
    ("has_board_counterclockwise", {"board": 2}, {}, False),
    ("can_pass_clockwise", {"board": 1}, {}, True),
    ("can_pass_clockwise", {"board": 0}, {}, False),
    ("can_pass_counterclockwise", {"board": 1}, {}, True),
    ("can_pass_counterclockwise", {"board": 2}, {}, False),
    ("is_at_last_board", {"board": 2}, {}, True),
    ("is_at_last_board", {"board": 1}, {}, False),
    ("is_past_end", {"board": -1}, {}, True),
    ("is_past_end", {"board": 0}, {}, False),
    ("is_past_end", {"board": 2}, {}, False),
    ("is_past_end", {"board": 3}, {}, True),
    ("has_sweeps_left", {"changes": 0}, {}, True),
    ("has_sweeps_left", {"changes": 1}, {}, False),
    ("is_sweep_over", {"changes": 2}, {}, True),
    ("is_sweep_over", {"changes": 1}, {}, False),
    ("has_search_left", {"steps": 2}, {}, True),
    ("has_search_left", {"steps": 3}, {}, False),
    ("has_search_left", {"angle": 0.0}, {"turned": NEXT(2.0, DOWN)}, True),
    ("has_search_left", {"angle": 1.5}, {"turned": 0.5}, False),
    ("has_search_left", {"angle": 1.5}, {"turned": -0.5}, False),
    ("has_standpoints_left", {"standpoints": 1}, {}, True),
    ("has_standpoints_left", {"standpoints": 2}, {}, False),
    ("has_frame_retries_left", {"lost_frames": 1}, {}, True),
    ("has_frame_retries_left", {"lost_frames": 2}, {}, False),
    ("is_aligned", {}, {"heading": 0.05}, True),
    ("is_aligned", {}, {"heading": NEXT(0.05, UP)}, False),
    ("is_aligned", {}, {"heading": NEXT(-0.05, DOWN)}, False),
    ("is_roughly_aligned", {}, {"heading": -0.2}, True),
    ("is_roughly_aligned", {}, {"heading": NEXT(-0.2, DOWN)}, False),
    ("is_square", {}, {"heading": 0.3}, True),
    ("is_square", {}, {"heading": NEXT(0.3, UP)}, False),
    ("is_marker_clockwise", {}, {"heading": NEXT(0.0, DOWN)}, True),
    ("is_marker_clockwise", {}, {"heading": 0.0}, False),
    ("can_turn_clockwise", {"turns": 2, "overshoots": 1}, {"heading": -1.0}, True),
    ("can_turn_clockwise", {"turns": 3, "overshoots": 1}, {"heading": -1.0}, False),
    ("can_turn_clockwise", {"turns": 2, "overshoots": 2}, {"heading": -1.0}, False),
    ("can_turn_clockwise", {"turns": 2, "overshoots": 1}, {"heading": 1.0}, False),
    ("can_turn_counterclockwise", {"turns": 2, "overshoots": 1}, {"heading": 1.0}, True),
    ("can_turn_counterclockwise", {"turns": 3, "overshoots": 1}, {"heading": 1.0}, False),
    ("can_turn_counterclockwise", {"turns": 2, "overshoots": 2}, {"heading": 1.0}, False),
    ("can_turn_counterclockwise", {"turns": 2, "overshoots": 1}, {"heading": -1.0}, False),
    ("has_seeking_left", {"steps": 2}, {}, True),
    ("has_seeking_left", {"steps": 3}, {}, False),
    ("has_seeking_left", {"angle": 0.0}, {"turned": NEXT(3.0, DOWN)}, True),
    ("has_seeking_left", {"angle": 2.5}, {"turned": 0.5}, False),
    ("has_recoveries_left", {"recoveries": 1}, {}, True),
    ("has_recoveries_left", {"recoveries": 2}, {}, False),
    ("is_settled", {"quiet": 2}, {"quiet": True}, True),
    ("is_settled", {"quiet": 2}, {"quiet": False}, False),
    ("is_settled", {"quiet": 1}, {"quiet": True}, False),
    ("has_iterations_left", {"iterations": 3}, {}, True),
    ("has_iterations_left", {"iterations": 4}, {}, False),
    ("has_leaving_left", {"leaving": 2}, {}, True),
    ("has_leaving_left", {"leaving": 3}, {}, False),
    ("has_following_left", {"following": 2}, {}, True),
    ("has_following_left", {"following": 3}, {}, False),
    ("has_markers_left", {"markers": 1}, {}, True),
    ("has_markers_left", {"markers": 2}, {}, False),
    ("is_plan_done", {"plan": []}, {}, True),
    ("is_plan_done", {"plan": ["lane"]}, {}, False),
    *((f"is_next_{phase}", {"plan": [phase, "lane"]}, {}, True)
      for phase in ("focus", "scan", "orientation", "wheels", "exit", "lane")),
    *((f"is_next_{phase}", {"plan": ["other", phase]}, {}, False)
      for phase in ("focus", "scan", "orientation", "wheels", "exit", "lane")),
]
# fmt: on


@pytest.mark.parametrize(("guard", "books", "evidence", "answer"), TABLE)
def test_guard_answers_at_its_boundary(guard: str, books: dict, evidence: dict, answer: bool) -> None:
    kept = Books(**books)
    before = deepcopy(kept)
    assert GUARDS[guard](kept, LIMITS, evidence) is answer
    assert kept == before


def test_every_guard_is_tested_with_both_answers() -> None:
    assert {(name, answer) for name, _, _, answer in TABLE} == {(n, a) for n in GUARDS for a in (True, False)}


@pytest.mark.parametrize(("way", "end"), [("clockwise", 0), ("counterclockwise", 2)])
def test_as_published_the_row_has_no_end_until_it_was_passed(way: str, end: int) -> None:
    assert not GUARDS[f"can_pass_{way}"](Books(board=end), LIMITS, {})
    assert GUARDS[f"can_pass_{way}"](Books(board=end), LATE, {})


@pytest.mark.parametrize("name", sorted(ACTIONS))
def test_bookkeeping_changes_only_numbers_that_the_books_hold(name: str) -> None:
    books = Books(plan=["scan", "lane"], phase="focus", board=5, misses=3, angle=0.5)
    ACTIONS[name](books, LIMITS, {"quiet": True, "precise": True, "turned": 0.25})
    assert {key: type(value) for key, value in books.to_dict().items()} == {
        key: type(value) for key, value in Books().to_dict().items()
    }
    assert books != Books(plan=["scan", "lane"], phase="focus", board=5, misses=3, angle=0.5)
