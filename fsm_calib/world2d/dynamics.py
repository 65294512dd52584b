r"""The base robot: a rigid body on two motor-driven, slipping wheels, one step at a time, compiled.

Equations, in the frame `base` at the axle centre, q = (v [m/s], l [m/s], omega [rad/s]):

    M(c) dq/dt + omega G(c) q + A q = f

M is the mass matrix of a body of mass m [kg] with its centre of mass at c [m], G its gyroscopic matrix, A and
f the forces: linear in q with coefficients that are frozen over a step, and constant. Each wheel at (0,
+-b/2) obeys

    motor, wheel    m_w dw/dt = D (T - w) - F                 D = (m + 2 m_w) / (2 tau_forward) [N s/m]
    tyre            (F, S) = mu N s / sqrt(|s|^2 + s1^2)      s = (w - v_i, -l) slip velocity [m/s]
                    s1^2 = s0^2 + kappa^2 (v^2 + (b omega / 2)^2)

with rim speed w [m/s], no-load speed T = gain * command [m/s], speed of the axle's end v_i = v -+ omega b/2,
friction coefficient mu [1], load N [N] and the rotating inertia as a mass at the rim, m_w = J / R^2 [kg]. The slip
speed s0 [m/s] is that of a tyre that does not roll; where it rolls, its tread is dragged along only as long as it is in
contact, and slip over rolling speed counts, the slip ratio kappa [1] (v^2 + (b omega / 2)^2: the mean square of both
wheels' speeds). tau_forward [s] and tau_turn [s] are the time constants of the robot on gripping tyres:
yaw inertia enters as tau_turn = (I + m_w b^2/2) / (D b^2/2).

The torque-speed line is that of a permanent-magnet motor, tau = stall (g u - rate/no_load): T = g no_load R u
and D = stall / (R^2 no_load).

Method: driven wheels enter by the tangent of their crossing, sliding tyres by their secant (force / slip), both
frozen over the step; then the trapezoid rule is applied to the linear rest, and dry friction of the body on the floor
is solved with the step (`dry_contacts`). It is stable for any step, adds no energy (tangents and secants are positive
and G is antisymmetric), is exactly still at standstill, and nearly of second order. Positions follow from the mean of
the old and the new velocity.

Sources: torque-speed line, slip ratio and combined slip as in Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012,
sections 1.2.1, 1.2.2 and 3.2 (saturating law of the slip vector); linearly implicit stepping of stiff friction as in
Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.7; Duckiebot data in
`parameters`.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d import slots
from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.dry_contacts import brake
from fsm_calib.world2d.slots import (
    ANGLE,
    BASE_DRIVE,
    CARRIED_X,
    CARRIED_Y,
    COM_X,
    COM_Y,
    COMMAND,
    CONTACTS,
    COS,
    DAMP,
    DRIVE,
    DRY,
    ENGAGED,
    FORCE_X,
    FORCE_Y,
    FREE_ROTATING,
    GRIP,
    HALF_AXLE,
    HEADING_COS,
    HEADING_SIN,
    INERTIA,
    INVERSE,
    LOAD,
    MASS,
    MEAN_OMEGA,
    MEAN_VX,
    MEAN_VY,
    MOMENT,
    NEXT_VX,
    NEXT_VY,
    OMEGA,
    RADIUS,
    ROTATING,
    SIDE_COMPLIANCE,
    SIDE_DRIFT,
    SIN,
    SLIP_RATIO,
    SLIP_SPEED,
    STEP,
    TARGET,
    THETA,
    TIME,
    L,
    V,
    X,
    Y,
)
from fsm_calib.world2d.tyres import meet_ground, settle, turn_wheel

GAIN, AXLE, TAU_FORWARD, TAU_TURN, WHEEL_RADIUS, BODY_MASS = 0, 2, 3, 4, 5, 7
FRICTION, TYRE_SLIP, CASTER_SHARE, WHEEL_INERTIA, TYRE_RATIO, CHARGE = 8, 9, 10, 11, 12, 13
"""Places of the base parameters in the parameter vector P (`parameters.BASE` names them in this order)."""

LEAST_RATIO = 0.1
"""Yaw inertia over mass times the square of half the axle that is always left to the body (assumed): where
the time constants leave less, the wheels have less inertia, so that odd fits stay solvable."""


@njit(**ARITHMETIC)
def begin_base(P, W):
    """Set what stays the same for a whole roll-out: masses, geometry, motors; effects may change it
    afterwards.
    """
    mass, half = P[BODY_MASS], 0.5 * P[AXLE]
    W[:] = 0.0
    W[MASS], W[HALF_AXLE] = mass, half
    W[RADIUS], W[RADIUS + 1] = P[WHEEL_RADIUS], P[WHEEL_RADIUS + 1]
    W[SLIP_RATIO] = P[TYRE_RATIO]
    ratio = P[TAU_TURN] / P[TAU_FORWARD]
    rotating = P[WHEEL_INERTIA] / (0.5 * (W[RADIUS] + W[RADIUS + 1])) ** 2
    if ratio < 1.0:
        rotating = min(rotating, max(0.5 * mass * (ratio - LEAST_RATIO) / (1.0 - ratio), 0.0))
    W[ROTATING] = W[FREE_ROTATING] = rotating
    W[BASE_DRIVE] = (0.5 * mass + rotating) / P[TAU_FORWARD]
    W[INERTIA] = 2.0 * half * half * max(P[TAU_TURN] * W[BASE_DRIVE] - rotating, 0.5 * mass * LEAST_RATIO)


@njit(**ARITHMETIC)
def share_load(P, W):
    """Distribute the weight [N] over wheels and caster by the centre of mass; called once, after the effects'
    begin.

    The caster, `CASTER_ARM` behind the axle (farther on a robot larger than `SMALL_AXLE`), bears its share of the
    centred robot plus -x/arm; a centre of mass to the left loads the left wheel. No wheel is ever lifted: at least a
    tenth of its even load remains (assumed).
    """
    weight = W[MASS] * slots.GRAVITY
    arm = slots.CASTER_ARM * max(1.0, 2.0 * W[HALF_AXLE] / slots.SMALL_AXLE)
    wheels = min(max(1.0 - P[CASTER_SHARE] + W[COM_X] / arm, 0.1), 1.0) * weight
    left = min(max(0.5 + 0.5 * W[COM_Y] / W[HALF_AXLE], 0.05), 0.95)
    W[LOAD], W[LOAD + 1] = wheels * left, wheels * (1.0 - left)


@njit(**ARITHMETIC, forceinline=True)
def begin_step(P, W):
    """Fill the workbench with the base robot's values for one step; the commands and the step are already
    there.
    """
    drive = W[BASE_DRIVE]
    for side in range(2):
        W[TARGET + side] = P[CHARGE] * P[GAIN + side] * W[COMMAND + side]
        W[DRIVE + side] = drive
        W[DRY + side] = 0.0
        W[ENGAGED + side] = 1.0
        W[GRIP + side] = P[FRICTION] * W[LOAD + side]
    W[SLIP_SPEED] = P[TYRE_SLIP]
    W[SIDE_COMPLIANCE] = W[SIDE_DRIFT] = W[CARRIED_X] = W[CARRIED_Y] = 0.0
    W[FORCE_X] = W[FORCE_Y] = W[MOMENT] = W[CONTACTS] = 0.0
    for i in range(DAMP, DAMP + 6):
        W[i] = 0.0


@njit(**ARITHMETIC, forceinline=True)
def finish_step(S, W):
    """Move the robot by one step: the wheels meet the ground, the balance gives the velocity, that the pose.

    What a step works out is kept in local variables: on arrays, the processor mostly waits for memory.
    """
    half, v, l, omega = W[HALF_AXLE], S[V], S[L], S[OMEGA]
    left, right = meet_ground(S, W, v - half * omega, v + half * omega, l)
    v1, l1, omega1 = new_twist(W, half, left, right, v, l, omega)
    mean_v, mean_omega = 0.5 * (v + v1), 0.5 * (omega + omega1)
    turn_wheel(S, W, 0, left, mean_v - half * mean_omega)
    turn_wheel(S, W, 1, right, mean_v + half * mean_omega)
    place_robot(S, W, v1, l1, omega1)
    S[TIME] += W[STEP]


@njit(**ARITHMETIC, forceinline=True)
def new_twist(W, half, left, right, v, l, omega):
    """Solve the balance for the twist (v [m/s], l [m/s], omega [rad/s]) after the step; the wheels are those of
    `tyres.meet_ground`.
    """
    h, m, cx, cy = W[STEP], W[MASS], W[COM_X], W[COM_Y]
    soft, across_l, across_r = W[SIDE_COMPLIANCE], left[0], right[0]
    if soft > 0.0:
        across_l, across_r = across_l / (1.0 + across_l * soft), across_r / (1.0 + across_r * soft)
    gyro, along, twist = m * omega, left[1] + right[1], half * (right[1] - left[1])
    d00, d01, d02 = W[DAMP] + along, W[DAMP + 1], W[DAMP + 2] + twist
    d11, d12 = W[DAMP + 3] + across_l + across_r, W[DAMP + 4]
    b22 = W[DAMP + 5] + half * half * along
    b01, b02, b12 = d01 - gyro, d02 - gyro * cx, d12 - gyro * cy
    b10, b20, b21 = d01 + gyro, d02 + gyro * cx, d12 + gyro * cy
    r0 = h * (W[FORCE_X] + left[2] + right[2] - d00 * v - b01 * l - b02 * omega)
    r1 = h * (W[FORCE_Y] - b10 * v - d11 * l - b12 * omega)
    r2 = h * (W[MOMENT] + half * (right[2] - left[2]) - b20 * v - b21 * l - b22 * omega)
    g = 0.5 * h
    a00, a01, a02 = m + g * d00, g * b01, g * b02 - m * cy
    a10, a11, a12 = g * b10, m + g * d11, g * b12 + m * cx
    a20, a21, a22 = g * b20 - m * cy, g * b21 + m * cx, W[INERTIA] + m * (cx * cx + cy * cy) + g * b22
    c00, c01, c02 = a11 * a22 - a12 * a21, a02 * a21 - a01 * a22, a01 * a12 - a02 * a11
    c10, c11, c12 = a12 * a20 - a10 * a22, a00 * a22 - a02 * a20, a02 * a10 - a00 * a12
    c20, c21, c22 = a10 * a21 - a11 * a20, a01 * a20 - a00 * a21, a00 * a11 - a01 * a10
    inverse = 1.0 / (a00 * c00 + a10 * c01 + a20 * c02)
    dv = (c00 * r0 + c01 * r1 + c02 * r2) * inverse
    dl = (c10 * r0 + c11 * r1 + c12 * r2) * inverse
    dw = (c20 * r0 + c21 * r1 + c22 * r2) * inverse
    v1, l1, omega1 = v + dv, l + dl, omega + dw
    if W[CONTACTS] > 0.0:
        W[INVERSE], W[INVERSE + 1], W[INVERSE + 2] = c00 * inverse, c01 * inverse, c02 * inverse
        W[INVERSE + 3], W[INVERSE + 4], W[INVERSE + 5] = c10 * inverse, c11 * inverse, c12 * inverse
        W[INVERSE + 6], W[INVERSE + 7], W[INVERSE + 8] = c20 * inverse, c21 * inverse, c22 * inverse
        v1, l1, omega1 = brake(W, v1, l1, omega1)
    return settle(v1), settle(l1), settle(omega1)


@njit(**ARITHMETIC, forceinline=True)
def small_rotation(angle):
    """Return cosine and sine of an angle [rad]; by their series when it is small, to the last digit, for
    speed.
    """
    if abs(angle) > 0.05:
        return math.cos(angle), math.sin(angle)
    q = angle * angle
    cosine = 1.0 - q * (0.5 - q * (1.0 / 24.0 - q * (1.0 / 720.0 - q * (1.0 / 40320.0))))
    return cosine, angle * (
        1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0 - q * (1.0 / 5040.0 - q * (1.0 / 362880.0))))
    )


@njit(**ARITHMETIC, forceinline=True)
def place_robot(S, W, v1, l1, omega1):
    """Move the centre of mass by the mean of its old and new velocity in `world`, and the axle with it; the twist
    (v1, l1, omega1) after the step is the new state's.

    What the tyres drift sideways is added along the mean of the old and new heading, what the floor carries as it is.
    """
    h, cx, cy, drift = W[STEP], W[COM_X], W[COM_Y], W[SIDE_DRIFT]
    v, l, omega = S[V], S[L], S[OMEGA]
    mean_omega = 0.5 * (omega + omega1)
    c0, s0 = S[HEADING_COS], S[HEADING_SIN]
    dc, ds = small_rotation(h * mean_omega)
    c1, s1 = c0 * dc - s0 * ds, s0 * dc + c0 * ds
    vx, vy = v - omega * cy, l + omega * cx
    ux, uy = v1 - omega1 * cy, l1 + omega1 * cx
    next_vx, next_vy = c1 * ux - s1 * uy, s1 * ux + c1 * uy
    mean_vx = 0.5 * (c0 * vx - s0 * vy + next_vx - (s0 + s1) * drift) + W[CARRIED_X]
    mean_vy = 0.5 * (s0 * vx + c0 * vy + next_vy + (c0 + c1) * drift) + W[CARRIED_Y]
    S[X] += (c0 - c1) * cx - (s0 - s1) * cy + h * mean_vx
    S[Y] += (s0 - s1) * cx + (c0 - c1) * cy + h * mean_vy
    S[THETA] += h * mean_omega
    S[V], S[L], S[OMEGA], S[HEADING_COS], S[HEADING_SIN] = v1, l1, omega1, c1, s1
    W[NEXT_VX], W[NEXT_VY] = next_vx, next_vy
    W[MEAN_VX], W[MEAN_VY], W[MEAN_OMEGA] = mean_vx, mean_vy, mean_omega


@njit(**ARITHMETIC)
def look_around(S, W):
    """Use the simulated pose and wheel angles where an effect asks for place, heading or roll."""
    W[slots.PLACE_X], W[slots.PLACE_Y] = S[X], S[Y]
    W[COS], W[SIN] = S[HEADING_COS], S[HEADING_SIN]
    W[slots.ROLL], W[slots.ROLL + 1] = S[ANGLE], S[ANGLE + 1]
