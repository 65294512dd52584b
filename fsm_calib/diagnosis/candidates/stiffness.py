"""Does one motor's torque fall more with its speed than the other's? No two motors are alike.

The slope of a motor's torque is its constant squared over its resistance: 5 % of the one and 4 % of the other make 11 %
of the slope, so that one wheel answers sooner than the other and loses less to a load. Left out, a mass beside the axle
stands for it (8 to 19 mm for 1 to 4 mm on robots of another engine), a winding that warms within a moment, or a ramp of
one driver. So it is free where it has strong evidence, up to what two motors of one kind differ by, and gives way to
an effect that explains more; of a mass only to what it does beside the axle, for one that lies ahead or behind is there
besides.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import SURE, found_free, unless_stood_in, with_free, with_held
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects.unequal_motors import EFFECT
from fsm_calib.world2d.parameters import parameter_table

STIFFNESS, ASIDE = f"{EFFECT.name}.stiffness", "payload_offset.y"
MOST = 0.12  # half of the difference over the mean: two spreads of what motors of one kind differ by
STARTS = (0.02,)


def with_stiffness(engine: Engine, base: Fit, effects: Rivals) -> Fit:
    """Return the base with motors of unequal slopes, where that has strong evidence.

    effects : of which those that the effect's file calls its rivals are asked whether one does as well.
    """
    rivals = effects.among(EFFECT.rivals)
    slot = replace(slot_of(STIFFNESS), low=-MOST, high=MOST)

    def freed(fit: Fit) -> Fit:
        return with_free(engine, fit, [slot], STARTS)

    def in_place_of_a_mass_aside(rival: Ranked) -> Fit | None:
        if not found_free(rival.fit, ASIDE):
            return None
        return freed(with_held(rival.fit, ASIDE, base.values[:, parameter_table().place(ASIDE)]))

    return unless_stood_in(engine, base, freed, rivals, in_place_of_a_mass_aside)


def stiffness_told(fit: Fit) -> list[str]:
    """Return a sentence where one motor's torque clearly falls more with its speed than the other's."""
    return [
        f"the {'right' if value > 0.0 else 'left'} motor's torque falls {200.0 * abs(value):.1f} +- {200.0 * sd:.1f} % "
        "more with its speed than the other's: unlike motors, most likely"
        for _, value, sd in found_free(fit, STIFFNESS)
        if abs(value) > SURE * sd
    ]
