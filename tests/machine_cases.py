"""What every declared transition must do, written by hand; numbers stand at the guards' boundaries."""

from __future__ import annotations

from collections.abc import Iterable

from machine_case import (
    ALIGNED,
    ASKEW,
    FAILED,
    ROUGH,
    Case,
    case,
    losing_frames,
    losing_motion,
    stopping,
)

# fmt: off

FOCUS = (
    case("focus/watching", "sharpness_measured", "is_sharp", "between", {"looks": 2}, {"sharp": True}),
    case("focus/watching", "sharpness_measured", "has_focus_looks_left & !is_sharp", "focus/watching",
         {"looks": 1}, {"sharp": False}, {"looks": 2}),
    case("focus/watching", "sharpness_measured", "!is_sharp & !has_focus_looks_left",
         FAILED + "camera_blurred",
         {"looks": 2}, {"sharp": False}),
    case("focus/watching", "focus_skipped", "", "between"),
    *losing_frames("focus/watching"),
)


def sweep(way: str, back: str, step: int, first: int) -> Iterable[Case]:
    """Figure 2 for one direction: boards change by `step`, the row's end in this direction is board
    `first`."""
    here = f"scan/{way}/"
    ahead, passing, sweeps = f"has_board_{way}", f"can_pass_{way}", "has_sweeps_left"
    inner, outside, behind = first - step, first + step, f"scan/{back}/searching"
    fresh = {"steps": 0, "angle": 0.0, "misses": 0, "views": 0}
    stale = {"steps": 3, "angle": 1.5, "misses": 1, "views": 4}
    for leaf in ("collecting", "doubting"):
        at = here + leaf
        yield case(at, "board_seen", "is_judgement_due", f"scan/judging/{way}", {"views": 4, "misses": 1},
                   {"fresh_views": 3}, {"views": 5, "misses": 0})
        yield case(at, "board_seen", "has_views_left & !is_judgement_due", here + "collecting",
                   {"views": 4, "misses": 1}, {"fresh_views": 2}, {"views": 5, "misses": 0})
        yield case(at, "board_seen", "!is_judgement_due & !has_views_left", FAILED + "not_turning",
                   {"views": 5}, {"fresh_views": 3})
        yield case(at, "board_missed", "has_misses_left", here + "doubting", {"misses": 0}, {}, {"misses": 1})
        yield case(at, "board_missed", f"{passing} & !has_misses_left", here + "searching",
                   {**stale, "board": inner}, {}, {**fresh, "board": first})
        yield case(at, "board_missed", f"{sweeps} & !has_misses_left & !{passing}", behind,
                   {**stale, "board": first, "changes": 0}, {}, {**fresh, "changes": 1})
        yield case(at, "board_missed", f"!has_misses_left & !{passing} & !{sweeps}", "scan/solving",
                   {"misses": 1, "board": first, "changes": 1})
        yield case(at, "next_board_seen", ahead, here + "collecting", {**stale, "board": inner}, {},
                   {**fresh, "board": first, "views": 1})
        yield case(at, "next_board_seen", f"{sweeps} & !{ahead}", behind,
                   {**stale, "board": first, "changes": 0}, {}, {**fresh, "changes": 1})
        yield case(at, "next_board_seen", f"!{ahead} & !{sweeps}", "scan/solving", {"board": first,
                   "changes": 1})
    at = here + "searching"
    for trigger in ("board_seen", "board_missed"):
        yield case(at, trigger, "is_sweep_over", "scan/solving", {"changes": 2, "board": outside})
        yield case(at, trigger, "is_past_end & !is_sweep_over", behind, {**stale, "changes": 0,
                   "board": outside}, {},
                   {**fresh, "changes": 1, "board": first})
    none = "!is_sweep_over & !is_past_end"
    yield case(at, "board_seen", none, here + "collecting", {**stale, "board": first, "changes": 1}, {},
               {**fresh, "views": 1})
    yield case(at, "board_missed", f"has_search_left & {none}", at, {"steps": 2, "angle": 1.5},
               {"turned": -0.25}, {"steps": 3, "angle": 1.75})
    spent = f"{none} & !has_search_left"
    yield case(at, "board_missed", f"is_camera_known & {spent}", "scan/solving", {"steps": 3, "cameras": 1},
               {"turned": 0.0})
    yield case(at, "board_missed", f"{spent} & !is_camera_known", FAILED + "board_missing", {"steps": 3},
               {"turned": 0.0})
    at = f"scan/judging/{way}"
    yield case(at, "views_judged", "is_camera_precise", "scan/solving", {"precise": 1}, {"precise": True})
    yield case(at, "views_judged", "!is_camera_precise", here + "collecting", {"precise": 0},
               {"precise": True}, {"precise": 1})
    yield case(at, "views_judged", "!is_camera_precise", here + "collecting", {"precise": 1},
               {"precise": False}, {"precise": 0})
    leaves = tuple(here + leaf for leaf in ("collecting", "doubting", "searching"))
    yield from losing_frames(here.rstrip("/"), *leaves)
    yield from losing_motion(here.rstrip("/"), *leaves)
    yield from stopping(*leaves, at)


