r"""The pose sensor's clock runs fast or slow against the robot's, at one rate or at one that changes.

    t_stamp = (1 + drift) t_robot + change / 2 t_robot^2         both from the recording's zero

drift [1]: seconds that the sensor's clock gains in each second, at first; change [1/s]: of that rate, while a crystal
warms up or a time service pulls it back. Source: quartz clocks drift 20 to 200 ppm, software stamps up to 1e-3; Mills,
Computer Network Time Synchronization, 2nd ed. 2010, section 12; a clock's error is a parabola in time: Riley,
Handbook of Frequency Stability Analysis, NIST SP 1065 (2008), section 3.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter

LEAST = 0.01  # squared rate below which no clock falls: it would stand still


def drift(p: FloatArray, t: FloatArray) -> FloatArray:
    """Return the robot's time [s] of stamps t [s]: the root of the parabola that runs through zero."""
    rate = 1.0 + p[0]
    root = np.sqrt(np.maximum(rate * rate + 2.0 * p[1] * t, LEAST))
    return np.asarray(2.0 * t / (rate + root), dtype=float)


EFFECT = Effect(
    name="clock_drift",
    family="timing",
    summary="the pose clock runs fast or slow",
    equation="t_stamp = (1 + drift) t_robot + change / 2 t_robot^2",
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
        Parameter("change", "c", "1/s", 0.0, -1e-3, 1e-3, 5e-5, "1e-6 to 1e-4: a crystal that warms up"),
    ),
    hooks={"clock": drift},
    channels=("sensor", "forward", "turn"),
    regimes=("late", "transient"),
    separates="a lag that grows from zero through the recording; a delay is the same throughout",
    rivals=("observation_delay", "command_delay"),
    manoeuvre="a long recording: compare its first and last minute",
    sentence="The pose clock gains {drift} seconds a second.",
    source="Mills 2010, section 12",
    closures=(
        Closure("one rate", ("drift",), "a clock that is off by as much all the time"),
        Closure(
            "changing rate",
            ("drift", "change"),
            "its crystal warms up, or a time service pulls it back",
            sentence="The pose clock gains {drift} seconds a second at first, and that changes by {change} a second.",
            source="Riley, NIST SP 1065 (2008), section 3",
        ),
    ),
    order=10,
)
