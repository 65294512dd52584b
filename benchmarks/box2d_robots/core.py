"""One step of wheels, motors and third points, compiled: from the body's motion to the forces on it.

Tyres are dynamic brushes (Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 3 and 7): two contact points for
each wheel, whose bristles bend with slip, relax over a rolled length and let go on the friction circle
along the brush's cubic. Dry friction on the shafts is a bristle too (Dahl), so that it holds at rest.
Motors have a winding with inductance; gears lose a share of what passes, either way.

Arrays: P does not change in a run, X is set anew in every step (by `machine.py` and the laws), S is the
state, OUT what the body feels: force along and to the left [N], torque about the axle's middle [N m].
"""

from __future__ import annotations

import math

import numba

from benchmarks.robot_sets.driving import Array

G = 9.81
# X: pairs are left, right
DUTY, VOLTS, KT, KE, RES, DRY, VISC, TORQUE = 0, 2, 4, 6, 8, 10, 12, 14
BLOCK, GRIP, ALONG, ACROSS, RELAX, ROLL, RADIUS, TRACK = 16, 18, 20, 22, 24, 26, 28, 30
TOE, SCRUB, BASE, LIFT, FLOOR_X, FLOOR_Y, PLAY, SIDE = 32, 34, 36, 38, 40, 42, 44, 46
SLOPE, FORCE, SLIDE, CROLL, SWIVEL, INPUTS = 48, 50, 53, 54, 55, 56
# P
MASS, CX, CY, CH, JW, JR, TAU, ETA, THIRD_X, THIRD_Y, AHEAD, TRAIL, FORK, PRE, SUBS, MESH, REVERSE, PARAMS = (
    range(18)
)
# S
RATE, ANGLE, ROTOR, TURNED, AMPS, Z, U, SWING, CU, AX = 0, 2, 4, 6, 8, 10, 12, 20, 21, 27
LOAD, SLIP, PULL, CLOAD, VX, VY, W, GEAR, STATES = 29, 31, 33, 35, 37, 38, 39, 40, 42

ACCEL_LAG = 0.03  # s
_jit = numba.njit(fastmath=False, cache=True)


@_jit
def _loads(P: Array, X: Array, S: Array) -> None:
    """Set the loads of wheels, third point and front glide from weight, slope and (lagged) acceleration."""
    weight = P[MASS] * G + X[LIFT] + X[LIFT + 1]
    ax, ay = S[AX] - X[SLOPE], S[AX + 1] - X[SLOPE + 1]
    back = P[MASS] * (-P[CX] * G + ax * P[CH])  # moment that presses the rear down
    rear, front = 0.0, 0.0
    if back > 0.0:
        rear = min(back / -P[THIRD_X], 0.9 * weight)
    else:
        front = min(-back / P[AHEAD], 0.9 * weight)
    both = weight - rear - front
    width = X[TRACK] - X[TRACK + 1]
    aside = P[MASS] * (P[CY] * G - ay * P[CH]) / width + 0.5 * (X[LIFT] - X[LIFT + 1])
    aside = min(max(aside, -0.45 * both), 0.45 * both)
    S[LOAD], S[LOAD + 1] = 0.5 * both + aside, 0.5 * both - aside
    S[CLOAD], S[CLOAD + 1] = rear, front


@_jit
def _patch(
    X: Array,
    S: Array,
    i: int,
    k: int,
    sx: float,
    sy: float,
    roll: float,
    load: float,
    inert: float,
    dt: float,
) -> tuple[float, float]:
    """Move one contact's bristles by slip speeds (sx, sy); return the force on the body along and across."""
    u = U + 4 * i + 2 * k
    kx = max(X[ALONG + i] * load / X[RELAX + i], 1e-6)
    ky = max(X[ACROSS + i] * load / X[RELAX + i], 1e-6)
    keep = abs(roll) / X[RELAX + i]
    ux = (S[u] + dt * sx) / (1.0 + dt * keep)
    uy = (S[u + 1] + dt * sy) / (1.0 + dt * keep)
    qx, qy = kx * ux, ky * uy
    top = 3.0 * X[GRIP + i] * load + 1e-9
    side = X[SIDE + i]  # some wheels hold less across
    size = math.hypot(qx, qy / side)
    z = size / top
    if z > 1.0:
        ux, uy, qx, qy = ux / z, uy / z, qx / z, qy / z
        z = 1.0
    S[u], S[u + 1] = ux, uy
    share = 1.0 - z + z * z / 3.0  # of the brush: 3 z - 3 z^2 + z^3, over 3 z
    damp = 0.5 * (1.0 - z) / (1.0 + abs(roll) / 0.05)
    dx, dy = damp * math.sqrt(kx * inert), damp * math.sqrt(ky * inert)
    return -qx * share - dx * sx, -qy * share - dy * sy


