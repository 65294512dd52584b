"""A motor gets no more than its supply gives, whatever a speed loop asks for.

The loop's motor is F = D (T - w), D = (1 + p) D_m, with p the proportional gain over the motor's own slope D_m. It is
driven with the voltage, as a no-load rim speed,

    V = w + (1 + p) (T - w),        |V| <= V_max

so that beyond it the motor is the bare one at full voltage: F = D_m (+-V_max - w). Where set points are within what the
supply gives, the robot speeds up late and slows down in time; beyond, no set point gives more speed than V_max.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.dynamics import GAIN
from fsm_calib.world2d.slots import CEILING, DRIVE, LOOP_GAIN, RIM, TARGET


@njit(**ARITHMETIC)
def end_at(P, W, share, loop):
    """Let the supply end at a share [1] of the no-load speeds at full command, behind loops of this gain [1]."""
    W[LOOP_GAIN] = loop
    for side in range(2):
        W[CEILING + side] = share * P[GAIN + side]


@njit(**ARITHMETIC)
def give_what_there_is(S, W, side, m):
    """Drive a motor with what its supply gives where it is asked for more; return the share [1] of the step in which it
    was asked. `S[m + side]` is the rim speed of the step before, from which it is told when the wheel has caught up: by
    whole steps the speed would jump with the supply's size, and no fit would find it.
    """
    rim, target, most, give = S[RIM + side], W[TARGET + side], W[CEILING + side], 1.0 / (1.0 + W[LOOP_GAIN])
    faster, S[m + side] = rim - S[m + side], rim
    above, below = target - rim - give * (most - rim), give * (-most - rim) - target + rim
    excess, end, caught_up = (above, most, faster) if above > below else (below, -most, -faster)
    if excess <= 0.0:
        return 0.0
    caught_up *= 1.0 - give
    share = min(1.0, excess / caught_up) if caught_up > 0.0 else 1.0
    slope = share * give + 1.0 - share
    W[TARGET + side] = (share * give * end + (1.0 - share) * target) / slope
    W[DRIVE + side] *= slope
    return share
