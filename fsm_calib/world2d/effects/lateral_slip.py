r"""The tyres yield sideways: in a curve the robot drifts outwards.

    S = l / (1/k + compliance')         compliance' = 2 compliance / m

S [N] side force of a tyre, l [m/s] sideways speed, k [N s/m] its stiffness, m [kg] the robot's mass,
compliance [s]: sideways speed over sideways acceleration that is added, so that l = -(base + compliance) v
omega in a steady curve. Source: slip velocities of Seegmiller & Kelly, Robotics: Science and Systems 2014
(lateral slip proportional to centripetal acceleration).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import MASS, SIDE_COMPLIANCE


@njit(error_model="numpy")
def yield_sideways(P, o, S, m, W):
    """Add the compliance to both tyres."""
    W[SIDE_COMPLIANCE] += 2.0 * P[o] / W[MASS]


EFFECT = Effect(
    name="lateral_slip",
    family="tyre",
    summary="drifts outwards in curves",
    equation="l = -compliance v omega",
    parameters=(
        Parameter("compliance", "K_y", "s", 0.0, 0.0, 0.3, 0.015, "0.005 to 0.02 s", starts=(0.01, 0.03)),
    ),
    hooks={"step": yield_sideways},
    channels=("lateral",),
    regimes=("fast_turn",),
    separates="sideways speed grows with speed times yaw rate; a turned sensor shows it on straights too",
    rivals=("sensor_offset", "sensor_yaw", "payload_offset"),
    manoeuvre="arcs both ways at three speeds",
    sentence="In curves the robot drifts outwards by {compliance} times its centripetal acceleration.",
    source="Seegmiller & Kelly 2014",
    order=77,
    dissipative=True,
)
