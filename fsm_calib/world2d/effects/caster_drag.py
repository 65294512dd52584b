r"""The caster drags, and kicks when it swivels.

    F_drag = -drag v_p / |v_p|                                   at the pivot, against its velocity
    F_drag = -drag v_h / |v_h| - drag n_y sgn(n_y . v_p)         with `crossed`: each of two ways by itself
    F_drag = -drag e sgn(e . v_p)                                with `forked`: along the fork, wherever it points
    drag(s) = drag (1 - exp(-s / wound))                         with `wound`: s its way since the drive began
    F_kick = -kick n (n . v_p) / sqrt((n . v_p)^2 + swivel^2)    across a caster that is not yet aligned
    d psi / dt = (n . v_p) / trail - omega

v_p [m/s] velocity of the caster's pivot, `arm` [m] behind the axle; psi [rad] direction of the caster's wheel
in `base` (0: straight ahead), e and n the unit vectors along and across it, trail [m] distance of its wheel behind the
pivot (a share of the arm), drag and kick [N]. A ball only drags; a swivelling caster stands on the wrong side of its
pivot after a reversal and turns over within a few trail lengths of travel, pushing sideways. A wheel that rolls hard or
is braked passes no moment through its pivot, so that it pulls along its fork: for a trail length or two after a spin
still across the robot, which no drag against the pivot's velocity does. Some contacts resist each of two ways by
itself: a ball on crossed rollers, and skids of engines that solve friction along a body's motion and across it apart
from each other. v_h [m/s] is the velocity halfway between axle and caster, n_y across the robot. PhysX 5 turns its two
ways with the velocity of the body's centre of mass: axes turned so leave a likelihood too rugged to fit, and these meet
what they do to a hundredth of the evidence. Hair winds up around a caster's axle as it goes, until no more turns find
room: `wound` [m] is the way over which the drag comes to 0.63 of what it ends at; every drive begins with a clean
caster. Sources: dry friction of a ball caster; friction pyramid of contacts, Stewart & Trinkle, Int. J. Numer. Methods
Eng. 39 (1996) 2673; trailing wheel after Chung & Iagnemma, in Springer Handbook of Robotics, 2nd ed. 2016, section
24.1; makers' care pages for robot vacuums, on hair around the front caster; Duckietown URDF for the arm (0.083 m, 0.085
m on newer robots).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.decay import gone
from fsm_calib.world2d.dynamics import small_rotation
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.forces import add_dry_point, add_dry_way, add_oblique_damper
from fsm_calib.world2d.slots import OMEGA, STEP, L, V

SWIVEL_SPEED = 0.02
"""Speed across the caster at which its kick has 1/sqrt(2) of its size [m/s] (assumed)."""
HALFWAY = 0.4
"""Place at whose velocity the first of two crossed ways acts, over the arm [1] (assumed; 0.3 to 0.5 are as good)."""
OPPOSITE = 2000.0
"""Largest tan(gap / 2) [1]: a caster that points exactly the wrong way turns as if it were 1e-3 rad off (assumed)."""
TRAIL = 0.02 / 0.075
"""Distance of the caster's wheel behind its pivot over the arm [1] (assumed: 2 cm, as 25 mm furniture casters have it,
on a Duckiebot)."""


@njit(error_model="numpy")
def drag_and_swivel(P, o, S, m, W):
    """Add the caster's forces and turn it; S[m] is its way [m], S[m + 1] and S[m + 2] are cosine and sine of psi."""
    arm = P[o + 2]
    vx, vy = S[V], S[L] - arm * S[OMEGA]
    speed = math.sqrt(vx * vx + vy * vy)
    drag = P[o]
    if P[o + 6] > 0.0:
        S[m] += speed * W[STEP]
        drag *= gone(S[m] / P[o + 6])
    swivels, forked = P[o + 1] != 0.0, P[o + 4] != 0.0
    c, s = (S[m + 1], S[m + 2]) if S[m + 1] != 0.0 or S[m + 2] != 0.0 else (1.0, 0.0)
    if forked:
        add_dry_way(W, -arm, 0.0, c, s, drag)
    elif P[o + 3] == 0.0:
        add_dry_point(W, -arm, 0.0, drag)
    else:
        add_dry_point(W, -HALFWAY * arm, 0.0, drag)
        add_dry_way(W, -arm, 0.0, 0.0, 1.0, drag)
    if swivels:
        across = c * vy - s * vx
        kick = P[o + 1] / math.sqrt(across * across + SWIVEL_SPEED * SWIVEL_SPEED)
        add_oblique_damper(W, -arm, 0.0, -s, c, kick)
    if speed > 0.0 and (swivels or forked):
        travel = speed * W[STEP] / (P[o + 5] * arm)
        S[m + 1], S[m + 2] = turn_towards(c, s, vx / speed, vy / speed, travel, S[OMEGA] * W[STEP])


