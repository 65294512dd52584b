"""The driven wheels of one step: motor, rotating mass, gears and tyre meet the ground (equations in
`dynamics`).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.forces import add_damper, add_force
from fsm_calib.world2d.slots import (
    ANGLE,
    DRIVE,
    DRY,
    ENGAGED,
    FREE_ROTATING,
    GRIP,
    HALF_AXLE,
    LAST_SLIP,
    LINE_FORCE,
    LINE_SLOPE,
    MEAN_OMEGA,
    NEXT,
    OMEGA,
    RADIUS,
    RIM,
    RIM_SHARE,
    RIM_TARGET,
    ROTATING,
    SIDE_COMPLIANCE,
    SLIP_SPEED,
    SLIP_STIFFNESS,
    SLIP_TREND,
    STEP,
    TARGET,
    WHEEL_ENCODER,
    L,
    V,
)

NEWTON_STEPS = 30
"""Most iterations for the crossing of motor and tyre; two or three are the rule."""
NEWTON_TOLERANCE = 1e-5
"""Change of the slip at which the iteration ends [m/s]; as it converges quadratically, the error is then below
2e-8 (20,000 random wheels, slip speeds from 5 mm/s)."""
DAMPED_MIDDLE = 0.6
"""Implicitness of the rim speed's step [1]: 0.5 rings for ever with stiff tyres, 0.6 damps by a third a step."""
STILL = 1e-12
"""Speeds below this are zero [m/s, rad/s]: keeps a resting robot exactly still."""


@njit(**ARITHMETIC)
def slip_at_crossing(excess, drive, grip, floor2, guess):
    """Return the slip [m/s] at which motor and tyre pass the same force.

    Solves drive (excess - s) = grip s / sqrt(s^2 + floor2) for s; `excess` [m/s] is the no-load rim speed
    minus the ground's speed, `drive` [N s/m], `grip` [N], `floor2` [m2/s2] the squared slip across plus the
    squared slip speed, `guess` [m/s] where the slips before point to. Newton's method; the curve is concave, so
    that from the left of the root it climbs without overshooting, and from the right it falls left of it at
    once, at worst to zero.
    """
    e = abs(excess)
    s = min(abs(guess), e)
    for _ in range(NEWTON_STEPS):
        r2 = s * s + floor2
        q = math.sqrt(r2)
        change = (drive * (e - s) * q - grip * s) * r2 / (drive * r2 * q + grip * floor2)
        s = max(s + change, 0.0)
        if abs(change) < NEWTON_TOLERANCE:
            break
    return math.copysign(s, excess)


@njit(**ARITHMETIC, inline="always")
def lead(W, side):
    """Return where in the step the rim speed is solved for: a little past half way, so that the fast slip of a
    stiff tyre dies out in long steps instead of ringing; at the end where gears have just met.
    """
    return 1.0 - (1.0 - DAMPED_MIDDLE) * W[ENGAGED + side]


@njit(**ARITHMETIC)
def meet_ground(S, W, side, speed, across):
    """Find the line force = LINE_FORCE - LINE_SLOPE speed of one wheel and its tyre's secant stiffness for
    this step.

    `speed` [m/s] of the axle's end along the wheel, `across` [m/s] to the left. By the trapezoid rule the
    rotating mass acts like a second, steep motor line through the rim speed before the step, and the crossing
    is the rim's mean speed. Dry friction of the drive train shifts the line against the rotation; a wheel
    that it holds is a dragged tyre.
    """
    inert = W[ROTATING] / (lead(W, side) * W[STEP])
    drive = W[DRIVE + side] + inert
    share = 1.0 / drive
    target = (W[DRIVE + side] * W[TARGET + side] + inert * S[RIM + side]) * share
    dry, engaged = W[DRY + side], W[ENGAGED + side]
    floor2 = across * across + W[SLIP_SPEED] * W[SLIP_SPEED]
    if engaged > 0.0:
        effective = target - dry * share
        guess = W[LAST_SLIP + side] + W[SLIP_TREND + side]
        slip = slip_at_crossing(effective - speed, drive, W[GRIP + side], floor2, guess)
        if dry > 0.0 and speed + slip <= 0.0:
            effective = target + dry * share
            slip = slip_at_crossing(effective - speed, drive, W[GRIP + side], floor2, guess)
        if dry == 0.0 or (speed + slip) * (effective - target) < 0.0:
            W[SLIP_TREND + side] = slip - W[LAST_SLIP + side]
            W[LAST_SLIP + side] = slip
            r2 = slip * slip + floor2
            stiffness = W[GRIP + side] / math.sqrt(r2)
            slope = drive * stiffness * floor2 / (drive * r2 + stiffness * floor2)
            W[SLIP_STIFFNESS + side] = stiffness
            W[LINE_SLOPE + side] = engaged * slope
            W[LINE_FORCE + side] = engaged * (stiffness * slip + slope * speed)
            W[RIM_TARGET + side], W[RIM_SHARE + side] = (
                effective,
                share if engaged == 1.0 else share / engaged,
            )
            return
    hold_or_coast(S, W, side, speed, floor2)


