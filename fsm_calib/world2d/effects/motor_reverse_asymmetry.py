r"""A motor is weaker (or stronger) backwards than forwards.

    u_effective = u                               u >= 0
    u_effective = u (1 - loss -+ difference / 2)  u < 0, left -, right +

loss [1]: mean over both motors; difference [1]: what the left motor loses more than the right one.
Brushed motors with advanced brushes run 2 to 15 % slower one way; the two motors of a robot are
mounted as mirror images. Source: Hughes & Drury, Electric Motors and Drives, 5th ed., section 3.2 (brush
shift).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter


@njit(error_model="numpy")
def weaken(P, o, u, side):
    """Return the command as the motor turns it into speed."""
    if u >= 0.0:
        return u
    return u * (1.0 - P[o] + (0.5 - side) * -P[o + 1])


EFFECT = Effect(
    name="motor_reverse_asymmetry",
    family="command map",
    summary="weaker or stronger backwards",
    equation="u_eff = u (1 - loss -+ difference/2) for u < 0",
    parameters=(
        Parameter("loss", "rho", "1", 0.0, -0.5, 0.7, 0.08, "brush shift: 2 to 15 %"),
        Parameter(
            "difference",
            "delta_rho",
            "1",
            0.0,
            -0.6,
            0.6,
            0.04,
            "left loses more where positive",
            mirror="negate",
        ),
    ),
    hooks={"shape": weaken},
    channels=("forward", "turn"),
    regimes=("reverse",),
    separates="changes with the sign of each wheel's command only, at all speeds and places alike",
    rivals=("coulomb_friction", "carpet_nap", "floor_tilt", "motor_gain_curve"),
    manoeuvre="the same straight forwards and backwards, and spins both ways",
    sentence="Backwards the motors give {loss} less speed than forwards.",
    source="Hughes & Drury, Electric Motors and Drives, 5th ed., section 3.2",
    closures=(
        Closure("both alike", ("loss",), "the same loss on both sides"),
        Closure("each its own", ("loss", "difference"), "more on one side than on the other"),
    ),
    input="command",
    order=45,
)
