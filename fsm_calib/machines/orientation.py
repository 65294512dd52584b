"""Orientation (paper, section 3.3): turn to the floor markers until the robot stands along them."""

from __future__ import annotations

from fsm_calib.machines.squaring import CHECKING, TURNING, squaring_transitions
from fsm_calib.statechart.spec import Chart

ORIENTATION = Chart(
    name="orientation",
    about="Turn step by step to the first marker, then to the smallest marker angle.",
    states=(TURNING, CHECKING),
    transitions=squaring_transitions("", done="/between"),
)