SCAN = (
    case("scan/starting", "board_seen", "", "scan/clockwise/collecting", {"misses": 1}, {}, {"views": 1,
         "misses": 0}),
    case("scan/starting", "board_missed", "has_misses_left", "scan/starting", {"misses": 0}, {},
         {"misses": 1}),
    case("scan/starting", "board_missed", "is_at_last_board & !has_misses_left", "scan/clockwise/searching",
         {"misses": 1, "board": 2}, {}, {"misses": 0}),
    case("scan/starting", "board_missed", "!has_misses_left & !is_at_last_board",
         "scan/counterclockwise/searching",
         {"misses": 1, "board": 1}, {}, {"misses": 0}),
    *sweep("clockwise", "counterclockwise", -1, 0),
    *sweep("counterclockwise", "clockwise", +1, 2),
    case("scan/solving", "camera_solved", "", "between"),
    case("scan/solving", "camera_imprecise", "has_standpoints_left", "scan/moving", {"standpoints": 1}, {},
         {"standpoints": 2, "cameras": 1}),
    case("scan/solving", "camera_imprecise", "!has_standpoints_left", "between", {"standpoints": 2}),
    case("scan/solving", "camera_refused", "has_standpoints_left", "scan/moving", {"standpoints": 1}, {},
         {"standpoints": 2}),
    case("scan/solving", "camera_refused", "!has_standpoints_left", FAILED + "camera_refused",
         {"standpoints": 2}),
    case("scan/moving", "standpoint_reached", "", "scan/starting",
         {"changes": 2, "board": 3, "views": 2, "precise": 1}, {},
         {"changes": 0, "board": 2, "views": 0, "precise": 0}),
    *losing_frames("scan/starting"),
    *losing_motion("scan/moving"),
)


def squaring(prefix: str, done: str, entered: str = "") -> Iterable[Case]:
    """Turning along the markers under `prefix`, ending in `done`."""
    checking, turning = prefix + "checking", prefix + "turning"
    seeking, right, left = (f"{turning}/{leaf}" for leaf in ("seeking", "clockwise", "counterclockwise"))
    to_right, to_left = "can_turn_clockwise", "can_turn_counterclockwise"
    spent = f"!is_aligned & !{to_right} & !{to_left}"
    room, full = {"turns": 2, "overshoots": 1}, {"turns": 3, "overshoots": 1}
    yield case(checking, "marker_measured", "is_aligned", done, full, {"heading": -ALIGNED}, entered=entered)
    yield case(checking, "marker_measured", f"{to_right} & !is_aligned", right, room, {"heading": -0.06},
               {"turns": 3})
    yield case(checking, "marker_measured", f"{to_left} & !is_aligned & !{to_right}", left, room,
               {"heading": 0.06},
               {"turns": 3})
    yield case(checking, "marker_measured", f"is_roughly_aligned & {spent}", done, full, {"heading": ROUGH},
               entered=entered)
    yield case(checking, "marker_measured", f"{spent} & !is_roughly_aligned", FAILED + "not_aligning", full,
               {"heading": 0.21})
    yield case(seeking, "marker_seen", "is_aligned", checking, {}, {"heading": ALIGNED})
    yield case(seeking, "marker_seen", "is_marker_clockwise & !is_aligned", right, {}, {"heading": -0.06})
    yield case(seeking, "marker_seen", "!is_aligned & !is_marker_clockwise", left, {}, {"heading": 0.06})
    yield case(seeking, "marker_missed", "has_seeking_left", seeking, {"steps": 2, "angle": 2.0},
               {"turned": 0.5},
               {"steps": 3, "angle": 2.5})
    yield case(seeking, "marker_missed", "!has_seeking_left", FAILED + "marker_missing", {"steps": 3,
               "angle": 0.0})
    for here, sign in ((right, -1.0), (left, +1.0)):
        on = {"turns": 3}
        over = {"turns": 3, "overshoots": 2}
        yield case(here, "marker_seen", "is_aligned", checking, room, {"heading": sign * ALIGNED}, on)
        yield case(here, "marker_seen", f"{to_right} & !is_aligned", right, room, {"heading": -0.06},
                   on if here == right else over)
        yield case(here, "marker_seen", f"{to_left} & !is_aligned & !{to_right}", left, room,
                   {"heading": 0.06},
                   on if here == left else over)
        yield case(here, "marker_seen", f"is_roughly_aligned & {spent}", checking, full,
                   {"heading": sign * ROUGH},
                   {"turns": 4})
        yield case(here, "marker_seen", f"{spent} & !is_roughly_aligned", FAILED + "not_aligning",
                   {"turns": 1, "overshoots": 2}, {"heading": sign * 0.21})
    for here in (checking, right, left):
        yield case(here, "marker_missed", "has_recoveries_left", seeking,
                   {"recoveries": 1, "steps": 3, "angle": 1.0, "misses": 1}, {},
                   {"recoveries": 2, "steps": 0, "angle": 0.0, "misses": 0})
        yield case(here, "marker_missed", "!has_recoveries_left", FAILED + "marker_missing",
                   {"recoveries": 2})
    yield from losing_frames(checking)
    yield from losing_frames(turning, seeking, right, left)
    yield from losing_motion(turning, seeking, right, left)
    yield from stopping(checking, seeking, right, left)


