"""How late does a speed controller see the wheels' speeds? Ticks take a period to count, and are smoothed.

A loop that sees a speed late pushes on while the wheel has arrived: it overshoots after every step of the set point,
more than its integral does. Left out, it costs velocity-controlled robots 82 to 1,324 units of log-likelihood and up
to two fifths of their noise of turning (six robots of PhysX); integrals come out up to three times too fast, and late
commands, a mass two centimetres off its place or a scrubbing tyre, each of them wrong, take what is left.
"""

from __future__ import annotations

from fsm_calib.diagnosis.candidates.free_number import SURE, found_free, unless_stood_in
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import HOLD
from fsm_calib.diagnosis.candidates.supply_end import with_number_of_loop
from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects.speed_controller import EFFECT

LAG = f"{EFFECT.name}.lag"


def with_late_sight(engine: Engine, base: Fit, rivals: Rivals) -> Fit:
    """Return a base that holds its wheels' speeds with what its loop sees late, where that has strong evidence.

    The loop's gain is set free with it where it is not yet.

    rivals : effects that are asked whether one does as well.
    """
    if not found_free(base, HOLD):
        return base

    def freed(fit: Fit) -> Fit:
        return with_number_of_loop(engine, fit, slot_of(LAG), EFFECT.parameter("lag").starts)

    return unless_stood_in(engine, base, freed, rivals)


def sight_told(fit: Fit) -> list[str]:
    """Return a sentence where the controller of a robot was seen to see its speeds late."""
    return [
        f"the controller sees the wheels' speeds {1000.0 * value:.0f} +- {1000.0 * sd:.0f} ms late: they overshoot"
        for _, value, sd in found_free(fit, LAG)
        if value > SURE * sd
    ]
