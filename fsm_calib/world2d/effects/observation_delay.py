r"""Poses are stamped later than they were.

    pose(t) = h(state(t - delay))

delay [s]: exposure, transport and processing before the stamp. Wheel encoders are not concerned. Sources:
cameras on Wi-Fi robots, 20 to 120 ms (assumed); temporal calibration after Rehder et al., ICRA 2016 (Kalibr).
"""

from __future__ import annotations

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import LEAST_DELAY, Effect, Parameter


def lag(p: FloatArray, t: FloatArray) -> FloatArray:
    """Return the robot's time [s] of stamps t [s]."""
    return t - p[0]


EFFECT = Effect(
    name="observation_delay",
    family="timing",
    summary="poses are stamped late",
    equation="pose(t) = h(state(t - delay))",
    parameters=(
        Parameter(
            "delay",
            "d_c",
            "s",
            0.0,
            -0.1,
            0.6,
            0.06,
            "20 to 120 ms",
            starts=(0.05, 0.12, 0.2),
            least=LEAST_DELAY,
        ),
    ),
    hooks={"clock": lag},
    channels=("sensor", "forward", "turn"),
    regimes=("transient",),
    separates="encoders: early against the poses when only the camera is late",
    rivals=("command_delay", "clock_drift", "gear_backlash"),
    manoeuvre="fast steps and slaloms with encoders, or a visible signal at the moment of a command",
    sentence="Poses are stamped {delay} late.",
    source="Rehder et al., ICRA 2016",
    order=20,
)