ORIENTATION = tuple(squaring("orientation/", "between"))

BEGUN = {"recoveries": 2, "turns": 0, "overshoots": 0, "steps": 0, "angle": 0.0, "misses": 0}
USED = {"recoveries": 1, "turns": 2, "overshoots": 1, "steps": 2, "angle": 1.0, "misses": 1}

WHEELS = (
    case("wheels/measuring", "marker_measured", "is_square", "wheels/forward", {}, {"heading": -0.3}),
    case("wheels/measuring", "marker_measured", "has_recoveries_left & !is_square", "wheels/squaring", USED,
         {"heading": ASKEW}, BEGUN, entered="wheels/squaring/checking"),
    case("wheels/measuring", "marker_measured", "!is_square & !has_recoveries_left", FAILED + "not_aligning",
         {"recoveries": 2}, {"heading": -ASKEW}),
    case("wheels/measuring", "marker_missed", "has_recoveries_left", "wheels/squaring/turning/seeking",
         USED, {}, BEGUN),
    case("wheels/measuring", "marker_missed", "!has_recoveries_left", FAILED + "marker_missing",
         {"recoveries": 2}),
    case("wheels/forward", "drive_finished", "", "wheels/comparing"),
    case("wheels/comparing", "ratio_measured", "", "wheels/back"),
    case("wheels/comparing", "marker_missed", "has_recoveries_left", "wheels/returning", {"recoveries": 1},
         {},
         {"recoveries": 2}),
    case("wheels/comparing", "marker_missed", "!has_recoveries_left", FAILED + "marker_missing",
         {"recoveries": 2}),
    case("wheels/back", "drive_finished", "", "wheels/updating"),
    case("wheels/returning", "drive_finished", "", "wheels/measuring"),
    case("wheels/updating", "ratio_updated", "is_settled", "between", {"quiet": 2, "iterations": 4},
         {"quiet": True},
         {"quiet": 3, "iterations": 5}),
    case("wheels/updating", "ratio_updated", "has_iterations_left & !is_settled", "wheels/measuring",
         {"quiet": 1, "iterations": 3}, {"quiet": True}, {"quiet": 2, "iterations": 4}),
    case("wheels/updating", "ratio_updated", "has_iterations_left & !is_settled", "wheels/measuring",
         {"quiet": 2, "iterations": 3}, {"quiet": False}, {"quiet": 0, "iterations": 4}),
    case("wheels/updating", "ratio_updated", "!is_settled & !has_iterations_left",
         FAILED + "wheels_not_settling",
         {"quiet": 2, "iterations": 4}, {"quiet": False}),
    *squaring("wheels/squaring/", "wheels/measuring"),
    *losing_frames("wheels/measuring"),
    *losing_frames("wheels/comparing"),
    *losing_motion("wheels/forward"),
    *losing_motion("wheels/comparing"),
    *losing_motion("wheels/back"),
    *losing_motion("wheels/returning"),
)

EXIT = (
    *squaring("exit/squaring/", "exit/leaving"),
    case("exit/leaving", "marker_seen", "has_leaving_left", "exit/leaving", {"leaving": 2, "misses": 1},
         {"heading": 0.0},
         {"leaving": 3, "misses": 0}),
    case("exit/leaving", "marker_seen", "!has_leaving_left", FAILED + "field_not_left", {"leaving": 3}),
    case("exit/leaving", "marker_missed", "has_misses_left", "exit/leaving", {"misses": 0}, {},
         {"misses": 1}),
    case("exit/leaving", "marker_missed", "!has_misses_left", "exit/handing", {"misses": 1}),
    case("exit/handing", "control_handed", "", "between"),
    *losing_frames("exit/leaving"),
    *losing_motion("exit/leaving"),
)

