r"""Poses are stamped later than they were, or lag behind because the tracker smooths them.

    pose(t) = h(s(t - delay + smoothing)),        smoothing ds/dt = x - s

x the robot's pose, s what a filter of first order makes of it; delay [s]: how late steady motion is reported, by
exposure, transport, processing and the filter together; smoothing [s]: the filter's time constant, 0 for none. A filter
that looks ahead (one that runs afterwards) is smoothing without delay. Wheel encoders are not concerned. Sources:
cameras on Wi-Fi robots, 20 to 120 ms (assumed); temporal calibration after Rehder et al., ICRA 2016 (Kalibr);
exponential smoothing of tracked poses: LaViola, Double Exponential Smoothing: an Alternative to Kalman Filter-based
Predictive Tracking, EGVE 2003.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.lateness import LEAST_DELAY, may_be_built_so


def lag(p: FloatArray, t: FloatArray) -> FloatArray:
    """Return the robot's time [s] of stamps t [s]."""
    return t - p[0] + p[1]


def filtered(p: FloatArray, t: FloatArray, poses: FloatArray) -> FloatArray:
    """Return poses (n, 3) behind a filter of first order that begins at rest, straight between the times t [s]."""
    return _low_pass(t, np.ascontiguousarray(poses), p[1]) if p[1] > 0.0 else poses


@njit(cache=True)
def _low_pass(t, x, tau):  # type: ignore[no-untyped-def]
    """Return the exact answer of tau ds/dt = x - s to straight lines between the rows of `x`."""
    s = x.copy()
    for k in range(1, len(x)):
        step = (t[k] - t[k - 1]) / tau
        fades = np.exp(-step)
        mean = (1.0 - fades) / step
        s[k] = fades * s[k - 1] + (mean - fades) * x[k - 1] + (1.0 - mean) * x[k]
    return s


EFFECT = Effect(
    name="observation_delay",
    family="timing",
    summary="poses are stamped late",
    equation="pose(t) = h(s(t - delay + smoothing)), smoothing ds/dt = x - s",
    parameters=(
        Parameter(
            "delay",
            "d_c",
            "s",
            0.0,
            -0.1,
            0.6,
            0.12,
            "20 to 120 ms, with a filter 200 ms",
            starts=(0.05, 0.12, 0.2),
            least=LEAST_DELAY,
        ),
        Parameter(
            "smoothing",
            "tau_c",
            "s",
            0.0,
            0.0,
            0.6,
            0.06,
            "filters of trackers: 20 to 200 ms",
            starts=(0.05, 0.15),
            least=LEAST_DELAY,
        ),
    ),
    hooks={"clock": lag, "smooth": filtered},
    channels=("sensor", "forward", "turn"),
    regimes=("transient",),
    separates="encoders: early against the poses when only the camera is late",
    rivals=("command_delay", "clock_drift", "gear_backlash"),
    manoeuvre="fast steps and slaloms with encoders, or a visible signal at the moment of a command",
    sentence="Poses are stamped {delay:late|early}.",
    source="Rehder et al., ICRA 2016",
    closures=(
        Closure("constant", ("delay",), "every pose by as much", has_twin=may_be_built_so),
        Closure(
            "smoothed",
            ("delay", "smoothing"),
            "a filter behind the sensor takes part of it",
            sentence="Poses are {delay} late, of which smoothing takes {smoothing}.",
            source="LaViola, EGVE 2003",
            has_twin=may_be_built_so,
        ),
    ),
    order=20,
)
