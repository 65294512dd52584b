r"""The pose sensor's clock runs fast or slow against the robot's.

    t_stamp = (1 + drift) t_robot         both from the recording's zero

drift [1]: seconds that the sensor's clock gains in each second. Source: quartz clocks drift 20 to 200 ppm,
software stamps up to 1e-3; Mills, Computer Network Time Synchronization, 2nd ed. 2010, section 12.
"""

from __future__ import annotations

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Effect, Parameter


def drift(p: FloatArray, t: FloatArray) -> FloatArray:
    """Return the robot's time [s] of stamps t [s]."""
    return t / (1.0 + p[0])


EFFECT = Effect(
    name="clock_drift",
    family="timing",
    summary="the pose clock runs fast or slow",
    equation="t_stamp = (1 + drift) t_robot",
    parameters=(
        Parameter(
            "drift",
            "epsilon",
            "1",
            0.0,
            -0.05,
            0.05,
            0.003,
            "1e-5 to 1e-3, more for software",
            starts=(0.002, -0.002, 0.01, -0.01, 0.025, -0.025),
        ),
    ),
    hooks={"clock": drift},
    channels=("sensor", "forward", "turn"),
    regimes=("late", "transient"),
    separates="a lag that grows from zero through the recording; a delay is the same throughout",
    rivals=("observation_delay", "command_delay"),
    manoeuvre="a long recording: compare its first and last minute",
    sentence="The pose clock gains {drift} seconds a second.",
    source="Mills 2010, section 12",
    order=10,
)
