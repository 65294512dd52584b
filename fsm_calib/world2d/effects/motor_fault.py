r"""For a time one motor (or both) loses part of its strength.

    T_i = K_i u_i (1 - loss_i)      start <= t < start + duration

T [m/s] no-load rim speed of wheel i, K [m/s] gain, u [1] command, loss [1], start and duration [s] on the
recording's clock. A loose plug, a stuck gear, a driver in thermal shutdown. Source: Roumeliotis, Sukhatme &
Bekey, ICRA 1998 (the actuator faults of a mobile robot).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import overlap
from fsm_calib.world2d.slots import STEP, TARGET, TIME


@njit(error_model="numpy")
def fail(P, o, S, m, W):
    """Weaken the targets for the part of the step that the fault covers."""
    part = overlap(S[TIME], S[TIME] + W[STEP], P[o + 2], P[o + 2] + P[o + 3])
    W[TARGET] *= 1.0 - part * P[o]
    W[TARGET + 1] *= 1.0 - part * P[o + 1]


EFFECT = Effect(
    name="motor_fault",
    family="drift",
    summary="a motor weakens for a time",
    equation="T_i = K_i u_i (1 - loss_i) from start for duration",
    parameters=(
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
        Parameter(
            "start", "t0", "s", 0.0, 0.0, 1e5, 8.2, "any", strength=False, per_recording=True, step=0.01
        ),
        Parameter(
            "duration", "dt", "s", 5.0, 0.1, 1e5, 6.0, "any", strength=False, per_recording=True, step=0.01
        ),
    ),
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
        Closure("left motor", ("loss_left", "start", "duration"), "the left motor alone"),
        Closure("right motor", ("loss_right", "start", "duration"), "the right motor alone"),
        Closure("both motors", ("loss_left", "loss_right", "start", "duration"), "each by its own share"),
    ),
    when="span",
    acts_on="motor",
    order=54,
)
