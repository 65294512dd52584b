"""The driven wheels of one step: motor, rotating mass, gears and tyre meet the ground (equations in
`dynamics`).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.slots import (
    ANGLE,
    DRIVE,
    DRY,
    ENGAGED,
    FREE_ROTATING,
    GRIP,
    LAST_SLIP,
    RADIUS,
    RIM,
    ROTATING,
    SLIP_RATIO,
    SLIP_SPEED,
    SLIP_TREND,
    STEP,
    TARGET,
    WHEEL_ENCODER,
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


@njit(**ARITHMETIC, forceinline=True)
def slips_at_crossing(excess, drive, grip, floor2, guess):
    """Return the slips [m/s] at which motors and tyres pass the same forces, both wheels side by side.

    Solves drive (excess - s) = grip s / sqrt(s^2 + floor2) for s of each wheel; all but `floor2` are pairs, left and
    right: `excess` [m/s] is the no-load rim speed minus the ground's speed, `drive` [N s/m], `grip` [N], `guess` [m/s]
    where the slips before point to; `floor2` [m2/s2] is the squared slip across plus the squared slip speed. Newton's
    method; the curve is concave, so that from the left of the root it climbs without overshooting, and from the right
    it falls left of it at once, at worst to zero.
    """
    drive_l, drive_r = drive
    grip_l, grip_r = grip
    far_l, far_r = abs(excess[0]), abs(excess[1])
    s_l, s_r = min(abs(guess[0]), far_l), min(abs(guess[1]), far_r)
    live_l, live_r = True, True
    for _ in range(NEWTON_STEPS):
        r2_l, r2_r = s_l * s_l + floor2, s_r * s_r + floor2
        q_l, q_r = math.sqrt(r2_l), math.sqrt(r2_r)
        c_l = (drive_l * (far_l - s_l) * q_l - grip_l * s_l) * r2_l / (drive_l * r2_l * q_l + grip_l * floor2)
        c_r = (drive_r * (far_r - s_r) * q_r - grip_r * s_r) * r2_r / (drive_r * r2_r * q_r + grip_r * floor2)
        s_l = max(s_l + c_l, 0.0) if live_l else s_l
        s_r = max(s_r + c_r, 0.0) if live_r else s_r
        live_l = live_l and abs(c_l) >= NEWTON_TOLERANCE
        live_r = live_r and abs(c_r) >= NEWTON_TOLERANCE
        if not (live_l or live_r):
            break
    return math.copysign(s_l, excess[0]), math.copysign(s_r, excess[1])


@njit(**ARITHMETIC, forceinline=True)
def line(slip, speed, drive, grip, floor2):
    """Return a tyre's secant stiffness, and slope [N s/m] and force [N] of the wheel as the body feels it."""
    r2 = slip * slip + floor2
    q, gripping = math.sqrt(r2), grip * floor2
    stiffness, slope = grip / q, drive * gripping / (drive * r2 * q + gripping)
    return stiffness, slope, stiffness * slip + slope * speed


@njit(**ARITHMETIC, forceinline=True)
def meet_ground(S, W, v_l, v_r, across):
    """Let both wheels meet the ground in this step; return for each (stiffness, slope, force, target, share).

    `v_l`, `v_r` [m/s] are the speeds of the axle's ends along the wheels, `across` [m/s] to the left. `stiffness`
    [N s/m] is the tyre's secant; the force along is force [N] - slope [N s/m] times the ground's speed, and the
    rim's mean speed target [m/s] - share [m/(N s)] times the force along. By the trapezoid rule the rotating mass
    acts like a second, steep motor line through the rim speed before the step, and the crossing is the rim's mean
    speed. Dry friction of the drive train shifts the line against the rotation. Engaged wheels that keep their
    direction are solved side by side, all others alone.
    """
    rolling2 = 0.5 * (v_l * v_l + v_r * v_r)
    floor2 = across * across + W[SLIP_SPEED] * W[SLIP_SPEED] + W[SLIP_RATIO] * W[SLIP_RATIO] * rolling2
    if W[ENGAGED] == 1.0 and W[ENGAGED + 1] == 1.0:
        inert = W[ROTATING] / (DAMPED_MIDDLE * W[STEP])
        rim_l, rim_r, dry_l, dry_r = S[RIM], S[RIM + 1], W[DRY], W[DRY + 1]
        drive_l, drive_r = W[DRIVE] + inert, W[DRIVE + 1] + inert
        share_l, share_r = 1.0 / drive_l, 1.0 / drive_r
        free_l = (W[DRIVE] * W[TARGET] + inert * rim_l - math.copysign(dry_l, rim_l)) * share_l
        free_r = (W[DRIVE + 1] * W[TARGET + 1] + inert * rim_r - math.copysign(dry_r, rim_r)) * share_r
        slip_l, slip_r = slips_at_crossing(
            (free_l - v_l, free_r - v_r),
            (drive_l, drive_r),
            (W[GRIP], W[GRIP + 1]),
            floor2,
            (W[LAST_SLIP] + W[SLIP_TREND], W[LAST_SLIP + 1] + W[SLIP_TREND + 1]),
        )
        if (dry_l == 0.0 or (v_l + slip_l) * rim_l > 0.0) and (dry_r == 0.0 or (v_r + slip_r) * rim_r > 0.0):
            keep_slip(W, 0, slip_l)
            keep_slip(W, 1, slip_r)
            line_l = line(slip_l, v_l, drive_l, W[GRIP], floor2)
            line_r = line(slip_r, v_r, drive_r, W[GRIP + 1], floor2)
            return (
                (line_l[0], line_l[1], line_l[2], free_l, share_l),
                (line_r[0], line_r[1], line_r[2], free_r, share_r),
            )
    return wheel_alone(S, W, 0, v_l, floor2), wheel_alone(S, W, 1, v_r, floor2)


