"""Wheel rates of which nobody said what time they stand for: samples at their stamp, or means since the row before?

A driver that divides the difference of two encoder counts by the time between them knows the rate only afterwards. Read
as samples, such rates come half an interval late, and the poses seem that much *early*. No sensor is early, so poses
that the wheels tell best half an interval earlier mean that these rates are such means. Poses that seem late may well
be late (exposure, transport), so that is never put down to the wheels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.inputs import driving_rates, with_driving_rates
from fsm_calib.diagnosis.pose_moves import log_likelihood_of, moves_between
from fsm_calib.recording.channels import WheelPair
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import travel
from fsm_calib.types import FloatArray

SHORTEST_STEP = 0.1  # s between the poses that are compared: over less, most trackers tell noise
CLEARLY_LIKELIER = 10.0  # log-likelihood units, as `identify` asks of another reading of the wheels


def with_stamps(
    recordings: Sequence[Recording], others: Sequence[Recording] = ()
) -> tuple[list[Recording], list[Recording], str]:
    """Return both lists with the rates' meaning set where none was stated, and a sentence where it is not `middle`.

    recordings, others : of one robot, whose driver stamps alike; all have poses, only `recordings` decide.
    """
    asked = [r for r in recordings if _unstated(r) is not None]
    if not asked:
        return list(recordings), list(others), ""
    gain = sum(_gain(r) for r in asked)
    if gain < CLEARLY_LIKELIER:
        return list(recordings), list(others), ""
    pair = _unstated(asked[0])
    step = float(np.median(np.diff(pair.time))) if pair is not None else 0.0
    sentence = (
        f"the wheels' rates are read as means since the row before, {0.5 * step:.3f} s earlier than samples: so the "
        "poses follow them best; a manifest may state it (stamp: end, middle or start)"
    )
    return [_means(r) for r in recordings], [_means(r) for r in others], sentence


def _unstated(recording: Recording) -> WheelPair | None:
    """Return the rates that drive the simulation of this recording, where their meaning is open."""
    pair = driving_rates(recording)
    return pair if pair is not None and pair.duration is None and pair.stamp is None else None


def _means(recording: Recording) -> Recording:
    pair = _unstated(recording)
    return recording if pair is None else with_driving_rates(recording, replace(pair, stamp="end"))


def _gain(recording: Recording) -> float:
    """Return by how much [log-likelihood] the poses follow means since the row before better than samples.

    The shift alone is compared, and a whole interval must be worse than half of one: poses that are earlier still run
    on another clock.
    """
    pair, pose = _unstated(recording), recording.pose
    if pair is None or pose is None or len(pair) < 2:
        return 0.0
    step = float(np.median(np.diff(pair.time)))
    moves = moves_between(pose, max(step, SHORTEST_STEP))
    if moves is None:
        return 0.0
    sample, half, whole = (_log_likelihood(pair, *moves, shift) for shift in (0.0, 0.5 * step, step))
    return half - max(sample, whole)


def _log_likelihood(pair: WheelPair, steps: FloatArray, measured: FloatArray, shift: float) -> float:
    """Return how well the travel of the wheels, `shift` [s] later by the poses' clock, tells what was measured, each
    column by a linear fit with Student residuals of the likeliest scale.
    """
    time, *sides = travel(pair)
    ways = [np.diff(np.interp(steps + shift, time, side), axis=1)[:, 0] for side in sides]
    return log_likelihood_of(measured, np.column_stack(ways))
