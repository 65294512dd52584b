r"""The base robot: a rigid body on two motor-driven, slipping wheels, one step at a time, compiled.

Equations, in the frame `base` at the axle centre, q = (v [m/s], l [m/s], omega [rad/s]):

    M(c) dq/dt + omega G(c) q + A q = f

M is the mass matrix of a body of mass m [kg] with its centre of mass at c [m], G its gyroscopic matrix, A and f the
forces: linear in q with coefficients that are frozen over a step, and constant. Each wheel at (0, +-b/2) obeys

    motor, wheel    m_w dw/dt = D (T - w) - F                 D = (m + 2 m_w) / (2 tau_forward) [N s/m]
    tyre            (F, S) = mu N s / sqrt(|s|^2 + s0^2)      s = (w - v_i, -l) slip velocity [m/s]

with rim speed w [m/s], no-load speed T = gain * command [m/s], speed of the axle's end v_i = v -+ omega b/2, friction
coefficient mu [1], load N [N], slip speed s0 [m/s] and the rotating inertia as a mass at the rim, m_w = J / R^2 [kg].
tau_forward [s] and tau_turn [s] are the time constants of the robot on gripping tyres: yaw inertia enters as
tau_turn = (I + m_w b^2/2) / (D b^2/2).

The torque-speed line is that of a permanent-magnet motor, tau = stall (g u - rate/no_load): T = g no_load R u and
D = stall / (R^2 no_load).

Method: driven wheels enter by the tangent of their crossing, sliding and dry friction by their secant (force / slip),
both frozen over the step; then the trapezoid rule is applied to the linear rest. It is stable for any step, adds no
energy (tangents and secants are positive and G is antisymmetric), is exactly still at standstill, and nearly of second
order. Positions follow from the mean of the old and the new velocity.

Sources: torque-speed line and combined slip as in Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, sections 1.2.2
and 3.2 (saturating law of the slip vector); linearly implicit stepping of stiff friction as in Hairer & Wanner, Solving
Ordinary Differential Equations II, 2nd ed. 1996, section IV.7; Duckiebot data in `parameters`.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d import slots
from fsm_calib.world2d.slots import (
    ANGLE,
    BASE_DRIVE,
    COM_X,
    COM_Y,
    COMMAND,
    COS,
    DAMP,
    DRIVE,
    DRY,
    ENGAGED,
    FORCE_X,
    FORCE_Y,
    GRIP,
    HALF_AXLE,
    HEADING_COS,
    HEADING_SIN,
    INERTIA,
    LINE_FORCE,
    LINE_SLOPE,
    LOAD,
    MASS,
    MEAN_OMEGA,
    MEAN_VX,
    MEAN_VY,
    MOMENT,
    NEXT,
    NEXT_COS,
    NEXT_SIN,
    NEXT_VX,
    NEXT_VY,
    OMEGA,
    RADIUS,
    RIM,
    RIM_SHARE,
    RIM_TARGET,
    ROTATING,
    SIDE_COMPLIANCE,
    SIN,
    SLIP_SPEED,
    SLIP_STIFFNESS,
    STEP,
    TARGET,
    THETA,
    TIME,
    L,
    V,
    X,
    Y,
)

GAIN, AXLE, TAU_FORWARD, TAU_TURN, WHEEL_RADIUS, BODY_MASS = 0, 2, 3, 4, 5, 7
FRICTION, TYRE_SLIP, CASTER_SHARE, WHEEL_INERTIA = 8, 9, 10, 11
"""Places of the base parameters in the parameter vector P (`parameters.BASE` names them in this order)."""

NEWTON_STEPS = 12
"""Most iterations for the crossing of motor and tyre; two or three are the rule."""
NEWTON_TOLERANCE = 1e-7
"""Change of the slip at which the iteration ends [m/s]; as it converges quadratically, the error is then 1e-12."""
LEAST_RATIO = 0.1
"""Yaw inertia over mass times the square of half the axle that is always left to the body (assumed): where the time
constants leave less, the wheels have less inertia, so that odd fits stay solvable."""
STEPS_TO_STOP = 4.0
"""Steps within which dry friction could stop a motion for it to be treated as a damper."""
STILL = 1e-12
"""Speeds below this are zero [m/s, rad/s]: keeps a resting robot exactly still."""


@njit(error_model="numpy", inline="always")
def add_force(W, fx, fy, moment):
    """Add a constant force (fx, fy) [N] in `base` at the axle centre and a moment [N m] to this step."""
    W[FORCE_X] += fx
    W[FORCE_Y] += fy
    W[MOMENT] += moment


@njit(error_model="numpy", inline="always")
def add_damper(W, px, py, kx, ky):
    """Add a damper at the point (px, py) [m] of `base` with stiffness kx along x and ky along y [N s/m]."""
    W[DAMP] += kx
    W[DAMP + 2] -= kx * py
    W[DAMP + 3] += ky
    W[DAMP + 4] += ky * px
    W[DAMP + 5] += kx * py * py + ky * px * px


@njit(error_model="numpy")
def add_oblique_damper(W, px, py, dx, dy, k):
    """Add a damper of stiffness k [N s/m] at the point (px, py) [m] that acts along the unit vector (dx, dy) of `base`."""
    arm = px * dy - py * dx
    W[DAMP] += k * dx * dx
    W[DAMP + 1] += k * dx * dy
    W[DAMP + 2] += k * dx * arm
    W[DAMP + 3] += k * dy * dy
    W[DAMP + 4] += k * dy * arm
    W[DAMP + 5] += k * arm * arm


@njit(error_model="numpy")
def add_dry_friction(W, px, py, dx, dy, speed, size, inertia):
    """Add dry friction of `size` [N] at the point (px, py) [m] of `base` against `speed` [m/s] along the unit vector (dx, dy).

    A constant force while it cannot stop the motion within a few steps (second order), else a stiff damper (stable, holds
    still); `inertia` [kg] is the mass that it brakes, at least.
    """
    k = size / math.sqrt(speed * speed + slots.CREEP_SPEED * slots.CREEP_SPEED)
    if abs(speed) * inertia > STEPS_TO_STOP * W[STEP] * size:
        add_force(W, -k * speed * dx, -k * speed * dy, -k * speed * (px * dy - py * dx))
    else:
        add_oblique_damper(W, px, py, dx, dy, k)


@njit(error_model="numpy")
def begin_base(P, W):
    """Set what stays the same for a whole roll-out: masses, geometry, motors; effects may change it afterwards."""
    mass, half = P[BODY_MASS], 0.5 * P[AXLE]
    W[:] = 0.0
    W[MASS], W[HALF_AXLE] = mass, half
    W[RADIUS], W[RADIUS + 1] = P[WHEEL_RADIUS], P[WHEEL_RADIUS + 1]
    ratio = P[TAU_TURN] / P[TAU_FORWARD]
    rotating = P[WHEEL_INERTIA] / (0.5 * (W[RADIUS] + W[RADIUS + 1])) ** 2
    if ratio < 1.0:
        rotating = min(rotating, max(0.5 * mass * (ratio - LEAST_RATIO) / (1.0 - ratio), 0.0))
    W[ROTATING] = rotating
    W[BASE_DRIVE] = (0.5 * mass + rotating) / P[TAU_FORWARD]
    W[INERTIA] = 2.0 * half * half * max(P[TAU_TURN] * W[BASE_DRIVE] - rotating, 0.5 * mass * LEAST_RATIO)


@njit(error_model="numpy")
def share_load(P, W):
    """Distribute the weight [N] over wheels and caster by the centre of mass; called once, after the effects' begin.

    The caster, `CASTER_ARM` behind the axle, bears its share of the centred robot plus -x/arm; a centre of mass to the
    left loads the left wheel. No wheel is ever lifted: at least a tenth of its even load remains (assumed).
    """
    weight = W[MASS] * slots.GRAVITY
    wheels = min(max(1.0 - P[CASTER_SHARE] + W[COM_X] / slots.CASTER_ARM, 0.1), 1.0) * weight
    left = min(max(0.5 + 0.5 * W[COM_Y] / W[HALF_AXLE], 0.05), 0.95)
    W[LOAD], W[LOAD + 1] = wheels * left, wheels * (1.0 - left)


@njit(error_model="numpy")
def begin_step(P, W):
    """Fill the workbench with the base robot's values for one step; the commands and the step are already there."""
    drive = W[BASE_DRIVE]
    for side in range(2):
        W[TARGET + side] = P[GAIN + side] * W[COMMAND + side]
        W[DRIVE + side] = drive
        W[DRY + side] = 0.0
        W[ENGAGED + side] = 1.0
        W[GRIP + side] = P[FRICTION] * W[LOAD + side]
    W[SLIP_SPEED] = P[TYRE_SLIP]
    W[SIDE_COMPLIANCE] = 0.0
    W[FORCE_X] = W[FORCE_Y] = W[MOMENT] = 0.0
    for i in range(DAMP, DAMP + 6):
        W[i] = 0.0


