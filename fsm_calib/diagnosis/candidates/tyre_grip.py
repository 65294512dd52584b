"""What grip has the floor? The base robot with the tyres' friction free, where the recordings ask for it.

Where tyres slip at every reversal their friction coefficient shows, and one that is off by a third looks like a limit
of the motors' current, a scrub or a drag. Where they hardly slip it shows in nothing, and only lends itself to what
slips in a single place. So it is free where that has the evidence of an effect, and keeps it beside the place on the
floor that explains more: a slippery spot does most of the job of a smaller grip of the whole floor.
"""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.ranking import Bank, evidence_of
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE, fit_base, grip_slot
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects import Effect

STARTS = (0.35, 0.55, 0.9)  # 1: a tyre that hardly slips has no derivative to go by
STEPS = 8
KEPT = (
    0.5  # of its evidence beside a place: a spot of grease leaves it a fifth, a mat that brakes leaves it all
)


def fit_base_on_floor(engine: Engine, places: Sequence[Effect], needed: float) -> Fit:
    """Fit the base robot, with the grip of its tyres free where that wins the evidence `needed`.

    places : effects of single places, which are asked whether they do as well.
    """
    base = fit_base(engine)
    if engine.simulators[0].measured_input:
        return base
    gripped = with_free_grip(engine, base)
    evidence = evidence_of(gripped, base, engine.count)
    if evidence < needed:
        return base
    bank = Bank.on(engine, base)
    tried = [found for found in map(bank.best_of, places) if found is not None and found.evidence > evidence]
    if not tried:
        return gripped
    place = max(tried, key=lambda found: found.evidence).fit
    beside = evidence_of(with_free_grip(engine, place), place, engine.count)
    return gripped if beside >= max(needed, KEPT * evidence) else base


def with_free_grip(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with the tyres' grip free as well, and the noise of speeds fitted again."""
    slot, tried = grip_slot(fit.values[0]), []
    for start in STARTS:
        values = fit.values.copy()
        values[:, slot.place] = start
        tried.append(engine.fit(values, (*fit.slots, slot), fit.noise, steps=STEPS))
    best = engine.refit_noise(max(tried, key=lambda t: t.score), SPEED_NOISE, 3)
    return engine.fit(best.values, best.slots, best.noise, steps=STEPS)
