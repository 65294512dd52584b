r"""The commanded speed is that of another point of the robot than the axle's centre.

    v = sgn(V) sqrt(max(V^2 - (reach omega)^2, 0))

v [m/s] forward speed that the wheels are told, V [m/s] commanded speed, omega [rad/s] commanded yaw rate, reach [m]
distance of the point ahead of (or behind) the axle. A point at that distance moves with (v, reach omega), so it has the
speed V. Path followers steer such a point because it, unlike the axle, can move sideways; a log of its speed
overstates the robot's in turns. Source: Siciliano, Sciavicco, Villani & Oriolo, Robotics, 2009, section 11.6.1
(control of a point ahead of the axle).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import HALF_AXLE, TARGET


@njit(error_model="numpy")
def shorten(P, o, S, m, W):
    """Take from both wheels what the point's sideways speed accounts for."""
    speed = 0.5 * (W[TARGET] + W[TARGET + 1])
    aside = P[o] * (W[TARGET + 1] - W[TARGET]) / (2.0 * W[HALF_AXLE])
    left = math.copysign(math.sqrt(max(speed * speed - aside * aside, 0.0)), speed) - speed
    W[TARGET] += left
    W[TARGET + 1] += left


EFFECT = Effect(
    name="command_point",
    family="command map",
    summary="the commanded speed is that of a point away from the axle",
    equation="v = sgn(V) sqrt(max(V^2 - (reach omega)^2, 0))",
    parameters=(
        Parameter(
            "reach", "a", "m", 0.0, 0.0, 0.5, 0.06, "half to twice the axle length; a Create: 0.18 m",
            starts=(0.03, 0.08, 0.2), step=1e-3,
        ),
    ),
    hooks={"step": shorten},
    channels=("forward",),
    regimes=("turning",),
    separates="forward speed alone is lost, with the square of the curvature, while the turn rate is kept",
    rivals=("caster_drag", "command_saturation", "motor_gain_curve"),
    manoeuvre="arcs of three radii at one speed, both ways",
    sentence="The commanded speed is that of a point {reach} away from the axle: in turns the axle itself is slower.",
    source="Siciliano et al., Robotics, 2009, section 11.6.1",
    input="twist",
    order=5,
)  # fmt: skip
