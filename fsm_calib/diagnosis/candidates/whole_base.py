"""The base robot with all that recordings may ask of it: a speed controller, a charge for each drive, its tyres."""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.charge import with_charges
from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.jitter import with_jitter
from fsm_calib.diagnosis.candidates.late_sight import with_late_sight
from fsm_calib.diagnosis.candidates.rivals import Banks, Rivals
from fsm_calib.diagnosis.candidates.speed_loop import HOLD, with_speed_loop
from fsm_calib.diagnosis.candidates.stiffness import with_stiffness
from fsm_calib.diagnosis.candidates.supply_end import with_supply_end
from fsm_calib.diagnosis.candidates.tyre_grip import with_tyres
from fsm_calib.diagnosis.candidates.usual_loop import with_usual_loop
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects import Effect


def fit_whole_base(engine: Engine, effects: Sequence[Effect], banks: Banks | None = None) -> Fit:
    """Fit the base robot; `effects` are what may do by itself what a number that is set free does.

    banks : where what they answered is kept, for who asks again on the same base.
    """
    banks = Banks() if banks is None else banks
    base = fit_base(engine)
    if engine.simulators[0].measured_input:
        return base
    lasting = Rivals([e for e in effects if not e.scan], banks)
    held = with_jitter(engine, with_late_sight(engine, _with_controller(engine, base, lasting), lasting))
    charged = with_charges(engine, with_stiffness(engine, held, lasting), lasting)
    return with_tyres(engine, charged, Rivals([e for e in effects if e.scan == "place"], banks))


def _with_controller(engine: Engine, base: Fit, lasting: Rivals) -> Fit:
    """Return the base with a speed controller where recordings ask for one, by its integral alone or whole."""
    looped = with_speed_loop(engine, base, lasting)
    if not found_free(looped, HOLD):
        looped = with_usual_loop(engine, base, lasting, asked_again=True)
    return with_supply_end(engine, looped, lasting)