@njit(**ARITHMETIC, forceinline=True)
def keep_slip(W, side, slip):
    """Note a wheel's slip [m/s] and how much it changed: the search for the next begins where it was going."""
    W[SLIP_TREND + side] = slip - W[LAST_SLIP + side]
    W[LAST_SLIP + side] = slip


@njit(**ARITHMETIC, forceinline=True)
def lead(W, side):
    """Return where in the step the rim speed is solved for: a little past half way, so that the fast slip of a
    stiff tyre dies out in long steps instead of ringing; at the end where gears have just met.
    """
    return 1.0 - (1.0 - DAMPED_MIDDLE) * W[ENGAGED + side]


@njit(**ARITHMETIC)
def wheel_alone(S, W, side, speed, floor2):
    """Return what `meet_ground` does of one wheel that may be held by dry friction or cross its gears' play.

    Both directions of rotation are tried side by side; where neither fits, dry friction holds the wheel still.
    """
    engaged, grip = W[ENGAGED + side], W[GRIP + side]
    if engaged > 0.0:
        inert = W[ROTATING] / (lead(W, side) * W[STEP])
        drive = W[DRIVE + side] + inert
        share = 1.0 / drive
        target = (W[DRIVE + side] * W[TARGET + side] + inert * S[RIM + side]) * share
        dry, guess = W[DRY + side] * share, W[LAST_SLIP + side] + W[SLIP_TREND + side]
        ahead, back = slips_at_crossing(
            (target - dry - speed, target + dry - speed), (drive, drive), (grip, grip), floor2, (guess, guess)
        )
        goes_ahead = dry == 0.0 or speed + ahead > 0.0
        if goes_ahead or speed + back < 0.0:
            slip, free = (ahead, target - dry) if goes_ahead else (back, target + dry)
            keep_slip(W, side, slip)
            stiffness, slope, force = line(slip, speed, drive, grip, floor2)
            return stiffness, engaged * slope, engaged * force, free, share / engaged
        stiffness = grip / math.sqrt(speed * speed + floor2)
        return stiffness, stiffness, 0.0, 0.0, 0.0
    free = free_speed(S[RIM + side], W[TARGET + side], W[DRIVE + side], W[FREE_ROTATING], W[STEP])
    stiffness = grip / math.sqrt(floor2)
    return stiffness, 0.0, 0.0, free, 0.0


@njit(**ARITHMETIC)
def free_speed(rim, target, drive, rotating, h):
    """Return the rim speed [m/s] after h [s] of an unloaded motor, which goes its own way, d w / dt = D (T - w) / m_w;
    without rotating mass it is the target at once.
    """
    return target + (rim - target) * math.exp(-drive * h / rotating) if rotating > 0.0 else target


@njit(**ARITHMETIC, forceinline=True)
def settle(speed):
    """Return zero for a speed that is too small to matter (`STILL`)."""
    return speed if abs(speed) > STILL else 0.0


@njit(**ARITHMETIC, forceinline=True)
def turn_wheel(S, W, side, wheel, speed):
    """Advance a wheel's angle [rad] and rim speed [m/s]; `wheel` is that of `meet_ground`, `speed` [m/s] the mean
    speed of its end of the axle over the step.
    """
    _, slope, force, target, share = wheel
    before, engaged = S[RIM + side], W[ENGAGED + side]
    mean = target - share * (force - slope * speed)
    if engaged == 1.0:
        after = settle(before + (mean - before) * (1.0 / DAMPED_MIDDLE))
        rim = after if share > 0.0 else 0.0
        turned = 0.5 * (before + rim)
    else:
        change = (mean - before) / lead(W, side)
        if engaged > 0.0:
            change *= engaged  # what the body gave in the part of the step after the teeth met
        rim = settle(before + change) if share > 0.0 or engaged == 0.0 else 0.0
        turned = 0.5 * (before + rim)
        if W[WHEEL_ENCODER] > 0.0:
            turned = engaged * turned + (1.0 - engaged) * speed
    S[RIM + side] = rim
    S[ANGLE + side] += W[STEP] * turned / W[RADIUS + side]