@njit(error_model="numpy")
def slip_at_crossing(excess, drive, grip, floor2, guess):
    """Return the slip [m/s] at which motor and tyre pass the same force.

    Solves drive (excess - s) = grip s / sqrt(s^2 + floor2) for s; `excess` [m/s] is the no-load rim speed minus the
    ground's speed, `drive` [N s/m], `grip` [N], `floor2` [m2/s2] the squared slip across plus the squared slip speed,
    `guess` [m/s] the slip of the step before. Newton's method; the curve is concave, so that from the left of the root
    it cannot overshoot, and from the right it is held at a bound that is left of it.
    """
    e = abs(excess)
    least = max(drive * e / (drive + grip / math.sqrt(floor2)), e - grip / drive)
    s = max(least, abs(guess))
    for _ in range(NEWTON_STEPS):
        r2 = s * s + floor2
        k = grip / math.sqrt(r2)
        change = (drive * (e - s) - k * s) * r2 / (drive * r2 + k * floor2)
        s = max(s + change, least)
        if abs(change) < NEWTON_TOLERANCE:
            break
    return math.copysign(s, excess)


@njit(error_model="numpy", inline="always")
def lead(W, side):
    """Return where in the step the rim speed is solved for: half way, or later (damped) where gears have just met."""
    return 1.0 - 0.5 * W[ENGAGED + side]


