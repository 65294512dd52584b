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
from fsm_calib.world2d.slots import CEILING, DRIVE, LOOP_GAIN, RIM, TARGET


@njit(**ARITHMETIC)
def give_what_there_is(S, W, side):
    """Drive a motor with what its supply gives where it is asked for more; return whether it was."""
    rim, most, give = S[RIM + side], W[CEILING + side], 1.0 / (1.0 + W[LOOP_GAIN])
    short = W[TARGET + side] - rim
    if short > give * (most - rim):
        end = most
    elif short < give * (-most - rim):
        end = -most
    else:
        return False
    W[TARGET + side] = end
    W[DRIVE + side] *= give
    return True
