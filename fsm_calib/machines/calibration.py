"""The calibration as one value: the supervisor with everything that its tables name."""

from __future__ import annotations

from pathlib import Path

from fsm_calib.machines.activities import CONTRACT
from fsm_calib.machines.bookkeeping import ACTIONS
from fsm_calib.machines.books import Books
from fsm_calib.machines.check import SAMPLES, SMALL
from fsm_calib.machines.guards import EXCLUSIVE, GUARDS
from fsm_calib.machines.limits import PUBLISHED, Limits
from fsm_calib.machines.losses import STREAKS
from fsm_calib.machines.supervisor import SUPERVISOR
from fsm_calib.statechart.machinery import Machinery

SHIPPED = Path(__file__).parents[1] / "_shipped" / "diagrams"
COMMITTED = SHIPPED if SHIPPED.is_dir() else Path(__file__).parents[2] / "diagrams"
"""The project's own diagrams: in an installed wheel, or at the top of the source tree."""

CALIBRATION = Machinery(
    root=SUPERVISOR,
    guards=GUARDS,
    actions=ACTIONS,
    contract=CONTRACT,
    books=Books,
    limits=Limits,
    exclusive=EXCLUSIVE,
    streaks=STREAKS,
    briefed=("boards",),
    published=PUBLISHED,
    samples=SAMPLES,
    small=SMALL,
    shared=("squaring",),
    home="fsm_calib/machines/",
    limits_home="fsm_calib/machines/limits.py",
    drawn=COMMITTED,
)
"""What `fsm-calib run` runs."""
