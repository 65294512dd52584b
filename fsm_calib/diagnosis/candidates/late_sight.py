"""How late does a speed controller see the wheels' speeds? Ticks take a period to count, and are smoothed.

A loop that sees a speed late pushes on while the wheel has arrived: it overshoots after every step of the set point,
more than its integral does. Left out, it costs velocity-controlled robots up to 225 units of log-likelihood and two
fifths of their noise of turning; time constants come out a third too short, set points a fifth too heavy, and a delay
of 40 ms, a mass two centimetres off its place and a scrubbing tyre, each of them wrong, take what is left.
"""

from __future__ import annotations

from collections.abc import Iterable

from fsm_calib.diagnosis.candidates.free_number import SURE, found_free, unless_stood_in, with_free
from fsm_calib.diagnosis.candidates.speed_loop import HOLD
from fsm_calib.diagnosis.candidates.supply_end import LOOP
from fsm_calib.diagnosis.fitting.base import settled, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.speed_controller import EFFECT

LAG = f"{EFFECT.name}.lag"


def with_late_sight(engine: Engine, base: Fit, rivals: Iterable[Effect]) -> Fit:
    """Return a base that holds its wheels' speeds with what its loop sees late, where that has strong evidence.

    The loop's gain is set free with it where it is not yet.

    rivals : effects that are asked whether one does as well.
    """
    if not found_free(base, HOLD):
        return base

    def freed(fit: Fit) -> Fit:
        numbers = [LAG] if found_free(fit, LOOP) else [LAG, LOOP]
        starts = tuple(
            tuple(start if name == LAG else EFFECT.parameter("loop").null for name in numbers)
            for start in EFFECT.parameter("lag").starts
        )
        return settled(engine, with_free(engine, fit, [slot_of(name) for name in numbers], starts))

    return unless_stood_in(engine, base, freed, rivals)


def sight_told(fit: Fit) -> list[str]:
    """Return a sentence where the controller of a robot was seen to see its speeds late."""
    return [
        f"the controller sees the wheels' speeds {1000.0 * value:.0f} +- {1000.0 * sd:.0f} ms late: they overshoot"
        for _, value, sd in found_free(fit, LAG)
        if value > SURE * sd
    ]
