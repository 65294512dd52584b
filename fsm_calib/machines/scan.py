"""The camera scan (paper, section 3.2 and Figure 2): turn from board to board, keep the views, solve the
camera.

The paper's state is (board, direction, visible, recovery). Direction and the two flags are states here, the
board's number is in the books:

    collecting   visible, no recovery: every step keeps a view of this board
    doubting     not visible, no recovery: missed, but fewer times in a row than `misses_before_lost`
    searching    recovery: the board is lost, turn on to the next one (or back to it at the end of the row)
    judging      the robot stands: is the camera known well enough from the views so far?

Boards are numbered from 0 counter-clockwise, so turning clockwise leads to lower numbers. The scan begins
clockwise, and each time the row's end is reached the direction changes: P full sweeps end at change P + 1. As
published, a single miss loses the board, the end is noticed one cycle late and one more step is made after
the last change; the limits `misses_before_lost` and `late_bound_check` choose.

The paper ends by the count of sweeps alone. Here the count is a budget: every `views_per_judgement` views the
camera is solved, and when its predicted error was small enough so many times in a row (`precise_judgements`)
the scan is over. When the sweeps are spent and the camera is not precise, the boards are scanned from another
standpoint, as long as there are any left. A board that is not found again from there ends only the search: a
camera is known already.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses, motion_losses
from fsm_calib.statechart.spec import Chart, State, Transition, always, choose, otherwise, when

DIRECTIONS = ("clockwise", "counterclockwise")


def _sweep_states(way: str) -> State:
    return State(way, f"Turn {way}, one step and one frame at a time.", children=(
        State("collecting", "The board is in sight: keep its views.", do=f"step_{way}"),
        State("doubting", "The board was missed: not yet lost.", do=f"step_{way}"),
        State("searching", "The board is lost: turn on until one is found.", do=f"search_{way}"),
    ))  # fmt: skip


def _sweep(way: str, back: str) -> tuple[Transition, ...]:
    """Return the rules of Figure 2 for one direction; `back` is the other one."""
    collecting, doubting, searching = f"{way}/collecting", f"{way}/doubting", f"{way}/searching"
    judging, looking = f"judging/{way}", (collecting, doubting)
    return (
        *choose("board_seen", looking,
                when("is_judgement_due", judging, "count_view"),
                when("has_views_left", collecting, "count_view"),
                otherwise("/failed/not_turning")),
        *choose("views_judged", judging,
                when("is_camera_precise", "solving"),
                otherwise(collecting, "count_judgement")),
        *choose("board_missed", looking,
                when("has_misses_left", doubting, "count_miss"),
                when(f"can_pass_{way}", searching, f"pass_board_{way}"),
                when("has_sweeps_left", f"{back}/searching", "turn_back"),
                otherwise("solving")),
        *choose("next_board_seen", looking,
                when(f"has_board_{way}", collecting, f"pass_board_{way}", "count_view"),
                when("has_sweeps_left", f"{back}/searching", "turn_back"),
                otherwise("solving")),
        *choose("board_seen", searching,
                when("is_sweep_over", "solving"),
                when("is_past_end", f"{back}/searching", "return_to_row"),
                otherwise(collecting, "begin_collecting")),
        *choose("board_missed", searching,
                when("is_sweep_over", "solving"),
                when("is_past_end", f"{back}/searching", "return_to_row"),
                when("has_search_left", searching, "count_search"),
                when("is_camera_known", "solving"),
                otherwise("/failed/board_missing")),
    )  # fmt: skip


SCAN = Chart(
    name="scan",
    about="Turn from board to board and back, keep the views, solve the camera.",
    states=(
        State("starting", "Look for the board the robot was placed in front of.", do="look_for_board"),
        _sweep_states("clockwise"),
        _sweep_states("counterclockwise"),
        State("judging", "Ask whether the views so far suffice.", children=tuple(
            State(way, f"Then turn on {way}.", do="judge_views") for way in DIRECTIONS
        )),
        State("solving", "Compute the camera's intrinsics from the views.", do="solve_camera"),
        State("moving", "Drive to another standpoint, for views from elsewhere.", do="move_to_standpoint"),
    ),
    transitions=(
        *always("board_seen", "starting", "clockwise/collecting", "count_view"),
        *choose("board_missed", "starting",
                when("has_misses_left", "starting", "count_miss"),
                when("is_at_last_board", "clockwise/searching", "begin_search"),
                otherwise("counterclockwise/searching", "begin_search")),
        *_sweep("clockwise", back="counterclockwise"),
        *_sweep("counterclockwise", back="clockwise"),
        *always("camera_solved", "solving", "/between"),
        *choose("camera_imprecise", "solving",
                when("has_standpoints_left", "moving", "count_standpoint", "count_camera"),
                otherwise("/between")),
        *choose("camera_refused", "solving",
                when("has_standpoints_left", "moving", "count_standpoint"),
                otherwise("/failed/camera_refused")),
        *always("standpoint_reached", "moving", "starting", "begin_sweep"),
        *camera_losses("starting", *DIRECTIONS),
        *motion_losses(*DIRECTIONS, "moving"),
    ),
)  # fmt: skip
