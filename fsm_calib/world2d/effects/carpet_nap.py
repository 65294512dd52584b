r"""A carpet's pile resists more against its lie than along it, or carries what drives on it along.

    F = -(|n| - n . d) d        d = e v / sqrt(v^2 + v_b^2)
    F = p v^2 / (v^2 + v_b^2)   as a pull on whatever moves, along the lie of the pile
    x' = x'_0 + c |v|           as tips that bend under the wheels: it is carried by a share of its way

e: unit vector ahead in `world`, v [m/s] the speed along it, n [N]: the nap's vector, pointing where driving is
easiest: no additional drag along it, |n| across it, 2 |n| against it. It only ever resists. v_b [m/s]: while a robot
spins, its middle creeps to and fro, and a pile that is bent by a millimetre does not resist in full (assumed).
c [1]: way along the lie of the pile in `world` over the way driven, whichever way.
Source: direction dependence of rolling resistance on pile carpet; the cosine is the lowest harmonic (assumed).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.forces import add_dry_friction, add_force
from fsm_calib.world2d.slots import CARRIED_X, CARRIED_Y, COS, MASS, SIN, V

BENT_SPEED = 0.01  # m/s, above which a pile resists in full


@njit(error_model="numpy")
def resist(P, o, S, m, W):
    """Add the drag along the robot."""
    bent = S[V] / math.sqrt(S[V] * S[V] + BENT_SPEED * BENT_SPEED)
    ease = (W[COS] * P[o] + W[SIN] * P[o + 1]) * bent
    drag = max(math.sqrt(P[o] ** 2 + P[o + 1] ** 2) - ease, 0.0)
    add_dry_friction(W, 0.0, 0.0, 1.0, 0.0, S[V], drag * abs(bent), W[MASS])
    pull_x, pull_y = P[o + 2] * bent * bent, P[o + 3] * bent * bent
    add_force(W, W[COS] * pull_x + W[SIN] * pull_y, W[COS] * pull_y - W[SIN] * pull_x, 0.0)
    way = abs(S[V])
    W[CARRIED_X] += P[o + 4] * way
    W[CARRIED_Y] += P[o + 5] * way


EFFECT = Effect(
    name="carpet_nap",
    family="floor",
    summary="drag by direction",
    equation="F = -(|n| - n.d) d sgn(v)",
    parameters=(
        Parameter("x", "n_x", "N", 0.0, -3.0, 3.0, 0.2, "2 to 10 % of the weight", starts=(0.2, -0.2, 0.0)),
        Parameter(
            "y",
            "n_y",
            "N",
            0.0,
            -3.0,
            3.0,
            0.15,
            "2 to 10 % of the weight",
            mirror="negate",
            starts=(0.0, 0.2, -0.2),
        ),
        Parameter(
            "pull_x",
            "p_x",
            "N",
            0.0,
            -3.0,
            3.0,
            0.0,
            "robots drift by 1 to 5 % of the way along the pile",
            step=1e-4,
        ),
        Parameter("pull_y", "p_y", "N", 0.0, -3.0, 3.0, 0.0, "the same across", mirror="negate", step=1e-4),
        Parameter(
            "carried_x", "c_x", "1", 0.0, -0.3, 0.3, 0.0, "robots drift by 1 to 5 % of the way", step=1e-4
        ),
        Parameter(
            "carried_y", "c_y", "1", 0.0, -0.3, 0.3, 0.0, "the same across", mirror="negate", step=1e-4
        ),
    ),
    hooks={"step": resist},
    reads=("heading",),
    channels=("forward",),
    regimes=("heading",),
    separates="depends on the heading like a tilt, but never moves a resting robot",
    rivals=("floor_tilt", "caster_drag", "coulomb_friction", "motor_reverse_asymmetry"),
    manoeuvre="straights on four headings, each followed by a rest with the wheels at zero",
    sentence="A carpet's nap eases driving along ({x}, {y}) and resists against it.",
    source="rolling resistance on pile carpet, lowest harmonic (assumed)",
    closures=(
        Closure("drag by direction", ("x", "y"), "resists more against its lie"),
        Closure(
            "pull along the pile",
            ("pull_x", "pull_y"),
            "takes a moving robot with it",
            sentence="A carpet's pile pulls the moving robot by ({pull_x}, {pull_y}) along its lie.",
            source="robot vacuum makers: carpet drift compensation (US 8,749,196 B2, iRobot)",
        ),
        Closure(
            "carried along the pile",
            ("carried_x", "carried_y"),
            "moves a driving robot by a share of its way",
            sentence="A carpet's pile carries the robot by ({carried_x}, {carried_y}) of its way.",
            source="robot vacuum makers: carpet drift compensation (US 8,749,196 B2, iRobot)",
        ),
    ),
    order=81,
)