@njit(error_model="numpy")
def meet_ground(S, W, side, speed, across):
    """Find the line force = LINE_FORCE - LINE_SLOPE speed of one wheel and its tyre's secant stiffness for this step.

    `speed` [m/s] of the axle's end along the wheel, `across` [m/s] to the left. By the trapezoid rule the rotating mass
    acts like a second, steep motor line through the rim speed before the step, and the crossing is the rim's mean speed.
    Dry friction of the drive train shifts the line against the rotation; a wheel that it holds is a dragged tyre.
    """
    inert = W[ROTATING] / (lead(W, side) * W[STEP])
    drive = W[DRIVE + side] + inert
    target = (W[DRIVE + side] * W[TARGET + side] + inert * S[RIM + side]) / drive
    dry, engaged = W[DRY + side], W[ENGAGED + side]
    floor2 = across * across + W[SLIP_SPEED] * W[SLIP_SPEED]
    if engaged > 0.0:
        effective = target - dry / drive
        guess = S[RIM + side] - speed
        slip = slip_at_crossing(effective - speed, drive, W[GRIP + side], floor2, guess)
        if dry > 0.0 and speed + slip <= 0.0:
            effective = target + dry / drive
            slip = slip_at_crossing(effective - speed, drive, W[GRIP + side], floor2, guess)
        if dry == 0.0 or (speed + slip) * (effective - target) < 0.0:
            r2 = slip * slip + floor2
            stiffness = W[GRIP + side] / math.sqrt(r2)
            slope = drive * stiffness * floor2 / (drive * r2 + stiffness * floor2)
            W[SLIP_STIFFNESS + side] = stiffness
            W[LINE_SLOPE + side] = engaged * slope
            W[LINE_FORCE + side] = engaged * (stiffness * slip + slope * speed)
            W[RIM_TARGET + side], W[RIM_SHARE + side] = effective, 1.0 / (engaged * drive)
            return
    hold_or_coast(S, W, side, speed, floor2)


