"""Poses that somebody interpolated: a table on a finer grid than its tracker, straight between its measurements.

Rows between two measurements lie on their chord to the last digit, in place and in heading; a measured pose with noise
never does. Left in, they look like measurements whose errors hang together, and a delay explains these best. So they
are dropped. Where a measurement lies between two rows it is where the two lines meet:

    t = t_i - sum_c ds_c d_c / sum_c ds_c^2,     each of x, y, theta in its last digits

d the second line less the first at t_i, ds [1/s] the difference of their slopes. Poses of few digits, of a robot that
drives straight without noise, and splines stay.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.types import FloatArray

MOST_DIGITS = 9  # after the point
LEAST_BETWEEN = 0.4  # share of the rows that lie on a chord
CLEARLY_BENT = 10.0  # last digits: the usual bend at a measurement
LONGEST = 0.6  # s between two measurements
MOST_LONGER = (
    0.1  # share of the measurements that are farther apart: a robot that drives straight without noise
)
FEWEST = 20  # measurements


def without_interpolated_rows(recording: Recording) -> Recording:
    """Return the recording with the poses that were measured alone, and a finding where others were dropped."""
    pose = recording.pose
    if pose is None or len(pose) < FEWEST or not np.isfinite([pose.x, pose.y, pose.theta]).all():
        return recording
    knots = knots_of(pose)
    if knots is None:
        return recording
    rate = 1.0 / float(np.median(np.diff(knots.time)))
    sentence = (
        f"{len(pose)} rows lie straight between about {rate:.1f} measurements a second: interpolated, "
        f"the {len(knots)} measurements are kept"
    )
    told = Finding("pose", "interpolated", sentence, "dropped", len(pose) - len(knots), float(pose.time[0]))
    return dataclasses.replace(recording, pose=knots, checks=(*recording.checks, told))


def knots_of(pose: PoseTrack) -> PoseTrack | None:
    """Return the measurements between which the rows of `pose` were interpolated; None where they were not."""
    values = np.column_stack([pose.x, pose.y, np.unwrap(pose.theta)])
    digit = np.array([_last_digit(series) for series in (pose.x, pose.y, pose.theta)])
    time = pose.time
    share = ((time[1:-1] - time[:-2]) / (time[2:] - time[:-2]))[:, None]
    bend = np.abs(values[1:-1] - (1.0 - share) * values[:-2] - share * values[2:]) / digit
    bent = np.max(bend, axis=1) > 1.01  # three rounded numbers are off their chord by one last digit at most
    moving = np.any(np.abs(values[2:] - values[:-2]) > CLEARLY_BENT * digit, axis=1)
    if np.sum(~bent & moving) < LEAST_BETWEEN * len(bent) or bent.sum() < FEWEST:
        return None
    starts = 1 + np.flatnonzero(bent & ~np.append(False, bent[:-1]))
    ends = 1 + np.flatnonzero(bent & ~np.append(bent[1:], False))
    apart = np.mean(np.diff(time[starts]) > LONGEST)
    if (
        np.median(np.max(bend[bent], axis=1)) < CLEARLY_BENT
        or np.any(ends - starts > 1)
        or apart > MOST_LONGER
    ):
        return None
    rows = [
        np.append(time[i], values[i]) if i == k else _crossing(time, values, digit, i, k)
        for i, k in zip(map(int, starts), map(int, ends), strict=True)
    ]
    first, last = np.append(time[0], values[0]), np.append(time[-1], values[-1])
    return PoseTrack(*np.array([first, *rows, last]).T)


def _crossing(time: FloatArray, values: FloatArray, digit: FloatArray, i: int, k: int) -> FloatArray:
    """Return time and pose (4,) where the line that ends at row i meets the line that begins at row k."""
    before = (values[i] - values[i - 1]) / (time[i] - time[i - 1])
    after = (values[k + 1] - values[k]) / (time[k + 1] - time[k])
    slope = (after - before) / digit
    away = (values[k] + after * (time[i] - time[k]) - values[i]) / digit
    late = float(np.clip(-np.sum(slope * away) / np.sum(slope * slope), 0.0, time[k] - time[i]))
    return np.append(time[i] + late, values[i] + late * before)


def _last_digit(series: FloatArray) -> float:
    """Return the step of a series that was written with some digits after the point."""
    for digits in range(MOST_DIGITS):
        scaled = series * 10.0**digits
        if np.all(np.abs(scaled - np.round(scaled)) < 1e-3):
            return float(10.0**-digits)
    return float(10.0**-MOST_DIGITS)
