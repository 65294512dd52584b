r"""Somebody or something pushes the robot, at a blow or for as long as a hand leans on it; once, or several times.

    F = (impulse_x, impulse_y) / duration,  M = impulse_turn / duration      start <= t < start + duration

F [N] at the axle centre, in `world` (along 0) or ahead and to the left of the robot (along 1), M [N m], impulses
[N s] and [N m s], start and duration [s]; each push of a drive has its own. Or it comes alike in every drive, each time
at a moment of its own: the same hand, the same curb. Source: momentum balance.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.numbered import COUNTS, further, numbered
from fsm_calib.world2d.effects.places import overlap
from fsm_calib.world2d.forces import add_force
from fsm_calib.world2d.slots import COS, SIN, STEP, TIME

MOST = 5  # pushes of one drive
OF_EACH = 5  # numbers of a push
ALONG = MOST * OF_EACH  # place of what tells along what the forces point


@njit(error_model="numpy")
def push(P, o, S, m, W):
    """Add each push for the part of the step that it covers."""
    for first in range(o, o + MOST * OF_EACH, OF_EACH):
        start, duration = P[first + 3], P[first + 4]
        part = overlap(S[TIME], S[TIME] + W[STEP], start, start + duration) / duration
        if part > 0.0:
            fx, fy = part * P[first], part * P[first + 1]
            turn = part * P[first + 2]
            if P[o + ALONG] > 0.5:
                add_force(W, fx, fy, turn)
            else:
                add_force(W, W[COS] * fx + W[SIN] * fy, W[COS] * fy - W[SIN] * fx, turn)


ONE = (
    Parameter("impulse_x", "J_x", "N s", 0.0, -40.0, 40.0, 0.4, "a nudge: 0.2 to 1 N s", per_recording=True),
    Parameter(
        "impulse_y", "J_y", "N s", 0.0, -40.0, 40.0, 0.2, "a nudge", per_recording=True, mirror="negate"
    ),
    Parameter(
        "impulse_turn", "J_w", "N m s", 0.0, -4.0, 4.0, 0.02, "a nudge", per_recording=True, mirror="negate"
    ),
    Parameter("start", "t0", "s", 0.0, -1.0, 1e5, 7.15, "any", strength=False, per_recording=True, step=5e-3),
    Parameter(
        "duration",
        "dt",
        "s",
        0.2,
        0.02,
        8.0,
        0.2,
        "0.1 to 0.4 s; a hand stays for seconds",
        strength=False,
        per_recording=True,
        step=5e-3,
    ),
)
"""The numbers of one push, in the order of the hook."""


def several(count: int) -> Closure:
    """Return the closure of so many pushes in one drive."""
    names = [[numbered(p.name, time) for p in ONE] for time in range(1, count + 1)]
    times = [f"at {{{numbered('start', time)}}}" for time in range(1, count + 1)]
    said = f"{', '.join(times[:-1])} and {times[-1]}"
    return Closure(
        f"{COUNTS[count]} pushes",
        tuple(name for one in names for name in one),
        f"{COUNTS[count]} of them in one drive",
        sentence=f"Something pushed the robot {said}, the first time by ({{impulse_x}}, {{impulse_y}}).",
    )


ALONG_WHAT = {"room": 0.0, "robot": 1.0}
"""What the force of a push points along that comes alike in every drive, with the value of `along`."""


def alike(what: str, lasts: bool) -> Closure:
    """Return the closure of a push that comes alike in every drive, along the room or the robot."""
    names = tuple(p.name for p in ONE if lasts or p.name != "duration")
    kind, of_each = ("held ", "for {duration} ") if lasts else ("", "")
    return Closure(
        f"{kind}alike, along the {what}",
        names,
        f"the same {'force that lasts' if lasts else 'push'} in every drive, along the {what}",
        sentence=f"In every drive something pushed the robot {of_each}by ({{impulse_x}}, {{impulse_y}}) along the "
        f"{what}.",
        fixes={"along": ALONG_WHAT[what]},
        alike=tuple(name for name in names if name != "start"),
    )


EFFECT = Effect(
    name="external_push",
    family="event",
    summary="a push from outside",
    equation="F = impulse / duration from start",
    parameters=(
        *ONE,
        *further(ONE, MOST),
        Parameter(
            "along", "a", "1", 0.0, 0.0, 1.0, 0.0, "0: the room, 1: the robot", fitted=False, strength=False
        ),
    ),
    hooks={"step": push},
    reads=("heading",),
    channels=("forward", "lateral", "turn"),
    regimes=("once", "heading"),
    separates="once, within a fraction of a second, whatever the command",
    rivals=("motor_fault", "low_friction_patch", "misplaced_marker"),
    manoeuvre="repeat the drive: a push does not come back",
    sentence="At {start} something pushed the robot by ({impulse_x}, {impulse_y}).",
    source="momentum balance",
    closures=(
        Closure("push", ("impulse_x", "impulse_y", "impulse_turn", "start"), "impulse and moment at once"),
        Closure(
            "held",
            ("impulse_x", "impulse_y", "impulse_turn", "start", "duration"),
            "a force that lasts",
            sentence="From {start} something pushed the robot for {duration} by ({impulse_x}, {impulse_y}) in all.",
        ),
        *(several(count) for count in range(2, MOST + 1)),
        *(alike(where, lasts) for where in ALONG_WHAT for lasts in (False, True)),
    ),
    when="moment",
    acts_on="push",
    order=86,
)
