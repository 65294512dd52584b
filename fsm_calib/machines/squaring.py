"""Turning until the robot stands along the floor markers: the part that four machines share.

The paper uses "exactly the same approach" in 3.3, 5.1 and 5.2: turn step by step, clockwise or
counter-clockwise, until the angle of the marker is smallest. Overshoot reverses the direction; `checking`
measures at rest, over several frames, before the machine believes that it stands well. When the turns are
spent, an angle that is roughly good is good enough; otherwise the machine ends with the reason.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses, motion_losses
from fsm_calib.statechart.spec import Branch, State, Transition, choose, otherwise, when

CHECKING = State("checking", "Measure the nearest marker at rest.", do="measure_marker")
TURNING = State("turning", "Turn, one step and one frame at a time.", children=(
    State("seeking", "Turn until a marker comes into sight.", do="turn_to_marker"),
    State("clockwise", "Turn clockwise, a small step at a time.", do="turn_clockwise"),
    State("counterclockwise", "Turn counter-clockwise, a small step at a time.", do="turn_counterclockwise"),
))  # fmt: skip
SQUARING_STATES = (CHECKING, TURNING)


def squaring_transitions(prefix: str, done: str) -> tuple[Transition, ...]:
    """Return the transitions of the states above, placed under `prefix` (with its ``/``), to `done`."""
    checking, turning = f"{prefix}checking", f"{prefix}turning"
    seeking, clockwise, counterclockwise = (f"{turning}/{state.name}" for state in TURNING.children)
    return (
        *choose("marker_measured", checking,
                when("is_aligned", done),
                *_turns(clockwise, counterclockwise, "count_turn"),
                when("is_roughly_aligned", done),
                otherwise("/failed/not_aligning")),
        *choose("marker_seen", seeking,
                when("is_aligned", checking),
                when("is_marker_clockwise", clockwise),
                otherwise(counterclockwise)),
        *choose("marker_missed", seeking,
                when("has_seeking_left", seeking, "count_seeking"),
                otherwise("/failed/marker_missing")),
        *_stepping(clockwise, checking, clockwise, counterclockwise),
        *_stepping(counterclockwise, checking, clockwise, counterclockwise),
        *choose("marker_missed", (checking, clockwise, counterclockwise),
                when("has_recoveries_left", seeking, "count_recovery"),
                otherwise("/failed/marker_missing")),
        *camera_losses(checking, turning),
        *motion_losses(turning),
    )  # fmt: skip


def _turns(clockwise: str, counterclockwise: str, first: str, second: str = "") -> tuple[Branch, Branch]:
    return (
        when("can_turn_clockwise", clockwise, first),
        when("can_turn_counterclockwise", counterclockwise, second or first),
    )


def _stepping(source: str, checking: str, clockwise: str, counterclockwise: str) -> tuple[Transition, ...]:
    """Return what a marker in sight leads to while turning: a change of direction is an overshoot."""
    on, over = "count_turn", "count_overshoot"
    turns = _turns(clockwise, counterclockwise, *((on, over) if source == clockwise else (over, on)))
    return choose(
        "marker_seen",
        source,
        when("is_aligned", checking, on),
        *turns,
        when("is_roughly_aligned", checking, on),
        otherwise("/failed/not_aligning"),
    )
