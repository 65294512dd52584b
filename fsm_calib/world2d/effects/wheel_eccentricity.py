r"""A wheel sits off its centre: its rolling radius changes with its angle.

    R_i(phi) = R_i (1 + e_i cos(n pace phi_i + phase_i))         n = 1 off its centre, n = 2 oval
    F_i = lift N_i e_i n sin(n pace phi_i + phase_i)             at the rim

R [m] mean radius, phi [rad] angle of the wheel since the start of the recording, e [1] eccentricity over radius,
phase [rad] at the start; pace [1] = stated radius over the true one: a wheel whose angle nobody measures turns by its
way over a radius that a sheet states to 3 %, and a minute's drive is 400 rad. No-load rim speed grows with R, the
slope of the force falls with R^2, and a turn of the wheel takes it as far as R says. N [N] load of the wheel: where
it rises it lifts the robot, which takes a force of N / R dR/dphi at the rim, given back where it sinks: at 1 % of the
radius as much as 1 % of the load, which slows weak motors far more than the way changes. lift [1] is how much of that
is seen: 0 where a controller holds the speed, 1 by the nominal mass; a wheel that is told to rest is held by its
gears (assumed). Source: rolling of an eccentric disc and virtual work; Borenstein & Feng, IEEE Trans. Robotics and
Automation 12 (1996) 869 (unequal radii).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.dynamics import WHEEL_RADIUS
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import COMMAND, DRIVE, LOAD, RADIUS, ROLL, TARGET

PACES = (1.0, 0.99, 1.01, 0.98, 1.02, 0.97, 1.03)
"""As near as the width of the likelihood after a minute: two thirds of the evidence are left 1 % off."""


@njit(error_model="numpy")
def wobble(P, o, S, m, W):
    """Scale target and slope of each wheel by its momentary radius, and let it lift its load."""
    for side in range(2):
        angle = P[o + 4] * P[o + 5] * W[ROLL + side] + P[o + 2 + side]
        scale = 1.0 + P[o + side] * math.cos(angle)
        W[TARGET + side] *= scale
        W[DRIVE + side] /= scale * scale
        W[RADIUS + side] = P[WHEEL_RADIUS + side] * scale
        if P[o + 6] != 0.0 and W[COMMAND + side] != 0.0:
            force = P[o + 6] * W[LOAD + side] * P[o + side] * P[o + 4] * math.sin(angle)
            W[TARGET + side] += force / W[DRIVE + side]


EFFECT = Effect(
    name="wheel_eccentricity",
    family="wheel",
    summary="a wheel sits off its centre",
    equation="R_i(phi) = R_i (1 + e_i cos(phi_i + phase_i))",
    parameters=(
        Parameter(
            "left", "e_l", "1", 0.0, 0.0, 0.3, 0.04, "0.5 to 2 % new", mirror="swap:right", starts=(0.03,)
        ),
        Parameter(
            "right", "e_r", "1", 0.0, 0.0, 0.3, 0.0, "0.5 to 2 % new", mirror="swap:left", starts=(0.03,)
        ),
        Parameter(
            "phase_left",
            "phi_l",
            "rad",
            0.0,
            -20.0,
            20.0,
            1.0,
            "any",
            strength=False,
            per_recording=True,
            mirror="swap:phase_right",
            starts=(0.0, 2.1, 4.2),
            step=1e-3,
            cyclic=True,
        ),
        Parameter(
            "phase_right",
            "phi_r",
            "rad",
            0.0,
            -20.0,
            20.0,
            0.0,
            "any",
            strength=False,
            per_recording=True,
            mirror="swap:phase_left",
            starts=(0.0, 2.1, 4.2),
            step=1e-3,
            cyclic=True,
        ),
        Parameter(
            "lobes",
            "n",
            "1",
            1.0,
            1.0,
            2.0,
            1.0,
            "1 off its centre, 2 oval",
            strength=False,
            fitted=False,
        ),
        Parameter(
            "pace",
            "q",
            "1",
            1.0,
            0.9,
            1.1,
            1.0,
            "sheets err by 1 to 3 %",
            strength=False,
            fitted=False,
            without_encoders=True,
            starts=PACES,
        ),
        Parameter(
            "lift",
            "c_N",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "1 where nothing holds the speed",
            strength=False,
            fitted=False,
            starts=(0.0, 1.0),
        ),
    ),
    hooks={"step": wobble},
    reads=("wheel_angle",),
    channels=("forward", "turn"),
    regimes=("wheel_phase", "one_wheel"),
    separates="repeats every turn of the wheel (0.2 m), whatever the place",
    rivals=("misplaced_marker", "rough_floor_patch"),
    manoeuvre="a long straight at steady speed",
    sentence="A wheel sits off its centre by {left} (left) and {right} (right) of its radius.",
    source="Borenstein & Feng 1996",
    closures=(
        Closure("left wheel", ("left", "phase_left"), "the left wheel alone"),
        Closure("right wheel", ("right", "phase_right"), "the right wheel alone"),
        Closure(
            "both wheels",
            ("left", "right", "phase_left", "phase_right"),
            "each by its own share",
            fixes={"pace": 1.0},
        ),
        Closure(
            "left wheel oval",
            ("left", "phase_left"),
            "the left wheel is longer than wide",
            fixes={"lobes": 2.0},
            sentence="The left wheel is oval: its radius changes by {left} of itself twice a turn.",
        ),
        Closure(
            "right wheel oval",
            ("right", "phase_right"),
            "the right wheel is longer than wide",
            fixes={"lobes": 2.0},
            sentence="The right wheel is oval: its radius changes by {right} of itself twice a turn.",
        ),
        Closure(
            "both wheels oval",
            ("left", "right", "phase_left", "phase_right"),
            "both are longer than wide, each by its own share",
            fixes={"lobes": 2.0},
            extends=("left wheel oval", "right wheel oval"),
            sentence="Both wheels are oval: their radii change by {left} (left) and {right} (right) twice a turn.",
        ),
    ),
    order=58,
)
