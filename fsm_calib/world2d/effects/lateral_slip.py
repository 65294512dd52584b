r"""The tyres yield sideways: in a curve the robot drifts outwards.

    S = l / (1/k + compliance')         compliance' = 2 (compliance + slip_angle |u| + skid |l| / g) / m
    drift = -at_once v omega

S [N] side force of a tyre, l [m/s] sideways speed, k [N s/m] its stiffness, m [kg] the robot's mass,
compliance [s]: sideways speed over sideways acceleration that is added, so that l = -(base + compliance) v
omega in a steady curve, which the robot's mass reaches with the time constant compliance. slip_angle [s2/m]: a
rolling tyre creeps by an angle, l / u, that grows with its side force, so that its sideways speed grows with its
rolling speed u [m/s] (the mean of both rims) as well: 1 / (g c) for a cornering stiffness of c loads per radian.
skid [1]: the load over the largest side force, S -> m g / (2 skid) where the tyre slides, g = 9.80665 m/s2: hard
narrow wheels and worn rollers hold well along and hardly across. at_once [s]: the drift of a compliance without the
delay, where body or axle lean outwards and no mass has to be moved.
Sources: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 1.3.1 (side force over slip angle); slip velocities
of Seegmiller & Kelly, Robotics: Science and Systems 2014 (lateral slip proportional to centripetal acceleration,
kinematic there); sliding of a contact that is not alike in both directions, Zmitrowicz, Int. J. Solids Structures 25
(1989) 837.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import GRAVITY, MASS, OMEGA, RIM, SIDE_COMPLIANCE, SIDE_DRIFT, L, V


@njit(error_model="numpy")
def yield_sideways(P, o, S, m, W):
    """Add the compliance to both tyres, and what they drift at once."""
    rolling = 0.5 * (abs(S[RIM]) + abs(S[RIM + 1]))
    W[SIDE_COMPLIANCE] += 2.0 * (P[o] + P[o + 2] * rolling + P[o + 3] * abs(S[L]) / GRAVITY) / W[MASS]
    W[SIDE_DRIFT] -= P[o + 1] * S[V] * S[OMEGA]


EFFECT = Effect(
    name="lateral_slip",
    family="tyre",
    summary="drifts outwards in curves",
    equation="l = -(compliance + slip_angle |v|) v omega",
    parameters=(
        Parameter("compliance", "K_y", "s", 0.0, 0.0, 0.3, 0.015, "0.005 to 0.02 s", starts=(0.01, 0.03)),
        Parameter("at_once", "K_0", "s", 0.0, 0.0, 0.3, 0.0, "as compliance", starts=(0.015,)),
        Parameter(
            "slip_angle",
            "K_a",
            "s2/m",
            0.0,
            0.0,
            1.0,
            0.0,
            "0.01 to 0.05: 2 to 10 loads per radian, softer on foam",
            starts=(0.03,),
        ),
        Parameter(
            "skid",
            "1 / mu_y",
            "1",
            0.0,
            0.0,
            100.0,
            0.0,
            "2 to 5 on hard plastic, 10 to 50 on rollers; 1 to 2 are tyres that grip",
            starts=(20.0, 5.0),
            step=0.05,
        ),
    ),
    hooks={"step": yield_sideways},
    channels=("lateral",),
    regimes=("fast_turn",),
    separates="sideways speed grows with speed times yaw rate; a turned sensor shows it on straights too",
    rivals=("sensor_offset", "sensor_yaw", "payload_offset"),
    manoeuvre="arcs both ways at three speeds",
    sentence="In curves the robot drifts outwards by {compliance} times its centripetal acceleration.",
    source="Seegmiller & Kelly 2014",
    closures=(
        Closure("yielding tyres", ("compliance",), "side forces bend the tyres"),
        Closure(
            "slip angle",
            ("slip_angle",),
            "rolling tyres creep by an angle that grows with the side force",
            sentence="In curves the tyres creep outwards, by {slip_angle} times the centripetal acceleration.",
        ),
        Closure(
            "skidding tyres",
            ("skid",),
            "tyres that hold along and slide across",
            sentence="In curves the tyres slide outwards: they hold no more than the load over {skid}.",
            source="Zmitrowicz 1989",
        ),
        Closure(
            "at once",
            ("at_once",),
            "it drifts as it turns, without delay",
            sentence="In curves the robot drifts outwards by {at_once} times its centripetal acceleration, at once.",
        ),
    ),
    order=77,
    dissipative=True,
    universal=True,
)