@_jit
def _motor(P: Array, X: Array, S: Array, i: int, dt: float) -> float:
    """Advance the winding's current; return the torque at the wheel."""
    rate = S[ROTOR + i]
    volts = X[DUTY + i] * X[VOLTS + i]
    lag = P[TAU] / dt
    amps = (lag * S[AMPS + i] + (volts - X[KE + i] * rate) / X[RES + i]) / (1.0 + lag)
    if X[BLOCK + i] > 0.0 and amps * rate < 0.0:  # a bridge that lets the motor coast
        amps *= 1.0 - X[BLOCK + i]
    S[AMPS + i] = amps
    power = amps * rate * X[KE + i]
    part = math.tanh(power / (0.02 * X[VOLTS + i] * X[VOLTS + i] / X[RES + i]))
    kt = X[KT + i] * (1.0 - P[REVERSE]) if volts < 0.0 else X[KT + i]
    return kt * amps * (1.0 - (1.0 - P[ETA]) * part)


@_jit
def _shaft(P: Array, X: Array, S: Array, i: int, drive: float, tyre: float, dt: float) -> None:
    """Turn rotor and wheel by the motor's and the tyre's torque, less dry friction; with or without play."""
    hold = X[DRY + i] + X[ROLL + i] * S[LOAD + i] * X[RADIUS + i]
    pre = P[PRE]
    S[Z + i] = min(max(S[Z + i] + S[RATE + i] * dt, -pre), pre)
    tyre += X[TORQUE + i] - hold * S[Z + i] / pre
    damp = X[VISC + i] + 0.01 * hold / pre * (1.0 - abs(S[Z + i]) / pre)
    if X[PLAY + i] <= 0.0:
        turning = P[JW] + P[JR]
        S[RATE + i] += dt * (drive + tyre - damp * S[RATE + i]) / turning
        S[ANGLE + i] += dt * S[RATE + i]
        S[ROTOR + i], S[TURNED + i] = S[RATE + i], S[ANGLE + i]
        return
    less = min(P[JW], P[JR])
    gap = S[TURNED + i] - S[ANGLE + i]
    over = gap - min(max(gap, -X[PLAY + i]), X[PLAY + i])
    mesh = 0.0
    if over != 0.0:
        stiff = P[MESH]
        mesh = stiff * over + 0.6 * math.sqrt(stiff * less) * (S[ROTOR + i] - S[RATE + i])
        if mesh * over < 0.0:
            mesh = 0.0
    S[GEAR + i] = mesh
    S[ROTOR + i] += dt * (drive - mesh - 0.5 * damp * S[ROTOR + i]) / P[JR]
    S[RATE + i] += dt * (mesh + tyre - 0.5 * damp * S[RATE + i]) / P[JW]
    S[ANGLE + i] += dt * S[RATE + i]
    S[TURNED + i] += dt * S[ROTOR + i]


@_jit
def _wheel(P: Array, X: Array, S: Array, i: int, dt: float, out: Array) -> None:
    """Advance one wheel by a part of a step; add the forces on the body to `out`."""
    c, s = math.cos(X[TOE + i]), math.sin(X[TOE + i])
    r, y, w, base = X[RADIUS + i], X[TRACK + i], S[W], X[BASE + i]
    hx, hy = S[VX] - w * y - X[FLOOR_X + i], S[VY] - X[FLOOR_Y + i]
    rim, load = S[RATE + i] * r, 0.5 * S[LOAD + i]
    inert = min((P[JW] + P[JR]) / (r * r), 0.25 * P[MASS])
    tyre, slip = 0.0, 0.0
    for k in range(2):
        x = base if k == 0 else -base
        ax, ay = hx, hy + w * x
        sx, sy = c * ax + s * ay - rim, c * ay - s * ax
        fx, fy = _patch(X, S, i, k, sx, sy, rim, load, inert, dt)
        tyre -= fx * r
        slip += 0.5 * math.hypot(sx, sy)
        bx, by = c * fx - s * fy, s * fx + c * fy
        out[0] += bx
        out[1] += by
        out[2] += x * by - y * bx
        S[PULL + i] = bx if k == 0 else S[PULL + i] + bx
    S[SLIP + i] = slip
    if X[SCRUB + i] > 0.0:  # a wide contact that turns on the spot, less as it rolls
        spin = w * X[SCRUB + i] / (abs(rim) + 0.01)
        out[2] -= X[GRIP + i] * S[LOAD + i] * X[SCRUB + i] * spin / math.sqrt(1.0 + spin * spin)
    _shaft(P, X, S, i, _motor(P, X, S, i, dt), tyre, dt)


