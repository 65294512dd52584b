"""A controller as firmware usually has one, whose integral and supply end, tried whole.

Firmware holds the integral within bounds, so that it cannot wind up far: a load that asks for more slows the wheels.
Where a heavy load stands on the wheels (twin tyres that scrub), a controller shows by what it cannot do: its integral
ends, the supply ends, and without both a fit makes the supply end below full command and leaves the integral out. No
number of the four leads to the others. So the robot's other numbers are fitted first beside a usual controller, which
is then set free: beside scrub 2,010 units of log-likelihood, where an integral alone has 90 and the short supply 850
(true in brackets: integral 2.3 1/s (2.3), ending at 0.14 (0.18) of full command, the supply at 1.18 (1.24)).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.free_number import (
    NEEDED,
    STEPS,
    SURE,
    found_free,
    unless_stood_in,
    with_held,
)
from fsm_calib.diagnosis.candidates.ranked import evidence_of
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import CLEARLY, HOLD, SLOWEST, is_clear, with_likelier_rest
from fsm_calib.diagnosis.candidates.supply_end import CEILING, LOOP
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE, settled, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot, with_slots
from fsm_calib.world2d.effects.speed_controller import EFFECT
from fsm_calib.world2d.effects.speed_loop import AMPLE, NEVER

MOST = f"{EFFECT.name}.most"
LEAST = {HOLD: SLOWEST, MOST: 0.03, CEILING: AMPLE, LOOP: 0.3}
"""Numbers of a controller (1/s, else 1) with the least of each: an integral that ends at once is a dry friction."""
WITHOUT = {CEILING: {CEILING: NEVER, LOOP: EFFECT.parameter("loop").null}, MOST: {MOST: NEVER}}
"""Ends of a controller, with the numbers of one that has none: a supply that is short is a finding, no controller."""
USUAL = ((2.0, 0.1, 1.25, 1.5), (2.0, 0.2, 1.25, 1.5), (4.0, 0.2, 1.25, 1.5))
"""Usual controllers, of which the one that does best beside all others is set free."""
FAR_BELOW = (
    100.0  # log-likelihood units: held on robots told duties it costs 330 to 4,900, on others 40 at most
)
FIRST_STEPS = 2  # Gauss-Newton steps after which the one that promises most shows


def with_usual_loop(engine: Engine, fit: Fit, rivals: Rivals, asked_again: bool = False) -> Fit:
    """Return a fit with a controller whose integral and supply end, where that has strong evidence over one that has
    no such ends or over none.

    rivals : effects that are asked whether one does as well; asked_again : as `unless_stood_in` has it.
    """

    def freed(fit: Fit) -> Fit:
        if not _may_have_one(engine, fit):
            return fit
        free = _with_all_free(engine, _beside_a_usual_one(engine, fit))
        if any(most <= CLEARLY * LEAST[MOST] for _, most, _ in found_free(free, MOST)):
            return fit
        for name, bare in WITHOUT.items():
            free = _unless_idle(engine, free, name, bare)
        has_ends = any(found_free(free, name) for name in WITHOUT)
        return with_likelier_rest(engine, free) if has_ends and is_clear(engine, free, fit) else fit

    return unless_stood_in(engine, fit, freed, rivals, asked_again=asked_again)


def _may_have_one(engine: Engine, fit: Fit) -> bool:
    """Return whether a robot is not far worse off with a usual controller than with none."""
    begun = max(_beside_usual_ones(engine, fit, FIRST_STEPS), key=lambda one: one.score)
    return engine.fit(begun.values, begun.slots, begun.noise, steps=STEPS).score > fit.score - FAR_BELOW


def _beside_a_usual_one(engine: Engine, fit: Fit) -> Fit:
    """Return a fit whose numbers, and the noise of speeds, are those beside the usual controller that does best."""
    best = max(_beside_usual_ones(engine, fit, STEPS), key=lambda one: one.score)
    return engine.refit_noise(best, SPEED_NOISE, 3)


def _beside_usual_ones(engine: Engine, fit: Fit, steps: int) -> list[Fit]:
    tried = [with_slots(fit.values, _slots(), np.array(usual)) for usual in USUAL]
    return [engine.fit(values, fit.slots, fit.noise, steps=steps) for values in tried]


def _with_all_free(engine: Engine, held: Fit) -> Fit:
    taken = {slot.place for slot in held.slots}
    further = (slot for slot in _slots() if slot.place not in taken)
    return settled(engine, engine.fit(held.values, (*held.slots, *further), held.noise))


def _slots() -> list[Slot]:
    return [replace(slot_of(name), low=low) for name, low in LEAST.items()]


def _unless_idle(engine: Engine, free: Fit, name: str, without: Mapping[str, float]) -> Fit:
    """Return a fit without an end that rests at its least, that is out of reach, or that no drive needs.

    without : numbers of a controller that has no such end. Its covariance cannot tell: an end comes down until the one
    moment feels it that reaches farthest.
    """
    [(_, value, _)] = found_free(free, name)
    bare = free
    for held, number in without.items():
        bare = with_held(bare, held, number)
    bare = settled(engine, engine.fit(bare.values, bare.slots, bare.noise))
    ends = LEAST[name] < value < NEVER / CLEARLY
    return free if ends and evidence_of(free, bare, engine.count) >= NEEDED else bare


def integral_told(fit: Fit) -> list[str]:
    """Return a sentence where the integral of a robot that holds its speeds was seen to end."""
    return [
        f"the controller's integral ends at {value:.2f} +- {sd:.2f} of full command: larger loads slow this robot down"
        for _, value, sd in found_free(fit, MOST)
        if NEVER - value > SURE * sd
    ]
