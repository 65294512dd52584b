"""What tyres does the robot stand on? Their grip, slip ratio and softness are free where recordings ask for it.

Where tyres slip at every reversal their friction coefficient shows, and one that is off by a third looks like a limit
of the motors' current, a scrub or a drag. Where they hardly slip it shows in nothing, and only lends itself to what
slips in a single place. So it is free where that has strong evidence, and keeps it beside the place on the
floor that explains more: a slippery spot does most of the job of a smaller grip of the whole floor.

Where wheels are measured beside the poses, the tyres' slip shows by itself, and whether it grows with the rolling
speed (rubber's does, that of the contacts of many simulators does not). A ratio of a tenth that is left out costs 20 to
300 units of likelihood, spread over all that drives. Without encoders it could only stand in for a drift in curves, and
is held. So does how soft they are: tyres that creep forty times as much as a small robot's usual ones (Box2D) had 354
units less for the prior of their slip speed, and what that held back had no name.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.free_number import (
    NEEDED,
    STEPS,
    evidence_of_freed,
    found_free,
    unless_stood_in,
    with_free,
)
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE, grip_slot, have_encoders, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import with_slots
from fsm_calib.world2d.parameters import parameter_table

GRIPS = (0.35, 0.55, 0.9)  # 1: a tyre that hardly slips has no derivative to go by
RATIOS = (0.1,)  # 1: nor has a ratio of 0
RATIO = "slip_ratio"
SOFTER = (1.0, 4.0)  # of the slip speed under its prior: tyres that are far softer lie beyond a few steps


def with_tyres(engine: Engine, base: Fit, places: Rivals, lasting: Rivals) -> Fit:
    """Return the base with the grip, slip ratio and softness of its tyres free where each has strong evidence.

    places : effects of single places, which are asked whether they do as well as another grip; lasting : others,
    whether they do as well as softer tyres: play of 0.8 rad between an encoder and its wheel had been tyres of 16 times
    the usual slip, and a tenth of that play in the other wheel.
    """
    gripped = unless_stood_in(engine, base, lambda fit: with_free_grip(engine, fit), places)
    rolling = with_slip_ratio(engine, gripped, places)
    return unless_stood_in(engine, rolling, lambda fit: with_soft_tyres(engine, fit), lasting)


def with_soft_tyres(engine: Engine, fit: Fit) -> Fit:
    """Return a fit whose tyres' slip speed has no prior, where wheels were measured and ask for another strongly.

    2 (score without it - score with it) - ln N >= NEEDED; asked where ((s0 - centre) / spread)^2 is as much, s0 [m/s]
    the slip speed, N innovations.
    """
    place = parameter_table().place("slip_speed")
    row = next((i for i, slot in enumerate(fit.slots) if slot.place == place and slot.spread > 0.0), None)
    if row is None or not have_encoders(engine.simulators):
        return fit
    slot, found = fit.slots[row], float(fit.values[0, place])
    cost = NEEDED + float(np.log(engine.count))
    if ((found - slot.centre) / slot.spread) ** 2 < cost:
        return fit
    free = replace(slot, spread=0.0)
    slots = (*fit.slots[:row], free, *fit.slots[row + 1 :])
    starts = [with_slots(fit.values, [free], np.array([min(k * found, free.high)])) for k in SOFTER]
    best = max((engine.fit(start, slots, fit.noise, steps=STEPS) for start in starts), key=lambda f: f.score)
    best = engine.refit_noise(best, SPEED_NOISE, 3)
    best = engine.fit(best.values, best.slots, best.noise, steps=STEPS)
    return best if 2.0 * (best.score - fit.score) >= cost else fit


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