@_jit
def _sliding(X: Array, S: Array, n: int, x: float, y: float, load: float, dt: float, out: Array) -> None:
    """Let a point slide on the floor with dry friction that holds at rest (bristles of 0.3 mm)."""
    vx, vy = S[VX] - S[W] * y, S[VY] + S[W] * x
    u = CU + 2 * n
    ux, uy = S[u] + vx * dt, S[u + 1] + vy * dt
    far = math.hypot(ux, uy) / 3e-4
    if far > 1.0:
        ux, uy, far = ux / far, uy / far, 1.0
    S[u], S[u + 1] = ux, uy
    force = X[SLIDE] * load
    damp = 4.0 * force * (1.0 - far)
    fx, fy = -force * ux / 3e-4 - damp * vx, -force * uy / 3e-4 - damp * vy
    out[0] += fx
    out[1] += fy
    out[2] += x * fy - y * fx


@_jit
def _fork(P: Array, X: Array, S: Array, dt: float, out: Array) -> None:
    """Let a trailing fork swing to follow its pivot; its wheel rolls with resistance, its pivot turns with
    friction.
    """
    vx, vy = S[VX], S[VY] + S[W] * P[THIRD_X]
    c, s = math.cos(S[SWING]), math.sin(S[SWING])
    along, across = c * vx + s * vy, c * vy - s * vx
    turn = across / P[TRAIL] - S[W]
    S[SWING] += dt * turn
    load = S[CLOAD]
    moment = X[SWIVEL] * load * math.tanh(turn / 0.15)
    pull = -X[CROLL] * load * math.tanh(along / 0.004)
    push = -moment / P[TRAIL]
    fx, fy = c * pull - s * push, s * pull + c * push
    out[0] += fx
    out[1] += fy
    out[2] += P[THIRD_X] * fy + moment


@_jit
def advance(P: Array, X: Array, S: Array, dt: float, out: Array) -> None:
    """Advance all but the body by dt [s]; set the mean force and torque on the body about the axle's
    middle.
    """
    _loads(P, X, S)
    out[:] = 0.0
    parts = int(P[SUBS])
    for _ in range(parts):
        _wheel(P, X, S, 0, dt / parts, out)
        _wheel(P, X, S, 1, dt / parts, out)
    out /= parts
    if P[FORK] > 0.5:
        _fork(P, X, S, dt, out)
    elif P[THIRD_Y] > 0.0:
        _sliding(X, S, 0, P[THIRD_X], P[THIRD_Y], 0.5 * S[CLOAD], dt, out)
        _sliding(X, S, 1, P[THIRD_X], -P[THIRD_Y], 0.5 * S[CLOAD], dt, out)
    else:
        _sliding(X, S, 0, P[THIRD_X], 0.0, S[CLOAD], dt, out)
    _sliding(X, S, 2, P[AHEAD], 0.0, S[CLOAD + 1], dt, out)
    gx, gy = P[MASS] * X[SLOPE], P[MASS] * X[SLOPE + 1]
    out[0] += gx + X[FORCE]
    out[1] += gy + X[FORCE + 1]
    out[2] += P[CX] * gy - P[CY] * gx + X[FORCE + 2]


@_jit
def begin(P: Array, S: Array, X: Array, nominal: Array, world: tuple[float, ...], step: float) -> None:
    """Set the body's motion in the state, and the inputs to their nominal values.

    world : velocity of the centre of mass, now and before, turn rate, heading. Accelerations are lagged, as
    tyres do it.
    """
    vx, vy, ox, oy, w, yaw = world
    c, s = math.cos(yaw), math.sin(yaw)
    S[VX], S[VY], S[W] = c * vx + s * vy + w * P[CY], c * vy - s * vx - w * P[CX], w
    ax, ay = (vx - ox) / step, (vy - oy) / step
    keep = math.exp(-step / ACCEL_LAG)
    S[AX] = keep * S[AX] + (1.0 - keep) * (c * ax + s * ay)
    S[AX + 1] = keep * S[AX + 1] + (1.0 - keep) * (c * ay - s * ax)
    X[:] = nominal


@_jit
def felt(P: Array, X: Array, S: Array, dt: float, yaw: float, out: Array) -> tuple[float, float, float]:
    """Advance all but the body; return force on the floor's axes and torque about the centre of mass."""
    advance(P, X, S, dt, out)
    c, s = math.cos(yaw), math.sin(yaw)
    fx, fy = out[0], out[1]
    return c * fx - s * fy, s * fx + c * fy, out[2] - (P[CX] * fy - P[CY] * fx)
