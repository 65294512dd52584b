"""The guards: pure questions to the books, the limits and the evidence of the outcome at hand.

Every guard takes ``(books, limits, evidence)`` and answers before the books are changed: `count_miss` of the
miss at hand has not happened yet when `has_misses_left` is asked. Guards have no side effects and ask no one
else, so that they may be asked in any order, or not at all.
"""

from __future__ import annotations

from collections.abc import Callable

from fsm_calib.machines.books import Books
from fsm_calib.machines.limits import Limits
from fsm_calib.statechart.machinery import Evidence

Guard = Callable[[Books, Limits, Evidence], bool]


def is_sharp(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the picture is sharp: the activity's own judgement, ``evidence["sharp"]``."""
    return bool(evidence["sharp"])


def has_focus_looks_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether another look at the sharpness is within the budget."""
    return books.looks + 1 < limits.focus_looks


def has_misses_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether what was missed is still not lost: this miss is not the M-th in a row."""
    return books.misses + 1 < limits.misses_before_lost


def has_views_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more view of this board in this sweep is plausible for a robot that turns."""
    return books.views < limits.views_per_board


def is_judgement_due(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether so many views were taken since the last judgement that the camera is judged anew (never as
    published).
    """
    is_due = 0 < limits.views_per_judgement <= evidence.get("fresh_views", 0)
    return is_due and has_views_left(books, limits, evidence)


def is_camera_precise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether this judgement completes the required number of precise ones in a row."""
    return bool(evidence["precise"]) and books.precise + 1 >= limits.precise_judgements


def is_camera_known(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the camera was solved from an earlier standpoint, if not as precisely as wanted."""
    return books.cameras > 0


def has_board_clockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the row has a board clockwise of the present one."""
    return books.board > 0


def has_board_counterclockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the row has a board counter-clockwise of the present one."""
    return books.board < limits.boards - 1


def can_pass_clockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a board that was lost clockwise may be followed by a search for the next one."""
    return limits.late_bound_check or has_board_clockwise(books, limits, evidence)


def can_pass_counterclockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a board that was lost counter-clockwise may be followed by a search for the next one."""
    return limits.late_bound_check or has_board_counterclockwise(books, limits, evidence)


def is_at_last_board(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the board in the books is the last one counter-clockwise: all others are clockwise of it."""
    return books.board >= limits.boards - 1


def is_past_end(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the number in the books is no board's: the row's end was passed (only as published)."""
    return not 0 <= books.board < limits.boards


def has_sweeps_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a change of direction begins another sweep: P full sweeps end at change P + 1."""
    return books.changes < limits.passes


def is_sweep_over(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the last change of direction is already made (only as published: it is tested after the
    step).
    """
    return books.changes > limits.passes


def has_search_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more step of the search for a board is within its budgets of steps and angle."""
    angle = books.angle + abs(evidence.get("turned", 0.0))
    return books.steps + 1 < limits.search_steps and angle < limits.search_angle


def has_standpoints_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the boards may be scanned from one more place."""
    return books.standpoints < limits.standpoints


def has_frame_retries_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more lost frame in a row is forgiven."""
    return books.lost_frames < limits.frame_retries


def is_aligned(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the robot stands along the markers: |heading| within `aligned_within`."""
    return abs(evidence["heading"]) <= limits.aligned_within


def is_roughly_aligned(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the robot stands roughly along the markers: |heading| within `roughly_aligned_within`."""
    return abs(evidence["heading"]) <= limits.roughly_aligned_within


def is_square(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a drive from here stays over the markers: |heading| within `square_within`."""
    return abs(evidence["heading"]) <= limits.square_within


def is_marker_clockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the marker points to the right of the robot, so that turning clockwise lines the robot up."""
    return evidence["heading"] < 0.0


def _has_turns_left(books: Books, limits: Limits) -> bool:
    return books.turns < limits.turns and books.overshoots <= limits.overshoots


def can_turn_clockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a step clockwise is what is needed and within the budgets of turns and overshoots."""
    return _has_turns_left(books, limits) and is_marker_clockwise(books, limits, evidence)


def can_turn_counterclockwise(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether a step counter-clockwise is what is needed and within the budgets of turns and overshoots."""
    return _has_turns_left(books, limits) and not is_marker_clockwise(books, limits, evidence)


def has_seeking_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more step of the search for markers or the lane is within its budgets of steps and
    angle.
    """
    angle = books.angle + abs(evidence.get("turned", 0.0))
    return books.steps + 1 < limits.seeking_steps and angle < limits.seeking_angle


def has_recoveries_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more loss in this phase is followed by a search."""
    return books.recoveries < limits.recoveries


def is_settled(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether this iteration completes the required number of quiet ones in a row."""
    return bool(evidence["quiet"]) and books.quiet + 1 >= limits.quiet_iterations


def has_iterations_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether another wheel iteration is within the budget."""
    return books.iterations + 1 < limits.iterations


def has_leaving_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more step out of the field is within the budget."""
    return books.leaving + 1 < limits.leaving_steps


def has_following_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more step of lane following is within the budget."""
    return books.following + 1 < limits.following_steps


def has_markers_left(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether the marked section holds a marker beyond this one."""
    return books.markers + 1 < limits.markers


def is_plan_done(books: Books, limits: Limits, evidence: Evidence) -> bool:
    """Whether no phase of the plan is left."""
    return not books.plan


def _is_next(phase: str) -> Guard:
    def is_next(books: Books, limits: Limits, evidence: Evidence) -> bool:
        return bool(books.plan) and books.plan[0] == phase

    is_next.__name__ = f"is_next_{phase}"
    is_next.__doc__ = f"Whether the plan goes on with the phase `{phase}`."
    return is_next


_PHASE_GUARDS = tuple(_is_next(phase) for phase in ("focus", "scan", "orientation", "wheels", "exit", "lane"))

GUARDS: dict[str, Guard] = {
    guard.__name__: guard
    for guard in (
        *(value for name, value in list(globals().items()) if name.startswith(("is_", "has_", "can_"))),
        *_PHASE_GUARDS,
    )
}
"""Every guard by its name in the tables."""

EXCLUSIVE = (("is_plan_done", *(guard.__name__ for guard in _PHASE_GUARDS)),)
"""Families of guards of which exactly one holds at any time, whatever the books."""
