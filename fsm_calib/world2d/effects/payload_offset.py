r"""A load moves the centre of mass off the axle centre (and makes the robot heavier).

    m = m0 + mass,   c = (x, y);   M(c) and G(c) of `dynamics`; wheel loads shift with c

m0 [kg] the robot's mass, mass [kg] of the load, c [m] the common centre of mass in `base`. Driving then turns
and turning drives: m c_y couples forward acceleration with yaw, m c_x omega^2 pushes in curves. The mass
itself only scales the time constants, which a fit moves anyway. Source: Dhaouadi & Abu Hatab, Advances in
Robotics & Automation 2 (2013) 107, equation 26.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import COM_X, COM_Y, MASS


@njit(error_model="numpy")
def load(P, o, W):
    """Move the centre of mass and add the load's mass."""
    W[COM_X] += P[o]
    W[COM_Y] += P[o + 1]
    W[MASS] += P[o + 2]


EFFECT = Effect(
    name="payload_offset",
    family="body",
    summary="a load off the axle centre",
    equation="centre of mass at (x, y): M(c) dq/dt + omega G(c) q = f",
    parameters=(
        Parameter(
            "x",
            "c_x",
            "m",
            0.0,
            -0.1,
            0.1,
            -0.015,
            "0.3 kg 5 cm off the centre: 1 cm",
            starts=(0.015, -0.015),
        ),
        Parameter(
            "y", "c_y", "m", 0.0, -0.06, 0.06, 0.01, "0.3 kg 5 cm off the centre: 1 cm", mirror="negate"
        ),
        Parameter("mass", "dm", "kg", 0.0, 0.0, 5.0, 0.0, "up to the robot's own", fitted=False),
    ),
    hooks={"begin": load},
    channels=("forward", "turn", "lateral"),
    regimes=("fast_turn", "transient"),
    separates="couples driving and turning: yaw at every start, forward force in every curve",
    rivals=("motor_asymmetric_lag", "lateral_slip", "sensor_offset"),
    manoeuvre="starts and stops at full command, arcs both ways at three speeds",
    sentence="The centre of mass lies {x:ahead|behind} and {y:left|right} of the axle's centre.",
    source="Dhaouadi & Abu Hatab 2013",
    closures=(Closure("offset", ("x", "y"), "the place of the mass, its size as declared"),),
    order=20,
    universal=True,
)
