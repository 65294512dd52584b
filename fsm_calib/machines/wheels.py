"""The wheel iteration (paper, section 3.4): shuttle over the markers until the robot drives straight.

One iteration: nearest marker, forward for t, nearest marker again, k_i from the change of its angle, back for
t with the k that was used forward, then k <- k + (k_i - 1) / 2 unless the correction is small (a quiet
iteration). Three quiet iterations in a row end it. A robot that stands askew is squared up before the next
drive; a marker that is not there after the drive is looked for again after driving back.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses, motion_losses
from fsm_calib.machines.squaring import SQUARING_STATES, squaring_transitions
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

WHEELS = Chart(
    name="wheels",
    about="Forward and back over the markers; refine the wheel ratio k until three iterations are quiet.",
    states=(
        State("measuring", "Measure the nearest marker before the drive.", do="measure_marker"),
        State("forward", "Drive forward for the set time with the k so far.", do="drive_forward"),
        State("comparing", "Measure the nearest marker again: k_i.", do="measure_ratio"),
        State("back", "Drive back for the same time with the same k.", do="drive_back"),
        State("updating", "Refine k, or count a quiet iteration.", do="update_ratio"),
        State("returning", "No marker after the drive: back to where one was.", do="drive_back"),
        State("squaring", "The robot stands askew: turn along the markers, as in orientation.",
              children=SQUARING_STATES),
    ),
    transitions=(
        *choose("marker_measured", "measuring",
                when("is_square", "forward"),
                when("has_recoveries_left", "squaring", "count_recovery", "begin_squaring"),
                otherwise("/failed/not_aligning")),
        *choose("marker_missed", "measuring",
                when("has_recoveries_left", "squaring/turning/seeking", "count_recovery", "begin_squaring"),
                otherwise("/failed/marker_missing")),
        *always("drive_finished", "forward", "comparing"),
        *always("ratio_measured", "comparing", "back"),
        *choose("marker_missed", "comparing",
                when("has_recoveries_left", "returning", "count_recovery"),
                otherwise("/failed/marker_missing")),
        *always("drive_finished", "back", "updating"),
        *always("drive_finished", "returning", "measuring"),
        *choose("ratio_updated", "updating",
                when("is_settled", "/between", "count_iteration"),
                when("has_iterations_left", "measuring", "count_iteration"),
                otherwise("/failed/wheels_not_settling")),
        *squaring_transitions("squaring/", done="measuring"),
        *camera_losses("measuring", "comparing"),
        *motion_losses("forward", "comparing", "back", "returning"),
    ),
)  # fmt: skip