@njit(error_model="numpy")
def hold_or_coast(S, W, side, speed, floor2):
    """Describe a wheel that dry friction holds still (a dragged tyre), or one that turns freely in its gears' play.

    In the play the motor goes its own way, d w / dt = D (T - w) / m_w, which is what the rim speed then stands for.
    """
    stiffness = W[GRIP + side] / math.sqrt(speed * speed + floor2)
    W[SLIP_STIFFNESS + side], W[LINE_SLOPE + side], W[LINE_FORCE + side] = stiffness, stiffness, 0.0
    W[RIM_TARGET + side], W[RIM_SHARE + side] = 0.0, 0.0
    if W[ENGAGED + side] > 0.0:
        return
    W[SLIP_STIFFNESS + side], W[LINE_SLOPE + side] = W[GRIP + side] / math.sqrt(floor2), 0.0
    W[RIM_TARGET + side] = free_speed(
        S[RIM + side], W[TARGET + side], W[DRIVE + side], W[ROTATING], W[STEP]
    )


@njit(error_model="numpy")
def free_speed(rim, target, drive, rotating, h):
    """Return the rim speed [m/s] of an unloaded motor after h [s]; without rotating mass it is the target at once."""
    return target + (rim - target) * math.exp(-drive * h / rotating) if rotating > 0.0 else target


@njit(error_model="numpy")
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


@njit(error_model="numpy")
def finish_step(S, W):
    """Solve the balance for the new velocity and place the robot; the result lies in W from `NEXT` on."""
    h, m, cx, cy = W[STEP], W[MASS], W[COM_X], W[COM_Y]
    v, l, omega = S[V], S[L], S[OMEGA]
    gyro = m * omega
    b01, b02, b12 = W[DAMP + 1] - gyro, W[DAMP + 2] - gyro * cx, W[DAMP + 4] - gyro * cy
    b10, b20, b21 = W[DAMP + 1] + gyro, W[DAMP + 2] + gyro * cx, W[DAMP + 4] + gyro * cy
    b00, b11, b22 = W[DAMP], W[DAMP + 3], W[DAMP + 5]
    r0 = h * (W[FORCE_X] - b00 * v - b01 * l - b02 * omega)
    r1 = h * (W[FORCE_Y] - b10 * v - b11 * l - b12 * omega)
    r2 = h * (W[MOMENT] - b20 * v - b21 * l - b22 * omega)
    g = 0.5 * h
    a00, a01, a02 = m + g * b00, g * b01, g * b02 - m * cy
    a10, a11, a12 = g * b10, m + g * b11, g * b12 + m * cx
    a20, a21, a22 = g * b20 - m * cy, g * b21 + m * cx, W[INERTIA] + m * (cx * cx + cy * cy) + g * b22
    c00, c01, c02 = a11 * a22 - a12 * a21, a02 * a21 - a01 * a22, a01 * a12 - a02 * a11
    inverse = 1.0 / (a00 * c00 + a10 * c01 + a20 * c02)
    dv = (c00 * r0 + c01 * r1 + c02 * r2) * inverse
    dl = ((a12 * a20 - a10 * a22) * r0 + (a00 * a22 - a02 * a20) * r1 + (a02 * a10 - a00 * a12) * r2) * inverse
    dw = ((a10 * a21 - a11 * a20) * r0 + (a01 * a20 - a00 * a21) * r1 + (a00 * a11 - a01 * a10) * r2) * inverse
    W[NEXT + V], W[NEXT + L], W[NEXT + OMEGA] = settle(v + dv), settle(l + dl), settle(omega + dw)
    W[MEAN_OMEGA] = 0.5 * (omega + W[NEXT + OMEGA])
    turn_wheels(S, W)


