"""What tyres does the robot stand on? Their grip and slip ratio are free where recordings ask for it.

Where tyres slip at every reversal their friction coefficient shows, and one that is off by a third looks like a limit
of the motors' current, a scrub or a drag. Where they hardly slip it shows in nothing, and only lends itself to what
slips in a single place. So it is free where that has strong evidence, and keeps it beside the place on the
floor that explains more: a slippery spot does most of the job of a smaller grip of the whole floor.

Where wheels are measured beside the poses, the tyres' slip shows by itself, and whether it grows with the rolling
speed (rubber's does, that of the contacts of many simulators does not). A ratio of a tenth that is left out costs 20 to
300 units of likelihood, spread over all that drives. Without encoders it could only stand in for a drift in curves, and
is held.
"""

from __future__ import annotations

from fsm_calib.diagnosis.candidates.free_number import (
    NEEDED,
    evidence_of_freed,
    found_free,
    unless_stood_in,
    with_free,
)
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import grip_slot, have_encoders, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit

GRIPS = (0.35, 0.55, 0.9)  # 1: a tyre that hardly slips has no derivative to go by
RATIOS = (0.1,)  # 1: nor has a ratio of 0
RATIO = "slip_ratio"


def with_tyres(engine: Engine, base: Fit, places: Rivals) -> Fit:
    """Return the base with the grip and the slip ratio of its tyres free where each has strong evidence.

    places : effects of single places, which are asked whether they do as well as another grip.
    """
    gripped = unless_stood_in(engine, base, lambda fit: with_free_grip(engine, fit), places)
    return with_slip_ratio(engine, gripped, places)


def with_slip_ratio(engine: Engine, fit: Fit, _: Rivals) -> Fit:
    """Return a fit with the tyres' slip ratio free where wheels were measured and it has strong evidence.

    Asked beside the first effect, too: one that is late hides it, and a ratio that is left out makes poses late.
    """
    if not have_encoders(engine.simulators) or found_free(fit, RATIO):
        return fit
    rolling = with_free(engine, fit, [slot_of(RATIO)], RATIOS)
    return rolling if evidence_of_freed(engine, rolling, fit) >= NEEDED else fit


def with_free_grip(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with the tyres' grip free as well."""
    return with_free(engine, fit, [grip_slot(fit.values[0])], GRIPS)
