r"""For a time, or several times in a drive, one motor (or both) loses part of its strength.

    T_i = K_i u_i (1 - loss_i)      start <= t < start + duration

T [m/s] no-load rim speed of wheel i, K [m/s] gain, u [1] command, loss [1], start and duration [s] on the
recording's clock. A stuck gear, a driver in thermal shutdown; a loose plug opens again and again, for moments of
their own and by the same loss. Sources: Roumeliotis, Sukhatme & Bekey, ICRA 1998 (the actuator faults of a mobile
robot); Slade, Electrical Contacts, 2nd ed. 2014, chapter 6 (intermittence of contacts that fret).
"""

from __future__ import annotations

from dataclasses import replace

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.numbered import COUNTS, further, numbered
from fsm_calib.world2d.effects.places import overlap
from fsm_calib.world2d.slots import STEP, TARGET, TIME

MOST = 8  # faults of one drive
OF_EACH = 2  # numbers of a fault: begin and length


@njit(error_model="numpy")
def fail(P, o, S, m, W):
    """Weaken the targets for the part of the step that the faults cover."""
    part = 0.0
    for first in range(o + 2, o + 2 + MOST * OF_EACH, OF_EACH):
        part += overlap(S[TIME], S[TIME] + W[STEP], P[first], P[first] + P[first + 1])
    part = min(part, 1.0)
    W[TARGET] *= 1.0 - part * P[o]
    W[TARGET + 1] *= 1.0 - part * P[o + 1]


LOSSES = (
    Parameter(
        "loss_left",
        "f_l",
        "1",
        0.0,
        -0.5,
        1.0,
        0.3,
        "any",
        mirror="swap:loss_right",
        per_recording=True,
        natural_end=True,
    ),
    Parameter(
        "loss_right",
        "f_r",
        "1",
        0.0,
        -0.5,
        1.0,
        0.0,
        "any",
        mirror="swap:loss_left",
        per_recording=True,
        natural_end=True,
    ),
)
ONE = (
    Parameter("start", "t0", "s", 0.0, 0.0, 1e5, 8.2, "any", strength=False, per_recording=True, step=0.01),
    Parameter(
        "duration", "dt", "s", 5.0, 0.1, 1e5, 6.0, "any", strength=False, per_recording=True, step=0.01
    ),
)
"""When one fault came and how long it lasted, in the order of the hook."""
AGAIN = tuple(replace(p, null=0.0, low=0.0) for p in ONE)
"""The same of a further one: none lasts until a fit says so."""


def several(closure: Closure, count: int) -> Closure:
    """Return a closure of the same motor that fails so many times.

    Of one motor alone: what both lose at once for a moment is what sticks for a moment, at a caster or a wheel.
    """
    later = [numbered(p.name, time) for time in range(2, count + 1) for p in ONE]
    return Closure(
        f"{closure.name}, {COUNTS[count]} times",
        (*closure.frees, *later),
        f"{closure.summary}, {COUNTS[count]} times in one drive",
        sentence=f"{COUNTS[count].capitalize()} times, first at {{start}} for {{duration}}, the motors lose "
        "{loss_left} (left), {loss_right} (right).",
        source="Slade, Electrical Contacts, 2nd ed. 2014, chapter 6",
    )


ONCE = (
    Closure("left motor", ("loss_left", "start", "duration"), "the left motor alone"),
    Closure("right motor", ("loss_right", "start", "duration"), "the right motor alone"),
    Closure("both motors", ("loss_left", "loss_right", "start", "duration"), "each by its own share"),
)


def alike(closure: Closure) -> Closure:
    """Return a closure of the same motor that loses the same in every drive."""
    losses = tuple(name for name in closure.frees if name.startswith("loss"))
    said = " and ".join(f"the {name.removeprefix('loss_')} motor loses {{{name}}}" for name in losses)
    return Closure(
        f"{closure.name} alike",
        closure.frees,
        f"{closure.summary}, the same in every drive",
        sentence=f"In every drive, for a while, {said}.",
        alike=losses,
    )


EFFECT = Effect(
    name="motor_fault",
    family="drift",
    summary="a motor weakens for a time, or now and then",
    equation="T_i = K_i u_i (1 - loss_i) from start for duration",
    parameters=(*LOSSES, *ONE, *further(AGAIN, MOST)),
    hooks={"step": fail},
    channels=("forward", "turn"),
    regimes=("span", "one_wheel"),
    separates="begins and ends at once; warming up and sagging are gradual",
    rivals=("motor_warmup", "battery_sag", "external_push"),
    manoeuvre="repeat the drive: a fault does not come back at the same time",
    sentence="From {start} for {duration} the motors lose {loss_left} (left), {loss_right} (right).",
    input="command",
    source="Roumeliotis, Sukhatme & Bekey, ICRA 1998",
    closures=(
        *ONCE,
        *map(alike, ONCE[:2]),
        *(several(once, count) for once in ONCE[:2] for count in range(2, MOST + 1)),
    ),
    when="span",
    acts_on="motor",
    order=54,
)
