"""What the first effect hid of the base robot is bare beside it: a controller of speed, motors that are unlike.

A marker that is told half a decimetre off its place hid a controller whose integral explains three thousand units more
beside it, and without which the marker's own name made the prediction worse; windings that heat hid that one motor's
torque falls 7 % less with speed than the other's, for which a mass 10 mm beside the axle stood as the second name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.late_sight import LAG, with_late_sight
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import (
    HOLD,
    with_bare_loop,
    with_likelier_rest,
    with_speed_loop,
)
from fsm_calib.diagnosis.candidates.stiffness import STIFFNESS, with_stiffness
from fsm_calib.diagnosis.candidates.supply_end import CEILING, with_supply_end
from fsm_calib.diagnosis.candidates.tyre_grip import RATIO, with_slip_ratio
from fsm_calib.diagnosis.candidates.usual_loop import MOST, with_usual_loop
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.verdict.selection import Selector

Found = tuple[Selector, Bank, list[Ranked]]
Freeing = Callable[[Engine, Fit, Rivals], Fit]

NUMBERS: tuple[tuple[str, Freeing], ...] = (
    (HOLD, with_speed_loop),
    (HOLD, with_bare_loop),
    (MOST, with_usual_loop),
    (CEILING, with_supply_end),
    (LAG, with_late_sight),
    (STIFFNESS, with_stiffness),
    (RATIO, with_slip_ratio),
)
"""Numbers of the base robot: full name, and what sets it free where the recordings ask for it."""


def ranked_if_bared(selector: Selector, bank: Bank, ranking: list[Ranked]) -> Found:
    """Return selector, bank and ranking on a base with the numbers that the first effect shows; else all as given."""
    found = selector, bank, ranking
    for name, freeing in NUMBERS:
        found = _ranked_with(*found, name, freeing)
    return _ranked_as_it_rests(*found)


def _ranked_with(selector: Selector, bank: Bank, ranking: list[Ranked], name: str, freeing: Freeing) -> Found:
    """Return all on a base with a number set free, where the recordings ask for it beside the first effect."""
    leader, measured = _leader(selector, ranking), selector.engine.simulators[0].measured_input
    if leader is None or measured or found_free(selector.base, name):
        return selector, bank, ranking
    others = [effect for effect in selector.catalogue if effect.name != leader.name and not effect.scan]
    freed = freeing(selector.engine, leader.fit, Rivals(others, selector.banks))
    return (selector, bank, ranking) if freed is leader.fit else _anew(selector, freed, leader)


def _ranked_as_it_rests(selector: Selector, bank: Bank, ranking: list[Ranked]) -> Found:
    """Return all on a base whose controller keeps or drops its integral at rest, as is likelier beside the first."""
    leader = _leader(selector, ranking)
    if leader is None or not found_free(selector.base, HOLD):
        return selector, bank, ranking
    rested = with_likelier_rest(selector.engine, leader.fit)
    return (selector, bank, ranking) if rested is leader.fit else _anew(selector, rested, leader)


def _leader(selector: Selector, ranking: list[Ranked]) -> Ranked | None:
    """Return the first effect of a ranking, if it explains enough to hide something."""
    return ranking[0] if ranking and ranking[0].evidence >= selector.needed else None


def _anew(selector: Selector, fit: Fit, leader: Ranked) -> Found:
    """Return selector, bank and ranking on what a fit leaves without its first effect."""
    bare = replace(selector, base=selector.without(fit, leader.name), distinct={})
    return bare, *bare.first_ranked()
