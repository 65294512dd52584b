"""Where does the supply behind a speed controller end? Above full command, on a robot that is built so.

A controller asks for more voltage than the set point has whenever the robot is to speed up, and no supply has ever so
much: the robot speeds up late and slows down in time. The motors of real robots have a tenth to a half more than full
command asks of them. Left out, it costs 70 to 600 units of log-likelihood on 14 of 21 such robots of three engines, up
to four fifths of the noise of driving, and delays, lags or weak batteries take the blame. Found on robots of two
engines: 1.32, 1.50 and 1.56 of full command (true 1.36, 1.41 and 1.60).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import SURE, found_free, unless_stood_in, with_free
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import HOLD
from fsm_calib.diagnosis.fitting.base import settled, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.world2d.effects.speed_controller import EFFECT
from fsm_calib.world2d.effects.speed_loop import AMPLE, NEVER

CEILING, LOOP = (f"{EFFECT.name}.{name}" for name in ("ceiling", "loop"))


def with_supply_end(engine: Engine, base: Fit, rivals: Rivals) -> Fit:
    """Return a base that holds its wheels' speeds with an end of the supply, where that has strong evidence.

    rivals : effects that are asked whether one does as well.
    """
    if not found_free(base, HOLD) or found_free(base, CEILING):
        return base
    end = replace(slot_of(CEILING), low=AMPLE, high=NEVER)

    def freed(fit: Fit) -> Fit:
        free = with_number_of_loop(engine, fit, end, EFFECT.parameter("ceiling").starts)
        return free if free.values[0, end.place] > AMPLE else fit

    return unless_stood_in(engine, base, freed, rivals)


def with_number_of_loop(engine: Engine, fit: Fit, slot: Slot, starts: Sequence[float]) -> Fit:
    """Return a fit with a number free that acts through the loop's gain, and this too where it is not free yet."""
    further = {} if found_free(fit, LOOP) else {LOOP: EFFECT.parameter("loop").null}
    slots = [slot, *map(slot_of, further)]
    return settled(engine, with_free(engine, fit, slots, [(start, *further.values()) for start in starts]))


def supply_told(fit: Fit) -> list[str]:
    """Return a sentence where the supply of a robot that holds its speeds was seen to end."""
    return [
        f"the supply behind the controller ends at {value:.2f} +- {sd:.2f} of full command: the robot speeds up late"
        for _, value, sd in found_free(fit, CEILING)
        if NEVER - value > SURE * sd
    ]
