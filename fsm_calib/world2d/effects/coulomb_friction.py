r"""Dry friction in motor and gearbox: a torque that always opposes the wheel's rotation and holds it at rest.

    R F = tau_motor - tau_c sgn(w)            w != 0
    w = 0                                     |tau_motor - R F_tyre| <= tau_c
    tau_c + tau_s exp(-|w| / w_s)             with a Stribeck part: more at small speeds
    tau_c + mesh |tau_motor|                  of gears, whose teeth rub by the load that they pass
    F_r sgn(v_i)                              of a tyre that rolls hard, against the wheel's way over the floor

tau_c [N m] friction torque of one wheel: friction, plus or minus half the difference for left and right; tau_s
[N m] what it takes beyond that to break away, w_s [m/s] the Stribeck speed; mesh [1] the share of the motor's torque
that gears lose, one less their efficiency: they pass less of it to a wheel that speeds up, and take more from one that
slows down; R [m] wheel radius, w [m/s] rim speed, F [N] force at the rim; F_r [N] rolling resistance of one wheel, plus
or minus half its difference, v_i [m/s] the ground's speed at it. Where gears have no play the two are hardly told
apart; while the teeth are apart the motor's friction stops and the tyre's goes on.
Sources: Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083, section 2; Park, Lee & Kuipers, ICRA
2017 (dry friction of a small differential drive); Wong, Theory of Ground Vehicles, 4th ed. 2008, section 1.2 (rolling
resistance).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import contact_arm
from fsm_calib.world2d.forces import add_dry_way
from fsm_calib.world2d.slots import DRIVE, DRY, RADIUS, RIM, TARGET

STRIBECK = 0.1
"""Rim speed over which the breakaway part fades [m/s] (Armstrong-Helouvry et al. 1994: 0.01 to 0.1)."""


@njit(error_model="numpy")
def resist(P, o, S, m, W):
    """Add the friction, as a force at the rim."""
    for side in range(2):
        torque = max(P[o] + (0.5 - side) * P[o + 1], 0.0)
        if P[o + 5] != 0.0:
            W[DRY + side] += P[o + 5] * abs(W[DRIVE + side] * (W[TARGET + side] - S[RIM + side]))
        if P[o + 2] != 0.0:
            torque += P[o + 2] * math.exp(-abs(S[RIM + side]) / STRIBECK)
        W[DRY + side] += torque / W[RADIUS + side]
        rolling = max(P[o + 3] + (0.5 - side) * P[o + 4], 0.0)
        if rolling != 0.0:
            add_dry_way(W, 0.0, contact_arm(W, side, 1.0), 1.0, 0.0, rolling)


EFFECT = Effect(
    name="coulomb_friction",
    family="resistance",
    summary="dry friction in the drive train",
    equation="R F = tau_motor - tau_c sgn(w), held at w = 0",
    parameters=(
        Parameter(
            "friction",
            "tau_c",
            "N m",
            0.0,
            0.0,
            0.1,
            0.008,
            "3 to 10 % of the stall torque",
            starts=(0.004, 0.012),
        ),
        Parameter(
            "difference", "delta_tau", "N m", 0.0, -0.1, 0.1, 0.004, "left more than right", mirror="negate"
        ),
        Parameter("breakaway", "tau_s", "N m", 0.0, 0.0, 0.1, 0.0, "as much again as tau_c", starts=(0.006,)),
        Parameter(
            "rolling",
            "F_r",
            "N",
            0.0,
            0.0,
            2.0,
            0.0,
            "0.5 to 2 % of the load, more on carpet",
            starts=(0.05,),
        ),
        Parameter(
            "rolling_difference", "delta_F", "N", 0.0, -2.0, 2.0, 0.0, "left more than right", strength=False,
            mirror="negate", step=1e-3,
        ),
        Parameter(
            "mesh", "1 - eta", "1", 0.0, 0.0, 0.9, 0.0, "0.05 to 0.3; worm gears 0.3 to 0.7", starts=(0.2,)
        ),
    ),
    hooks={"step": resist},
    channels=("forward", "turn"),
    regimes=("slow", "starting", "stopping"),
    separates="holds each wheel at rest; drag at the caster acts on the body behind the axle",
    rivals=("caster_drag", "motor_deadband", "tyre_scrub", "motor_gain_curve"),
    manoeuvre="coasting to a stop from three speeds, and spins",
    sentence="Dry friction takes {friction} from each motor and holds it at rest.",
    input="command",
    source="Armstrong-Helouvry et al. 1994; Park, Lee & Kuipers 2017",
    closures=(
        Closure("both alike", ("friction",), "the same in both drive trains"),
        Closure("each its own", ("friction", "difference"), "more in one drive train than in the other"),
        Closure(
            "Stribeck",
            ("friction", "breakaway"),
            "more at small speeds",
            sentence="Dry friction takes {friction} from each motor and {breakaway} more near standstill.",
        ),
        Closure(
            "of loaded gears",
            ("friction", "mesh"),
            "more where the gears pass more torque",
            sentence="Dry friction takes {friction} from each motor, and {mesh} of the torque that its gears pass.",
            source="Dudley's Handbook of Practical Gear Design, 3rd ed. 2016, chapter 12 (efficiency)",
        ),
        Closure(
            "rolling",
            ("rolling",),
            "of the tyres, which roll hard, whether the gears push them or not",
            sentence="Each wheel rolls with a resistance of {rolling}.",
        ),
        Closure(
            "each rolls its own",
            ("rolling", "rolling_difference"),
            "of the tyres, more of one than of the other",
            sentence="Each wheel rolls with a resistance of {rolling}, the left one with {rolling_difference} more.",
        ),
    ),
    order=70,
    dissipative=True,
    universal=True,
)  # fmt: skip