@njit(error_model="numpy")
def turn_towards(c, s, to_c, to_s, travel, body):
    """Return cosine and sine of the caster's direction, (c, s) so far, after `travel` trail lengths towards
    (to_c, to_s) while the body turns by `body` [rad].

    The exact solution of d gap / d travel = -sin(gap): half = tan(gap / 2) decays exponentially.
    """
    ahead, sine = 1.0 + c * to_c + s * to_s, s * to_c - c * to_s
    half = math.copysign(OPPOSITE, sine)
    if abs(sine) < OPPOSITE * ahead:
        half = sine / ahead
    half *= math.exp(-travel)
    scale = 1.0 / (1.0 + half * half)
    left_c, left_s = (1.0 - half * half) * scale, 2.0 * half * scale
    c, s = to_c * left_c - to_s * left_s, to_s * left_c + to_c * left_s
    body_c, body_s = small_rotation(body)
    return c * body_c + s * body_s, s * body_c - c * body_s


EFFECT = Effect(
    name="caster_drag",
    family="resistance",
    summary="the caster drags, and kicks when it swivels",
    equation="F = -drag v_p/|v_p| - kick n sgn(n.v_p), dpsi/dt = n.v_p/trail - omega",
    parameters=(
        Parameter(
            "drag",
            "F_c",
            "N",
            0.0,
            0.0,
            4.0,
            0.3,
            "2 to 10 % of the weight on it, more on carpet",
            starts=(0.2, 0.6),
        ),
        Parameter("kick", "F_k", "N", 0.0, 0.0, 4.0, 0.0, "of the drag's size", starts=(0.3,)),
        Parameter(
            "arm",
            "a",
            "m",
            0.075,
            0.02,
            0.3,
            0.075,
            "0.07 to 0.085 on Duckiebots, 0.13 on a Create, 0.2 on a Pioneer: half to 0.6 of the axle",
            strength=False,
            of_axle=0.55,
        ),
        Parameter(
            "crossed",
            "n",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "0: against its velocity, 1: along and across by themselves",
            strength=False,
            fitted=False,
        ),
        Parameter(
            "forked",
            "f",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "0: against its velocity, 1: along the fork",
            strength=False,
            fitted=False,
        ),
        Parameter(
            "trail",
            "q",
            "1",
            TRAIL,
            0.05,
            1.0,
            TRAIL,
            "2 to 5 cm behind a pivot 7 to 20 cm behind the axle",
            strength=False,
            starts=(0.15, 0.4),
        ),
        Parameter(
            "wound",
            "s_w",
            "m",
            0.0,
            0.0,
            30.0,
            3.0,
            "0: drags alike all the time; hair winds up within some metres",
            strength=False,
            starts=(2.0, 6.0),
        ),
    ),
    hooks={"step": drag_and_swivel},
    channels=("forward", "turn"),
    regimes=("slow", "after_reversal", "fast_turn"),
    separates="acts behind the axle, on driving and turning in a fixed ratio; kicks only after a reversal",
    rivals=("coulomb_friction", "tyre_scrub", "carpet_nap", "motor_deadband"),
    manoeuvre="forward and reverse, and spins at three rates",
    sentence="The caster drags with {drag} and kicks with up to {kick} when it swivels.",
    source="Springer Handbook of Robotics, 2nd ed. 2016, section 24.1; Duckietown URDF",
    closures=(
        Closure("drag alone", ("drag",), "rolling drag, the arm as built"),
        Closure("drag and arm", ("drag", "arm"), "with an arm of its own"),
        Closure(
            "crossed ways",
            ("drag", "arm"),
            "along its way and across it each by itself",
            fixes={"crossed": 1.0},
            source="Stewart & Trinkle 1996",
        ),
        Closure(
            "along its fork",
            ("drag", "arm", "trail"),
            "a wheel that is braked pulls along its fork, wherever that points",
            fixes={"forked": 1.0},
        ),
        Closure(
            "winding up",
            ("drag", "wound"),
            "drags more and more as hair winds up around it",
            sentence="Hair winds up around the caster: it drags with up to {drag}, with 0.63 of that after {wound}.",
            source="care pages of robot vacuums",
            extends=("drag alone",),
        ),
        Closure("drag and kick", ("drag", "kick"), "with a kick when it swivels"),
        Closure(
            "swivelling wheel",
            ("drag", "kick", "arm", "trail"),
            "pulls along its fork, kicks across it, with an arm and a trail of its own",
            fixes={"forked": 1.0},
            extends=("drag and kick", "along its fork"),
        ),
    ),
    memory=3,
    order=75,
    dissipative=True,
)