@njit(error_model="numpy", inline="always")
def settle(speed):
    """Return zero for a speed that is too small to matter (`STILL`)."""
    return speed if abs(speed) > STILL else 0.0


@njit(error_model="numpy")
def turn_wheels(S, W):
    """Advance the wheels' angles [rad] and rim speeds [m/s] with the body's mean speed over the step."""
    v = 0.5 * (S[V] + W[NEXT + V])
    for side in range(2):
        arm = W[HALF_AXLE] if side == 0 else -W[HALF_AXLE]
        speed = v - arm * W[MEAN_OMEGA]
        force = W[LINE_FORCE + side] - W[LINE_SLOPE + side] * speed
        mean = W[RIM_TARGET + side] - W[RIM_SHARE + side] * force
        held = W[RIM_SHARE + side] == 0.0 and W[ENGAGED + side] > 0.0
        S[RIM + side] = 0.0 if held else settle(S[RIM + side] + (mean - S[RIM + side]) / lead(W, side))
        S[ANGLE + side] += W[STEP] * mean / W[RADIUS + side]


@njit(error_model="numpy")
def place_robot(S, W):
    """Move the centre of mass by the mean of its old and new velocity in `world`, and the axle with it."""
    h, cx, cy = W[STEP], W[COM_X], W[COM_Y]
    theta = S[THETA] + h * W[MEAN_OMEGA]
    c0, s0 = S[HEADING_COS], S[HEADING_SIN]
    dc, ds = small_rotation(theta - S[THETA])
    c1, s1 = c0 * dc - s0 * ds, s0 * dc + c0 * ds
    W[NEXT_COS], W[NEXT_SIN] = c1, s1
    vx, vy = S[V] - S[OMEGA] * cy, S[L] + S[OMEGA] * cx
    ux, uy = W[NEXT + V] - W[NEXT + OMEGA] * cy, W[NEXT + L] + W[NEXT + OMEGA] * cx
    W[NEXT_VX], W[NEXT_VY] = c1 * ux - s1 * uy, s1 * ux + c1 * uy
    W[MEAN_VX] = 0.5 * (c0 * vx - s0 * vy + W[NEXT_VX])
    W[MEAN_VY] = 0.5 * (s0 * vx + c0 * vy + W[NEXT_VY])
    W[NEXT + X] = S[X] + (c0 - c1) * cx - (s0 - s1) * cy + h * W[MEAN_VX]
    W[NEXT + Y] = S[Y] + (s0 - s1) * cx + (c0 - c1) * cy + h * W[MEAN_VY]
    W[NEXT + THETA] = theta


@njit(error_model="numpy", inline="always")
def small_rotation(angle):
    """Return cosine and sine of an angle [rad]; by their series when it is small, to the last digit, for speed."""
    if abs(angle) > 0.05:
        return math.cos(angle), math.sin(angle)
    q = angle * angle
    cosine = 1.0 - q * (0.5 - q * (1.0 / 24.0 - q * (1.0 / 720.0 - q / 40320.0)))
    return cosine, angle * (1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0 - q * (1.0 / 5040.0 - q / 362880.0))))


@njit(error_model="numpy")
def accept_step(S, W):
    """Make the result of the step the new state."""
    for i in range(6):
        S[i] = W[NEXT + i]
    S[HEADING_COS], S[HEADING_SIN] = W[NEXT_COS], W[NEXT_SIN]
    S[TIME] += W[STEP]


@njit(error_model="numpy")
def look_around(S, W):
    """Use the simulated pose and wheel angles where an effect asks for place, heading or roll."""
    W[slots.PLACE_X], W[slots.PLACE_Y] = S[X], S[Y]
    W[COS], W[SIN] = S[HEADING_COS], S[HEADING_SIN]
    W[slots.ROLL], W[slots.ROLL + 1] = S[ANGLE], S[ANGLE + 1]
