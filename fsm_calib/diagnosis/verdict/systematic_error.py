"""How far a fitted number may be off beyond what the noise explains: what the fit takes for known is not.

A fit's covariance knows the noise alone. Forces are found from speeds through the motors' slope, which needs the
robot's mass and rotating inertia; neither shows in commands and poses, so that all forces share their doubt. Equations
are inexact by a little, edges of places by a robot's contact, moments by a frame. The sizes are read from development
robots of two independent generators (`benchmarks/concealed`), never from sealed ones.
"""

from __future__ import annotations

import math

from fsm_calib.world2d import units
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.effect import FORCE_DOUBT

EQUATION_DOUBT = 0.03  # of any other strength
PLACE_DOUBT = 0.015  # m, centres and sizes of areas: half a tyre's width
MOMENT_DOUBT = 0.05  # s, begin and length of events: a frame of a camera


def model_spread(effect: Effect, name: str, value: float) -> float:
    """Return the standard deviation [the parameter's unit] that the model's own assumptions add to `value`."""
    parameter = effect.parameter(name)
    if not parameter.strength:
        if effect.scan == "place" and units.is_length(parameter.unit):
            return parameter.doubt or PLACE_DOUBT
        return MOMENT_DOUBT if effect.scan == "time" and units.is_time(parameter.unit) else 0.0
    by_unit = FORCE_DOUBT if units.holds_mass(parameter.unit) else EQUATION_DOUBT
    share = parameter.doubt or effect.inexact or by_unit
    return share * abs(value - parameter.null)


def with_doubt(effect: Effect, name: str, value: float, variance: float) -> float:
    """Return the standard deviation of noise and model together; nan when the data cannot tell the number."""
    if not variance > 0.0:
        return math.nan
    return math.hypot(math.sqrt(variance), model_spread(effect, name, value))