LANE = (
    case("lane/seeking", "lane_seen", "", "lane/following", {"misses": 1}, {}, {"misses": 0}),
    case("lane/seeking", "lane_missed", "has_seeking_left", "lane/seeking", {"steps": 2, "angle": 2.0},
         {"turned": -0.5},
         {"steps": 3, "angle": 2.5}),
    case("lane/seeking", "lane_missed", "!has_seeking_left", FAILED + "lane_missing", {"steps": 2,
         "angle": 2.0},
         {"turned": 1.0}),
    case("lane/following", "lane_followed", "has_following_left", "lane/following", {"following": 2,
         "misses": 1}, {},
         {"following": 3, "misses": 0}),
    case("lane/following", "lane_followed", "!has_following_left", FAILED + "marker_missing",
         {"following": 3}),
    case("lane/following", "lane_missed", "has_misses_left", "lane/following", {"misses": 0}, {},
         {"misses": 1}),
    case("lane/following", "lane_missed", "has_recoveries_left & !has_misses_left", "lane/seeking",
         {"misses": 1, "recoveries": 1, "steps": 2, "angle": 1.0}, {},
         {"misses": 0, "recoveries": 2, "steps": 0, "angle": 0.0}),
    case("lane/following", "lane_missed", "!has_misses_left & !has_recoveries_left", FAILED + "lane_missing",
         {"misses": 1, "recoveries": 2}),
    case("lane/following", "first_marker_seen", "", "lane/squaring",
         {"turns": 2, "overshoots": 1, "steps": 1, "angle": 1.0, "misses": 1}, {},
         {"turns": 0, "overshoots": 0, "steps": 0, "angle": 0.0, "misses": 0},
         entered="lane/squaring/checking"),
    *squaring("lane/squaring/", "lane/straight"),
    case("lane/straight", "next_marker_reached", "", "lane/refining"),
    case("lane/straight", "marker_missed", "", "lane/judging"),
    case("lane/refining", "marker_missed", "", "lane/judging"),
    case("lane/refining", "ratio_measured", "has_markers_left", "lane/squaring",
         {"markers": 1, "turns": 2, "overshoots": 1, "steps": 1, "angle": 1.0, "misses": 1}, {},
         {"markers": 2, "turns": 0, "overshoots": 0, "steps": 0, "angle": 0.0, "misses": 0},
         entered="lane/squaring/checking"),
    case("lane/refining", "ratio_measured", "!has_markers_left", "lane/judging", {"markers": 2}, {},
         {"markers": 3}),
    case("lane/judging", "ratio_applied", "", "between"),
    case("lane/judging", "ratio_kept", "", "between"),
    *losing_frames("lane/seeking"),
    *losing_frames("lane/following"),
    *losing_frames("lane/straight"),
    *losing_frames("lane/refining"),
    *losing_motion("lane/seeking"),
    *losing_motion("lane/following"),
    *losing_motion("lane/straight"),
)

FIRST_LEAF = {
    "focus": "focus/watching", "scan": "scan/starting", "orientation": "orientation/turning/seeking",
    "wheels": "wheels/measuring", "exit": "exit/squaring/checking", "lane": "lane/seeking",
}
DIRTY = {"board": 2, "changes": 2, "misses": 1, "views": 1, "steps": 1, "angle": 1.0, "turns": 1,
"overshoots": 1,
         "standpoints": 2, "looks": 1, "iterations": 1, "quiet": 1, "leaving": 1, "following": 1,
         "markers": 1,
         "recoveries": 1}
CLEAN = {**dict.fromkeys(DIRTY, 0), "board": 1, "angle": 0.0, "standpoints": 1}

SUPERVISOR = (
    *(case("between", "wheels_stopped", f"is_next_{phase}", phase,
           {**DIRTY, "plan": [phase, "later"], "phase": "earlier"}, {},
           {**CLEAN, "plan": ["later"], "phase": phase}, entered=leaf)
      for phase, leaf in FIRST_LEAF.items()),
    case("between", "wheels_stopped", "is_plan_done", "done", {**DIRTY, "plan": [], "phase": "lane"}, {},
         {**CLEAN, "board": 0, "phase": ""}),
    *stopping("between", "focus/watching", "scan/starting", "scan/solving", "scan/moving", "wheels/measuring",
              "wheels/forward", "wheels/comparing", "wheels/back", "wheels/updating", "wheels/returning",
              "exit/leaving", "exit/handing", "lane/seeking", "lane/following", "lane/straight",
              "lane/refining",
              "lane/judging"),
)

CASES = (*SUPERVISOR, *FOCUS, *SCAN, *ORIENTATION, *WHEELS, *EXIT, *LANE)
