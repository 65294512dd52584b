r"""A rough stretch of floor: each side of the robot that is on it has additional resistance.

    F_i = -drag sgn(v_i) - viscous v_i        |x_i - x| <= half_x, |y_i - y| <= half_y

F [N] on side i, whose contact is at (x_i, y_i) [m] in `world` and moves with v_i [m/s]: the wheel, or nearer to the
body's middle where the body itself drags (`spread` [1], 1 wheel, 0 middle); drag [N] of a mat or gravel, viscous
[N s/m] of long pile, grass or mud, centre (x, y) and half sizes [m] of a box along the axes (a strip is a long box), or
of the ellipse in it (`roundness` [1], 0 box, 1 ellipse).
Sources: rolling resistance, e.g. Wong, Theory of Ground Vehicles, 4th ed., section 1.2; dry and viscous friction:
Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import (
    centre_parameters,
    contact_arm,
    contact_place,
    in_area,
    spread_parameter,
)
from fsm_calib.world2d.forces import add_damper, add_dry_friction
from fsm_calib.world2d.slots import MASS, OMEGA, V

AREA = ("x", "y", "half_x", "half_y")
SPOT_DOUBT = 0.03  # m: drag at a wheel stands for drag anywhere under the robot (20 concealed spots)


@njit(error_model="numpy")
def resist(P, o, S, m, W):
    """Add the resistance of each side at its contact."""
    for side in range(2):
        arm = contact_arm(W, side, P[o + 5])
        x, y = contact_place(W, arm)
        speed = S[V] - arm * S[OMEGA]
        inside = in_area(x, y, P[o + 1], P[o + 2], P[o + 3], P[o + 4], P[o + 6])
        add_dry_friction(W, 0.0, arm, 1.0, 0.0, speed, P[o] * inside, 0.5 * W[MASS])
        add_damper(W, 0.0, arm, P[o + 7] * inside, 0.0)


EFFECT = Effect(
    name="rough_floor_patch",
    family="patch",
    summary="a stretch of floor with more rolling resistance",
    equation="F_i = -drag sgn(v_i) - viscous v_i inside a box or an ellipse",
    parameters=(
        Parameter(
            "drag", "F_p", "N", 0.0, 0.0, 6.0, 0.8, "5 to 30 % of the wheel load", starts=(0.5, 1.5, 0.12)
        ),
        *centre_parameters("p", SPOT_DOUBT),
        Parameter(
            "half_x",
            "a_p",
            "m",
            0.2,
            0.02,
            100.0,
            0.2,
            "a mat or a strip",
            strength=False,
            step=6e-3,
            starts=(0.1, 0.2, 3.0),
        ),
        Parameter(
            "half_y",
            "b_p",
            "m",
            0.2,
            0.02,
            100.0,
            0.25,
            "a mat or a strip",
            strength=False,
            step=6e-3,
            starts=(0.1, 0.2, 3.0),
        ),
        spread_parameter("w_p"),
        Parameter(
            "roundness",
            "q_p",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "0 a box, 1 an ellipse",
            strength=False,
            fitted=False,
            starts=(0.0, 1.0),
        ),
        Parameter(
            "viscous",
            "c_p",
            "N s/m",
            0.0,
            0.0,
            30.0,
            2.0,
            "the drag of a mat at walking pace",
            starts=(1.0, 4.0, 0.25),
        ),
    ),
    hooks={"step": resist},
    reads=("place", "heading"),
    channels=("forward", "turn"),
    regimes=("place",),
    separates="only there, always against the motion; a misplaced marker moves the pose, not the robot",
    rivals=("low_friction_patch", "misplaced_marker", "carpet_nap"),
    manoeuvre="cross the place on two headings and at two speeds",
    sentence="Around ({x}, {y}) the floor resists each wheel with {drag}.",
    source="Wong, Theory of Ground Vehicles, 4th ed., section 1.2",
    closures=(
        Closure("dry", ("drag", *AREA), "a drag whatever the speed: a mat, gravel"),
        Closure(
            "grows with speed",
            ("viscous", *AREA),
            "a drag in proportion to the speed: long pile, grass, mud",
            "Around ({x}, {y}) the floor resists each wheel with {viscous}.",
            "Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083",
        ),
    ),
    where="area",
    acts_on="drag",
    order=85,
    dissipative=True,
)
