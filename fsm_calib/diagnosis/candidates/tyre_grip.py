"""What tyres does the robot stand on? The base robot with their grip and slip ratio free, where recordings ask for it.

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

from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.ranking import Bank, evidence_of
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE, fit_base, grip_slot, have_encoders, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.world2d.effects import Effect

GRIPS = (0.35, 0.55, 0.9)  # 1: a tyre that hardly slips has no derivative to go by
RATIOS = (0.1,)  # 1: nor has a ratio of 0
STEPS = 8
NEEDED = (
    6.0  # evidence: "strong" (Kass & Raftery, J. Am. Stat. Assoc. 90 (1995) 773); no part is accused by it
)
KEPT = (
    0.5  # of its evidence beside a place: a spot of grease leaves it a fifth, a mat that brakes leaves it all
)


def fit_base_on_floor(engine: Engine, places: Sequence[Effect]) -> Fit:
    """Fit the base robot, with the grip and the slip ratio of its tyres free where each has strong evidence.

    places : effects of single places, which are asked whether they do as well as another grip.
    """
    base = fit_base(engine)
    if engine.simulators[0].measured_input:
        return base
    return _with_slip_ratio(engine, _with_grip(engine, base, places))


def _with_slip_ratio(engine: Engine, fit: Fit) -> Fit:
    """Return the fit with a slip ratio where encoders show one."""
    if not have_encoders(engine.simulators):
        return fit
    rolling = _with_free(engine, fit, slot_of("slip_ratio"), RATIOS)
    return rolling if evidence_of(rolling, fit, engine.count) >= NEEDED else fit


def _with_grip(engine: Engine, base: Fit, places: Sequence[Effect]) -> Fit:
    """Return the fit with the floor's grip free where no single place does its job."""
    gripped = with_free_grip(engine, base)
    evidence = evidence_of(gripped, base, engine.count)
    if evidence < NEEDED:
        return base
    bank = Bank.on(engine, base)
    tried = [found for found in map(bank.best_of, places) if found is not None and found.evidence > evidence]
    if not tried:
        return gripped
    place = max(tried, key=lambda found: found.evidence).fit
    beside = evidence_of(with_free_grip(engine, place), place, engine.count)
    return gripped if beside >= max(NEEDED, KEPT * evidence) else base


def with_free_grip(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with the tyres' grip free as well."""
    return _with_free(engine, fit, grip_slot(fit.values[0]), GRIPS)


def _with_free(engine: Engine, fit: Fit, slot: Slot, starts: Sequence[float]) -> Fit:
    """Return the fit with one more number free, the best of several starts, and the noise of speeds fitted again."""
    tried = []
    for start in starts:
        values = fit.values.copy()
        values[:, slot.place] = start
        tried.append(engine.fit(values, (*fit.slots, slot), fit.noise, steps=STEPS))
    best = engine.refit_noise(max(tried, key=lambda t: t.score), SPEED_NOISE, 3)
    return engine.fit(best.values, best.slots, best.noise, steps=STEPS)
