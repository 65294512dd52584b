r"""Poses are stamped later than they were, or lag behind because the tracker smooths them.

    pose(t) = h(s(t - delay + smoothing)),        smoothing ds/dt = x - s
    heading:  (smoothing - apart) ds/dt = theta - s,     smoothing > apart
              theta(t - delay + apart),                  where no filter is left

x the robot's pose, s what a filter of first order makes of it; delay [s]: how late steady motion is reported, by
exposure, transport, processing and the filter together; smoothing [s]: the filter's time constant, 0 for none; apart
[s]: how much less late headings are than places, as a gyro is beside a camera: behind a filter its time constant is
smaller by so much, else they are stamped earlier. A filter that looks ahead (one that runs afterwards) is smoothing
without delay. Wheel encoders are not concerned. Sources:
cameras on Wi-Fi robots, 20 to 120 ms (assumed); temporal calibration after Rehder et al., ICRA 2016 (Kalibr);
exponential smoothing of tracked poses: LaViola, Double Exponential Smoothing: an Alternative to Kalman Filter-based
Predictive Tracking, EGVE 2003; heading and place from sensors of their own: Brown & Hwang, Introduction to Random
Signals and Applied Kalman Filtering, complementary filters.
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
    """Return poses (n, 3) behind filters of first order that begin at rest, straight between the times t [s]."""
    smoothing, apart = p[1], p[2]
    places = np.ascontiguousarray(poses if apart == 0.0 else poses[:, :2])
    seen = _low_pass(t, places, smoothing) if smoothing > 0.0 else places
    if apart == 0.0:
        return seen
    return np.column_stack([seen, _heading(t, poses[:, 2], smoothing, apart)])


def _heading(t: FloatArray, heading: FloatArray, smoothing: float, apart: float) -> FloatArray:
    """Return headings (n,) that are less late than places by `apart`, where those have a filter by a faster one."""
    own = smoothing - apart
    if smoothing == 0.0 or own < 0.0:
        return np.interp(t + (apart - smoothing), t, heading)
    return _low_pass(t, np.ascontiguousarray(heading[:, None]), own)[:, 0] if own > 0.0 else heading


@njit(cache=True)
def _low_pass(t, x, tau):  # type: ignore[no-untyped-def]
    """Return the exact answer of tau ds/dt = x - s to straight lines between the rows of `x`."""
    s = x.copy()
    for k in range(1, len(x)):
        step = (t[k] - t[k - 1]) / tau
        fades = np.exp(-step)
        mean = (1.0 - fades) / step
        for i in range(x.shape[1]):
            s[k, i] = fades * s[k - 1, i] + (mean - fades) * x[k - 1, i] + (1.0 - mean) * x[k, i]
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
        Parameter(
            "apart",
            "d_h",
            "s",
            0.0,
            -0.3,
            0.3,
            0.03,
            "a gyro answers within 5 ms, places as late as their filter",
            starts=(0.03, -0.03, 0.1),
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
        Closure(
            "places and headings apart",
            ("delay", "apart"),
            "headings by less or by more than places",
            sentence="Places are stamped {delay} late, headings {apart} less.",
            source="Brown & Hwang, complementary filters",
            has_twin=may_be_built_so,
            extends=("constant",),
        ),
        Closure(
            "smoothed apart",
            ("delay", "smoothing", "apart"),
            "places pass a slower filter than headings",
            sentence="Places are {delay} late, of which smoothing takes {smoothing}; headings {apart} less.",
            source="Brown & Hwang, complementary filters",
            has_twin=may_be_built_so,
            extends=("constant", "smoothed"),
        ),
    ),
    order=20,
)
