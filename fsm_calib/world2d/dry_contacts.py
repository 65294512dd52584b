r"""Dry friction between body and floor, solved with the step: it holds what is too weak to move, and lets go at once.

The step without it gives the velocity q0 = (v [m/s], l [m/s], omega [rad/s]) of the robot. A contact with speed
u = J q [m/s or rad/s] adds an impulse p [N s or N m s] against it:

    q = q0 + A^-1 J' p        p = -h F (u / sqrt(u^2 + c1^2) + u / sqrt(u^2 + c2^2)) / 2        at the end of the step

h [s] the step, F [N or N m] the friction, A the step's mass matrix, c the creep speeds below which either half of the
contact acts as a damper (0: none does; it is held while |p| < h F). A contact that slides any way has the direction of
its own velocity without friction. Several contacts are solved in turn, again and again, each with the impulses of the
others, from those of the step before on: where they slide on, little is left to be found.
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

FORCE, ALONG_V, ALONG_L, ALONG_OMEGA, CREEP, OTHER_CREEP, IMPULSE, ACROSS = 0, 1, 2, 3, 4, 5, 6, 7
"""What is kept of a contact: F, its row J, c1, c2, p; a point that slides any way has its place [m] in J's first two,
and a second impulse."""
ANSWER, ANSWER_ACROSS, SPEED = 8, 11, 14
"""What the impulses p change of (v, l, omega), each by 1 N s (three places), and the speed that friction left last."""
ANY_WAY = -1.0
"""In place of a creep speed: the contact is a point that slides in any direction."""
SWEEPS, TOLERANCE = 20, 1e-9
"""Most rounds over several contacts; the change of impulse [N s] at which they end."""
NEWTON_STEPS, SPEED_TOLERANCE = 30, 1e-7
"""Most iterations for the speed that friction leaves; the change [m/s, rad/s] at which they end."""
TINY = 1e-24
"""Square of a speed [m2/s2] that is none: a tread that stands has no creep."""


@njit(**ARITHMETIC)
def add_contact(W, force, jv, jl, jw, creep, other):
    """Add a contact of friction `force` along the row (jv, jl, jw); without friction, or past `MOST_CONTACTS`, none."""
    count = int(W[CONTACTS])
    if force <= 0.0 or count >= MOST_CONTACTS:
        return
    at = CONTACT + count * CONTACT_SIZE
    W[at + FORCE], W[at + CREEP], W[at + OTHER_CREEP] = force, creep, other
    W[at + ALONG_V], W[at + ALONG_L], W[at + ALONG_OMEGA] = jv, jl, jw
    W[CONTACTS] = count + 1.0


@njit(**ARITHMETIC)
def brake(W, v, l, omega):
    """Return the twist (v, l, omega) that the contacts leave of the one that the step gave without them."""
    count = int(W[CONTACTS])
    for i in range(count):
        v, l, omega = begun(W, CONTACT + i * CONTACT_SIZE, v, l, omega)
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


@njit(**ARITHMETIC, forceinline=True)
def begun(W, at, v, l, omega):
    """Note what a contact's impulses change in this step; return the twist with those of the step before."""
    if W[at + CREEP] == ANY_WAY:
        x, y, across = W[at + ALONG_V], W[at + ALONG_L], W[at + ACROSS]
        dv, dl, dw = answer(W, 1.0, 0.0, -y)
        ev, el, ew = answer(W, 0.0, 1.0, x)
        W[at + ANSWER_ACROSS], W[at + ANSWER_ACROSS + 1], W[at + ANSWER_ACROSS + 2] = ev, el, ew
        v, l, omega = v + ev * across, l + el * across, omega + ew * across
    else:
        dv, dl, dw = answer(W, W[at + ALONG_V], W[at + ALONG_L], W[at + ALONG_OMEGA])
    W[at + ANSWER], W[at + ANSWER + 1], W[at + ANSWER + 2] = dv, dl, dw
    impulse = W[at + IMPULSE]
    return v + dv * impulse, l + dl * impulse, omega + dw * impulse


@njit(**ARITHMETIC, forceinline=True)
def brake_line(W, at, v, l, omega):
    """Solve a contact along one direction; return the twist and how much its impulse changed."""
    jv, jl, jw, before = W[at + ALONG_V], W[at + ALONG_L], W[at + ALONG_OMEGA], W[at + IMPULSE]
    dv, dl, dw = W[at + ANSWER], W[at + ANSWER + 1], W[at + ANSWER + 2]
    give = jv * dv + jl * dl + jw * dw
    free = jv * v + jl * l + jw * omega - give * before
    left = slowed(free, W[STEP] * W[at + FORCE] * give, W[at + CREEP], W[at + OTHER_CREEP], W[at + SPEED])
    impulse = (left - free) / give
    change = impulse - before
    W[at + IMPULSE], W[at + SPEED] = impulse, abs(left)
    return v + dv * change, l + dl * change, omega + dw * change, abs(change)


@njit(**ARITHMETIC, forceinline=True)
def brake_point(W, at, v, l, omega):
    """Solve a contact that slides any way at the point (x, y) of `base`; return as `brake_line`."""
    x, y, px, py = W[at + ALONG_V], W[at + ALONG_L], W[at + IMPULSE], W[at + ACROSS]
    ax, bx, cx = W[at + ANSWER], W[at + ANSWER + 1], W[at + ANSWER + 2]
    ay, by, cy = W[at + ANSWER_ACROSS], W[at + ANSWER_ACROSS + 1], W[at + ANSWER_ACROSS + 2]
    xx, xy, yx, yy = ax - y * cx, ay - y * cy, bx + x * cx, by + x * cy
    ux, uy = v - y * omega - xx * px - xy * py, l + x * omega - yx * px - yy * py
    speed = math.sqrt(ux * ux + uy * uy)
    size, ex, ey = 0.0, 0.0, 0.0
    if speed > 0.0:
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
def slowed(free, reach, creep, other, guess):
    """Return the speed x that friction leaves of a `free` one: x + reach (x / q1 + x / q2) / 2 = free.

    q = sqrt(x^2 + c^2), c the creep speed and the other one; `reach` is what friction takes off in the step while it
    slides, `guess` where the search begins. Newton's method: the left side is concave, so that it climbs from below.
    """
    far = abs(free)
    least = max(far - reach, 0.0)
    if creep == 0.0 and other == 0.0:
        return math.copysign(least, free)
    x, half, c2, d2 = min(max(guess, least), far), 0.5 * reach, creep * creep, other * other
    for _ in range(NEWTON_STEPS):
        p2, q2 = x * x + c2 + TINY, x * x + d2 + TINY
        p, q = 1.0 / math.sqrt(p2), 1.0 / math.sqrt(q2)
        change = (far - x - half * x * (p + q)) / (1.0 + half * (c2 * p / p2 + d2 * q / q2))
        x = max(x + change, least)
        if abs(change) < SPEED_TOLERANCE:
            break
    return math.copysign(x, free)
