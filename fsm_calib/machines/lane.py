"""The refinement in the lane (paper, section 5.2): k is measured again while the robot goes about its task.

The robot follows the lane until it sees the marker with the reserved number, squares up, drives straight to
the next marker, measures, squares up again, and so on over all markers. Then it judges: a new k is applied
only when the measurements agree with one another and differ significantly from the k in use.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses, motion_losses
from fsm_calib.machines.squaring import SQUARING_STATES, squaring_transitions
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

LANE = Chart(
    name="lane",
    about="Follow the lane; over the marked section measure k again; apply it when it is constant and new.",
    states=(
        State("seeking", "Turn until the lane is in sight.", do="seek_lane"),
        State("following", "Follow the lane until the reserved marker.", do="follow_lane"),
        State("squaring", "Turn along the marker, as in orientation.", children=SQUARING_STATES),
        State("straight", "Drive straight to the next marker.", do="drive_to_next_marker"),
        State("refining", "Measure the marker: one more k_i.", do="refine_ratio"),
        State("judging", "Apply the new k only when it is constant and differs.", do="judge_refinement"),
    ),
    transitions=(
        *always("lane_seen", "seeking", "following", "begin_following"),
        *choose("lane_missed", "seeking",
                when("has_seeking_left", "seeking", "count_seeking"),
                otherwise("/failed/lane_missing")),
        *choose("lane_followed", "following",
                when("has_following_left", "following", "count_following"),
                otherwise("/failed/marker_missing")),
        *choose("lane_missed", "following",
                when("has_misses_left", "following", "count_miss"),
                when("has_recoveries_left", "seeking", "count_recovery"),
                otherwise("/failed/lane_missing")),
        *always("first_marker_seen", "following", "squaring", "begin_squaring"),
        *squaring_transitions("squaring/", done="straight"),
        *always("next_marker_reached", "straight", "refining"),
        *always("marker_missed", ("straight", "refining"), "judging"),
        *choose("ratio_measured", "refining",
                when("has_markers_left", "squaring", "count_marker", "begin_squaring"),
                otherwise("judging", "count_marker")),
        *always("ratio_applied", "judging", "/between"),
        *always("ratio_kept", "judging", "/between"),
        *camera_losses("seeking", "following", "straight", "refining"),
        *motion_losses("seeking", "following", "straight"),
    ),
)  # fmt: skip
