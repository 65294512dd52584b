"""The exit (paper, section 5.1): stand along the markers again, drive straight until the last one is out of
sight.

The paper's four steps: orient coaxially, move straight while a marker is in the frame, stop, hand over the
control. One missed detection does not end the drive: `misses_before_lost` misses in a row do.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses, motion_losses
from fsm_calib.machines.squaring import SQUARING_STATES, squaring_transitions
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

EXIT = Chart(
    name="exit",
    about="Square up, drive straight out of the marker field, hand over.",
    states=(
        State("squaring", "Turn along the markers, as in orientation.", children=SQUARING_STATES),
        State("leaving", "Drive straight while a marker is in sight.", do="drive_off"),
        State("handing", "Stop and hand the robot over to its own controller.", do="hand_over"),
    ),
    transitions=(
        *squaring_transitions("squaring/", done="leaving"),
        *choose("marker_seen", "leaving",
                when("has_leaving_left", "leaving", "count_leaving"),
                otherwise("/failed/field_not_left")),
        *choose("marker_missed", "leaving",
                when("has_misses_left", "leaving", "count_miss"),
                otherwise("handing")),
        *always("control_handed", "handing", "/between"),
        *camera_losses("leaving"),
        *motion_losses("leaving"),
    ),
)  # fmt: skip
