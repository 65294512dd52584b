"""A planar differential-drive robot on tyres, integrated with semi-implicit Euler steps of 0.5 ms.

A rigid body (mass, yaw inertia, centre of mass off the axle centre) on two driven wheels and a caster. Tyres: Pacejka's
magic formula, the cubic brush model (Pacejka, Tyre and Vehicle Dynamics, ch. 3 and 4) or Janosi & Hanamoto's
exponential shear (Wong, Theory of Ground Vehicles, ch. 2), each by the combined theoretical slip; each wheel may be cut
into strips across its width, which makes it resist turning (Wong ch. 6 on steering of wide tracks). Caster: kinematics
of a trailing wheel with rolling and swivel friction (Campion, Bastin & d'Andrea-Novel, IEEE T-RA 12, 1996), or a ball.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from foreign.motor import (
    CURRENT,
    VOLTS,
    supply_step,
    wheel_torque,
)

STEP = 0.0005  # s
GRAVITY = 9.81
X, Y, THETA, U, V, R, WL, WR, PHL, PHR, SWIVEL, BODY_STATES = range(12)
FX, FY, MZ, MU_L, MU_R, SLACK_L, SLACK_R, DRAG_L, DRAG_R, DRAG_C, FLOOR_X, FLOOR_Y, HOOKS = range(13)


class Body(NamedTuple):
    """Geometry, masses and contacts; SI units, body frame at the axle centre (x forward, y left)."""

    mass: float
    inertia: float  # about the centre of mass
    com_x: float
    com_y: float
    axle: float  # distance of the contact patches
    radius_left: float
    radius_right: float
    caster_x: float
    friction: float = 0.8
    stiffness: float = 6.0  # initial slope of the normalised tyre curve
    tyre: int = 0  # 0 magic formula, 1 brush, 2 exponential shear
    lateral: float = 1.0  # lateral stiffness over longitudinal
    lateral_grip: float = 1.0  # lateral friction over longitudinal
    patch_width: float = 0.0  # width of a tyre that is cut into strips
    pivot: float = 0.0  # dry moment against turning, share of load times m
    swirl: float = 0.0  # viscous moment against turning [N m s]
    rolling: float = 0.008  # rolling resistance of the wheels, share of the load
    caster_rolling: float = 0.01
    caster_ball: float = 0.0  # sliding friction of a ball caster, share of its load
    caster_viscous: float = 0.0  # gritty ball [N s/m]
    caster_swivel: float = 0.0  # dry swivel torque, share of load times m
    caster_trail: float = 0.02
    ecc_left: tuple[float, float, float, float] = (
        0.0,
        0.0,
        0.0,
        0.0,
    )  # offset, phase, oval, bump [m, rad, m, m]
    ecc_right: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


@njit(cache=True)
def tyre_force(slip: float, law: int, stiffness: float) -> float:
    """Normalised force in [0, 1] at the combined slip."""
    if law == 0:
        x = stiffness * slip / (1.5 * 1.0)
        return np.sin(1.5 * np.arctan(x))
    if law == 1:
        x = min(stiffness * slip / 3.0, 1.0)
        return 3.0 * x - 3.0 * x * x + x * x * x
    return 1.0 - np.exp(-stiffness * slip)


@njit(cache=True)
def rolling_radius(radius: float, angle: float, ecc: tuple[float, float, float, float]) -> float:
    """Radius under the hub of a wheel with an offset hub, an oval tyre and one bump (a strip of tape)."""
    offset, phase, oval, bump = ecc
    a = angle - phase
    value = radius + offset * np.cos(a) + oval * np.cos(2.0 * a)
    if bump != 0.0:
        near = np.cos(a)
        value += bump * np.exp((near - 1.0) / 0.03)
    return value


@njit(cache=True)
def tyre_plane(
    rim: float, vx: float, vy: float, load: float, mu: float, slack: float, regular: float, b: Body
) -> tuple[float, float]:
    """Forces (forward, left) of the floor on one tyre, contact point at (vx, vy), rim speed `rim` [m/s]."""
    den = abs(rim) + regular
    sx = (rim - vx) / den
    sy = -vy / den * b.lateral
    slip = np.sqrt(sx * sx + sy * sy)
    if slip < 1e-12:
        return 0.0, 0.0
    force = mu * load * tyre_force(slip, b.tyre, b.stiffness * slack) / slip
    return force * sx, force * sy * b.lateral_grip


@njit(cache=True)
def advance(duty, q, ml, mr, battery, hook, left, right, supply, b, out, every):
    """Integrate len(duty) steps; duty (n, 2), q (11,), hook (12,), out (n // every, 11) gets the states."""
    dt = STEP
    xw, xc = -b.com_x, b.caster_x - b.com_x
    weight = b.mass * 9.81
    load_c = max(weight * b.com_x / b.caster_x, 0.02 * weight)
    rest = weight - load_c
    right_share = min(max(0.5 - b.com_y / b.axle, 0.05), 0.95)
    load_l, load_r = rest * (1.0 - right_share), rest * right_share
    regular = 9.81 * b.friction * b.stiffness * dt / 0.6 * (1.0 + b.mass * b.radius_left**2 / 2 / left.rotor)
    regular = max(0.03, min(regular, 0.5))
    strips = 5 if b.patch_width > 0.0 else 1
    for k in range(len(duty)):
        supply_step(dt, ml[CURRENT] + mr[CURRENT], battery, supply)
        volts = battery[VOLTS]
        tl = wheel_torque(dt, duty[k, 0], q[PHL], q[WL], volts, ml, left)
        tr = wheel_torque(dt, duty[k, 1], q[PHR], q[WR], volts, mr, right)
        c, s = np.cos(q[THETA]), np.sin(q[THETA])
        u, v, r = q[U], q[V], q[R]
        fu = c * hook[FLOOR_X] + s * hook[FLOOR_Y]
        fv = -s * hook[FLOOR_X] + c * hook[FLOOR_Y]
        fx = c * hook[FX] + s * hook[FY]
        fy = -s * hook[FX] + c * hook[FY]
        mz = hook[MZ] - b.swirl * r
        vy = v + r * xw - fv
        for side in range(2):
            y = (0.5 if side == 0 else -0.5) * b.axle - b.com_y
            load = load_l if side == 0 else load_r
            mu = b.friction * (hook[MU_L] if side == 0 else hook[MU_R])
            slack = hook[SLACK_L] if side == 0 else hook[SLACK_R]
            drag = b.rolling + (hook[DRAG_L] if side == 0 else hook[DRAG_R])
            rate = q[WL] if side == 0 else q[WR]
            if side == 0:
                radius = rolling_radius(b.radius_left, q[PHL], b.ecc_left)
            else:
                radius = rolling_radius(b.radius_right, q[PHR], b.ecc_right)
            total = 0.0
            for strip in range(strips):
                yy = y + (((strip + 0.5) / strips - 0.5) * b.patch_width if strips > 1 else 0.0)
                gx, gy = tyre_plane(rate * radius, u - r * yy - fu, vy, load / strips, mu, slack, regular, b)
                fx += gx
                fy += gy
                mz += xw * gy - yy * gx
                total += gx
            mz -= b.pivot * load * np.tanh(r / 0.15)
            loss = drag * load * radius * np.tanh(rate * radius / 0.01)
            if side == 0:
                inertia = left.rotor * (0.25 if left.gap > 0.0 else 1.0)
                q[WL] += dt * (tl - total * radius - loss) / inertia
            else:
                inertia = right.rotor * (0.25 if right.gap > 0.0 else 1.0)
                q[WR] += dt * (tr - total * radius - loss) / inertia
        pu, pv = u - fu, v + r * xc - fv
        speed = np.sqrt(pu * pu + pv * pv)
        grain = load_c * b.caster_ball / (speed + 0.01) + b.caster_viscous
        cw, sw = np.cos(q[SWIVEL]), np.sin(q[SWIVEL])
        roll, side_v = pu * cw + pv * sw, -pu * sw + pv * cw
        turn = side_v / b.caster_trail - r
        q[SWIVEL] += dt * turn
        along = -(b.caster_rolling + hook[DRAG_C]) * load_c * np.tanh(roll / 0.01)
        torque = b.caster_swivel * load_c * (1.0 + np.exp(-((turn / 2.0) ** 2))) * np.tanh(turn / 0.5)
        across = -torque / b.caster_trail
        cx = -grain * pu + along * cw - across * sw
        cy = -grain * pv + along * sw + across * cw
        fx += cx
        fy += cy
        mz += xc * cy + torque
        q[U] += dt * (fx / b.mass + v * r)
        q[V] += dt * (fy / b.mass - u * r)
        q[R] += dt * mz / b.inertia
        c, s = np.cos(q[THETA]), np.sin(q[THETA])
        q[X] += dt * (c * q[U] - s * q[V])
        q[Y] += dt * (s * q[U] + c * q[V])
        q[THETA] += dt * q[R]
        q[PHL] += dt * q[WL]
        q[PHR] += dt * q[WR]
        if (k + 1) % every == 0:
            out[(k + 1) // every - 1, :] = q