@njit(**ARITHMETIC)
def hold_or_coast(S, W, side, speed, floor2):
    """Describe a wheel that dry friction holds still (a dragged tyre), or one that turns freely in its gears'
    play.

    In the play the motor goes its own way, d w / dt = D (T - w) / m_w, which is what the rim speed then
    stands for.
    """
    stiffness = W[GRIP + side] / math.sqrt(speed * speed + floor2)
    W[SLIP_STIFFNESS + side], W[LINE_SLOPE + side], W[LINE_FORCE + side] = stiffness, stiffness, 0.0
    W[RIM_TARGET + side], W[RIM_SHARE + side] = 0.0, 0.0
    if W[ENGAGED + side] > 0.0:
        return
    W[SLIP_STIFFNESS + side], W[LINE_SLOPE + side] = W[GRIP + side] / math.sqrt(floor2), 0.0
    W[RIM_TARGET + side] = free_speed(
        S[RIM + side], W[TARGET + side], W[DRIVE + side], W[FREE_ROTATING], W[STEP]
    )


@njit(**ARITHMETIC)
def free_speed(rim, target, drive, rotating, h):
    """Return the rim speed [m/s] of an unloaded motor after h [s]; without rotating mass it is the target at
    once.
    """
    return target + (rim - target) * math.exp(-drive * h / rotating) if rotating > 0.0 else target


@njit(**ARITHMETIC)
def add_tyres(S, W):
    """Let both wheels meet the ground and add their forces to the body's balance."""
    half = W[HALF_AXLE]
    for side in range(2):
        arm = half if side == 0 else -half
        meet_ground(S, W, side, S[V] - arm * S[OMEGA], S[L])
        stiffness = W[SLIP_STIFFNESS + side]
        add_damper(W, 0.0, arm, W[LINE_SLOPE + side], stiffness / (1.0 + stiffness * W[SIDE_COMPLIANCE]))
        force = W[LINE_FORCE + side]
        add_force(W, force, 0.0, -arm * force)


@njit(**ARITHMETIC, inline="always")
def settle(speed):
    """Return zero for a speed that is too small to matter (`STILL`)."""
    return speed if abs(speed) > STILL else 0.0


@njit(**ARITHMETIC)
def turn_wheels(S, W):
    """Advance the wheels' angles [rad] and rim speeds [m/s] with the body's mean speed over the step."""
    v = 0.5 * (S[V] + W[NEXT + V])
    for side in range(2):
        arm = W[HALF_AXLE] if side == 0 else -W[HALF_AXLE]
        speed = v - arm * W[MEAN_OMEGA]
        force = W[LINE_FORCE + side] - W[LINE_SLOPE + side] * speed
        mean = W[RIM_TARGET + side] - W[RIM_SHARE + side] * force
        held = W[RIM_SHARE + side] == 0.0 and W[ENGAGED + side] > 0.0
        before, engaged = S[RIM + side], W[ENGAGED + side]
        change = (mean - before) / lead(W, side)
        if engaged > 0.0:
            change *= engaged  # what the body gave in the part of the step after the teeth met
        S[RIM + side] = 0.0 if held else settle(before + change)
        turned = 0.5 * (before + S[RIM + side])
        if engaged < 1.0 and W[WHEEL_ENCODER] > 0.0:
            turned = engaged * turned + (1.0 - engaged) * speed
        S[ANGLE + side] += W[STEP] * turned / W[RADIUS + side]
