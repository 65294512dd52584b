"""The focus step before the calibration (paper, chapter 6): sharpness now and the best so far.

The lens is turned by hand, so the machine only watches: it ends when the picture is sharp, when the operator
(or the scenario) skips the step, or when its looks are spent.
"""

from __future__ import annotations

from fsm_calib.machines.losses import camera_losses
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

FOCUS = Chart(
    name="focus",
    about="Watch the sharpness while the operator turns the lens; may be skipped.",
    states=(
        State("watching", "Show the sharpness now and the best so far.", do="measure_sharpness"),
    ),
    transitions=(
        *choose("sharpness_measured", "watching",
                when("is_sharp", "/between"),
                when("has_focus_looks_left", "watching", "count_look"),
                otherwise("/failed/camera_blurred")),
        *always("focus_skipped", "watching", "/between"),
        *camera_losses("watching"),
    ),
)  # fmt: skip
