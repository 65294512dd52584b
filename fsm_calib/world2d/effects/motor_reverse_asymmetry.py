r"""A motor is weaker (or stronger) backwards than forwards.

    u_effective = u                               u >= 0
    u_effective = u (1 - loss -+ difference / 2)  u < 0, left -, right +
    u_effective = u + drop_i tanh(|u| / 0.05)     u < 0, as a voltage drop
    T_i -> T_i / (1 + flux_i),    D_i -> D_i (1 + flux_i)^2       w_i < 0, as another motor constant
    R F_i = tau_i - (stiff_i + rub_i |tau_i|) sgn(w_i)            w_i < 0, as gears that press on a washer
    D_i -> D_i / (1 + ohm_i)                                      u_i < 0, as more resistance one way

loss [1]: mean over both motors; difference [1]: what the left motor loses more than the right one; drop [1]: a
piece of the command that a junction in the way of the reverse current takes, whole from 0.1 of the command on.
flux [1]: how much larger the motor's constant k is while it turns backwards, w [m/s] its rim speed. Brushes that are
set for one direction cut the armature at another angle in the other; speed and torque both go by k, so that the no-load
speed T [m/s] falls with 1 / k, and the slope D [N s/m] of the torque grows with k^2: slower, but stiffer. Brushed
motors with advanced brushes run 2 to 15 % slower one way; the two motors of a robot are mounted as mirror images.
stiff [N m], rub [1]: dry friction of a gear train that turns backwards, and its share of the torque tau [N m] that it
passes; R [m] wheel radius, F [N] force at the rim; ohm [1] what lies in the way of a reverse current (a transistor that
has burnt, a relay's contact), in windings: as fast, but weaker. Helical and worm gears press along their shafts, one
way on a bearing and the other way on a washer; a worn seal or a tilted brush takes a constant part.
Source: Hughes & Drury, Electric Motors and Drives, 5th ed., sections 3.2 (brush shift, k = K phi) and 2.4 (voltage
drops of devices); Shigley, Mechanical Engineering Design, 9th ed., sections 13-10 and 13-11 (axial thrust of helical
and worm gears).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import of_each_wheel
from fsm_calib.world2d.slots import DRIVE, DRY, RADIUS, RIM, TARGET

FULL_DROP = 0.05
"""Command at which 76 % of a junction's drop are there [1] (assumed)."""


@njit(error_model="numpy")
def weaken(P, o, u, side):
    """Return the command as the motor turns it into speed."""
    if u >= 0.0:
        return u
    lost = (P[o + 2] + P[o + 3 + side]) * math.tanh(-u / FULL_DROP)
    return min(u * (1.0 - P[o] + (0.5 - side) * -P[o + 1]) + lost, 0.0)


@njit(error_model="numpy")
def turn_backwards(P, o, S, m, W):
    """Give motors that turn backwards, or start to, their other constant and their gears' friction, those that are told
    to another resistance.
    """
    for side in range(2):
        rim = S[RIM + side]
        if rim < 0.0 or (rim == 0.0 and W[TARGET + side] < 0.0):
            k = 1.0 + P[o + 5 + side]
            W[TARGET + side] /= k
            W[DRIVE + side] *= k * k
            rub = P[o + 9 + side] * abs(W[DRIVE + side] * (W[TARGET + side] - S[RIM + side]))
            W[DRY + side] += P[o + 7 + side] / W[RADIUS + side] + rub
        if W[TARGET + side] < 0.0:
            W[DRIVE + side] /= 1.0 + P[o + 11 + side]


EFFECT = Effect(
    name="motor_reverse_asymmetry",
    family="command map",
    summary="weaker or stronger backwards",
    equation="u_eff = u (1 - loss -+ difference/2) for u < 0",
    parameters=(
        Parameter("loss", "rho", "1", 0.0, -0.5, 0.7, 0.08, "brush shift: 2 to 15 %"),
        Parameter(
            "difference",
            "delta_rho",
            "1",
            0.0,
            -0.6,
            0.6,
            0.04,
            "left loses more where positive",
            mirror="negate",
        ),
        Parameter("drop", "v", "1", 0.0, -0.3, 0.4, 0.0, "a diode of 0.3 to 0.7 V", starts=(0.05, -0.05)),
        *of_each_wheel(
            Parameter(
                "drop",
                "v",
                "1",
                0.0,
                -0.3,
                0.4,
                0.0,
                "one half bridge",
                starts=(0.05, -0.05),
            )
        ),
        *of_each_wheel(
            Parameter("flux", "phi", "1", 0.0, -0.4, 0.6, 0.0, "brush shift: 2 to 20 %", starts=(0.1, -0.1))
        ),
        *of_each_wheel(
            Parameter(
                "stiff", "tau_b", "N m", 0.0, 0.0, 0.1, 0.0, "3 to 15 % of the stall torque", starts=(0.006,)
            )
        ),
        *of_each_wheel(
            Parameter(
                "rub", "1 - eta_b", "1", 0.0, 0.0, 0.9, 0.0, "a washer in place of a bearing", starts=(0.2,)
            )
        ),
        *of_each_wheel(
            Parameter(
                "ohm",
                "r",
                "1",
                0.0,
                -0.6,
                9.0,
                0.0,
                "a burnt transistor: once the winding",
                starts=(0.3, -0.2),
            )
        ),
    ),
    hooks={"shape": weaken, "step": turn_backwards},
    channels=("forward", "turn"),
    regimes=("reverse",),
    separates="changes with the sign of each wheel's command only, at all speeds and places alike",
    rivals=("coulomb_friction", "carpet_nap", "floor_tilt", "motor_gain_curve"),
    manoeuvre="the same straight forwards and backwards, and spins both ways",
    sentence="Backwards the motors give {loss:less|more} speed than forwards.",
    source="Hughes & Drury, Electric Motors and Drives, 5th ed., section 3.2",
    closures=(
        Closure("both alike", ("loss",), "the same loss on both sides"),
        Closure("each its own", ("loss", "difference"), "more on one side than on the other"),
        Closure(
            "voltage drop",
            ("drop",),
            "the same piece of every reverse command is lost",
            sentence="Backwards the motors lose {drop} of every command.",
        ),
        Closure(
            "left drop",
            ("drop_left",),
            "a piece of every reverse command of the left motor is lost",
            sentence="Backwards the left motor loses {drop_left} of every command.",
        ),
        Closure(
            "right drop",
            ("drop_right",),
            "a piece of every reverse command of the right motor is lost",
            sentence="Backwards the right motor loses {drop_right} of every command.",
        ),
        Closure(
            "another constant",
            ("flux_left", "flux_right"),
            "backwards the motors' constant is another",
            sentence="Backwards the motors are slower and stiffer: their constant is larger by {flux_left} (left) and "
            "{flux_right} (right).",
        ),
        Closure(
            "stiff gears",
            ("stiff_left", "stiff_right"),
            "backwards the gears have more dry friction",
            sentence="Backwards dry friction takes {stiff_left} from the left motor and {stiff_right} from the right.",
        ),
        Closure(
            "rubbing gears",
            ("rub_left", "rub_right"),
            "backwards the gears lose a share of the torque that they pass",
            sentence="Backwards the gears lose {rub_left} (left) and {rub_right} (right) of the torque that they pass.",
        ),
        Closure(
            "more resistance",
            ("ohm_left", "ohm_right"),
            "what a reverse current goes through resists more",
            sentence="Backwards the motors' circuits resist more than forwards: by {ohm_left} of the winding (left) "
            "and {ohm_right} (right).",
        ),
    ),
    input="command",
    order=45,
)
