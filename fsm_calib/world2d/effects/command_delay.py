r"""Commands act later than they are logged.

    u_effective(t) = u(t - delay)

delay [s]: radio, queue and driver between the logged command and the motors' voltage. Sources:
duckietown-world's `ApplyDelay` uses 0.15 s; robots on Wi-Fi report 20 to 150 ms.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.lateness import LEAST_DELAY, may_be_built_so


@njit(error_model="numpy")
def late(P, o):
    """Return the delay [s]."""
    return P[o]


EFFECT = Effect(
    name="command_delay",
    family="timing",
    summary="commands act later than logged",
    equation="u_eff(t) = u(t - delay)",
    parameters=(
        Parameter(
            "delay",
            "d",
            "s",
            0.0,
            0.0,
            0.6,
            0.08,
            "duckietown-world ApplyDelay: 0.15 s",
            starts=(0.05, 0.12, 0.2),
            least=LEAST_DELAY,
        ),
    ),
    hooks={"delay": late},
    channels=("forward", "turn"),
    regimes=("transient",),
    separates="encoders: late with the pose when commands are late, early when only the camera is late",
    rivals=("observation_delay", "clock_drift", "gear_backlash", "motor_asymmetric_lag"),
    manoeuvre="fast steps and slaloms with encoders, or a visible signal at the moment of a command",
    sentence="The wheels answer {delay} after the command.",
    input="command",
    source="duckietown-world, pwm_dynamics.py and ApplyDelay",
    closures=(Closure("full", ("delay",), "every command by as much", has_twin=may_be_built_so),),
)
