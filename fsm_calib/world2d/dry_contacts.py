r"""Dry friction between body and floor, solved with the step: it holds what is too weak to move, and lets go at once.

The step without it gives the velocity q0 = (v [m/s], l [m/s], omega [rad/s]) of the robot. A contact with speed
u = J q [m/s or rad/s] adds an impulse p [N s or N m s] against it:

    q = q0 + A^-1 J' p        p = -h F u / sqrt(u^2 + c^2)        at the end of the step

h [s] the step, F [N or N m] the friction, A the step's mass matrix, c the creep speed below which the contact acts as
a damper (0: none does; it is held while |p| < h F). A contact that slides any way has the direction of its own velocity
without friction. Several contacts are solved in turn, again and again, each with the impulses of the others.
Implicit in u: no contact moves the robot backwards, creeps, or lets go a few steps late, as a damper that is frozen
over a step does. Friction of places on the floor is no contact here (`forces.add_dry_friction`): held so firmly, a
robot says little about the place that holds it, and of twenty hidden places nine were found where seventeen are.

Source: time stepping of rigid bodies with friction, Moreau, in Nonsmooth Mechanics and Applications, 1988, sections 10
and 11; projected Gauss-Seidel, Jourdan, Alart & Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.slots import CONTACT, CONTACT_SIZE, CONTACTS, INVERSE, MOST_CONTACTS, STEP

FORCE, ALONG_V, ALONG_L, ALONG_OMEGA, CREEP, IMPULSE, ACROSS = 0, 1, 2, 3, 4, 5, 6
"""What is kept of a contact: F, its row J, c, p; a point that slides any way has its place [m] in J's first two, and
a second impulse."""
ANY_WAY = -1.0
"""In place of a creep speed: the contact is a point that slides in any direction."""
SWEEPS, TOLERANCE = 20, 1e-9
"""Most rounds over several contacts; the change of impulse [N s] at which they end."""
NEWTON_STEPS, SPEED_TOLERANCE = 30, 1e-7
"""Most iterations for the speed that friction leaves; the change [m/s, rad/s] at which they end."""


@njit(**ARITHMETIC)
def add_contact(W, force, jv, jl, jw, creep):
    """Add a contact of friction `force` along the row (jv, jl, jw); without friction, or past `MOST_CONTACTS`, none."""
    count = int(W[CONTACTS])
    if force <= 0.0 or count >= MOST_CONTACTS:
        return
    at = CONTACT + count * CONTACT_SIZE
    W[at + FORCE], W[at + CREEP] = force, creep
    W[at + ALONG_V], W[at + ALONG_L], W[at + ALONG_OMEGA] = jv, jl, jw
    W[at + IMPULSE] = W[at + ACROSS] = 0.0
    W[CONTACTS] = count + 1.0


@njit(**ARITHMETIC)
def brake(W, v, l, omega):
    """Return the twist (v, l, omega) that the contacts leave of the one that the step gave without them."""
    count = int(W[CONTACTS])
    for _ in range(SWEEPS if count > 1 else 1):
        most = 0.0
        for i in range(count):
            at = CONTACT + i * CONTACT_SIZE
            if W[at + CREEP] == ANY_WAY:
                v, l, omega, change = brake_point(W, at, v, l, omega)
            else:
                v, l, omega, change = brake_line(W, at, v, l, omega)
            most = max(most, change)
        if most < TOLERANCE:
            break
    return v, l, omega


@njit(**ARITHMETIC)
def brake_line(W, at, v, l, omega):
    """Solve a contact along one direction; return the twist and how much its impulse changed."""
    jv, jl, jw, before = W[at + ALONG_V], W[at + ALONG_L], W[at + ALONG_OMEGA], W[at + IMPULSE]
    dv, dl, dw = answer(W, jv, jl, jw)
    give = jv * dv + jl * dl + jw * dw
    free = jv * v + jl * l + jw * omega - give * before
    left = slowed(free, W[STEP] * W[at + FORCE] * give, W[at + CREEP])
    impulse = (left - free) / give
    change = impulse - before
    W[at + IMPULSE] = impulse
    return v + dv * change, l + dl * change, omega + dw * change, abs(change)


@njit(**ARITHMETIC)
def brake_point(W, at, v, l, omega):
    """Solve a contact that slides any way at the point (x, y) of `base`; return as `brake_line`."""
    x, y, px, py = W[at + ALONG_V], W[at + ALONG_L], W[at + IMPULSE], W[at + ACROSS]
    ax, bx, cx = answer(W, 1.0, 0.0, -y)
    ay, by, cy = answer(W, 0.0, 1.0, x)
    xx, xy, yx, yy = ax - y * cx, ay - y * cy, bx + x * cx, by + x * cy
    ux, uy = v - y * omega - xx * px - xy * py, l + x * omega - yx * px - yy * py
    speed = math.sqrt(ux * ux + uy * uy)
    if speed == 0.0:
        return v, l, omega, 0.0
    ex, ey = ux / speed, uy / speed
    give = ex * (xx * ex + xy * ey) + ey * (yx * ex + yy * ey)
    size = min(W[STEP] * W[at + FORCE], speed / give)
    gx, gy = -size * ex - px, -size * ey - py
    W[at + IMPULSE], W[at + ACROSS] = -size * ex, -size * ey
    return v + ax * gx + ay * gy, l + bx * gx + by * gy, omega + cx * gx + cy * gy, abs(gx) + abs(gy)


@njit(**ARITHMETIC, forceinline=True)
def answer(W, fv, fl, fw):
    """Return the change of the twist by the impulse (fv, fl, fw) [N s, N s, N m s]: A^-1 times it."""
    return (
        W[INVERSE] * fv + W[INVERSE + 1] * fl + W[INVERSE + 2] * fw,
        W[INVERSE + 3] * fv + W[INVERSE + 4] * fl + W[INVERSE + 5] * fw,
        W[INVERSE + 6] * fv + W[INVERSE + 7] * fl + W[INVERSE + 8] * fw,
    )


@njit(**ARITHMETIC, forceinline=True)
def slowed(free, reach, creep):
    """Return the speed x that friction leaves of a `free` one: x + reach x / sqrt(x^2 + creep^2) = free.

    `reach` is what it takes off in the step while it slides. Newton's method from below: the left side is concave.
    """
    far = abs(free)
    x = max(far - reach, 0.0)
    if creep > 0.0:
        for _ in range(NEWTON_STEPS):
            q2 = x * x + creep * creep
            q = math.sqrt(q2)
            change = (far - x - reach * x / q) / (1.0 + reach * creep * creep / (q2 * q))
            x += change
            if abs(change) < SPEED_TOLERANCE:
                break
    return math.copysign(x, free)
