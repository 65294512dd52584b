"""Wheel scales, axle length and the tracked point from measured wheels and poses.

Some logs leave open how wheels and poses belong together; each way of reading is tried and the likelihood
decides: a rate may be the value at its stamp or the mean over the interval before or after it, and two
channels with the same number of rows may belong together row by row although their stamps differ.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from fsm_calib.diagnosis.identify.align import align
from fsm_calib.diagnosis.identify.filter import BY_WHEELS, STEP_COLUMNS, sway
from fsm_calib.diagnosis.identify.pose import Parameter, PoseFit, fit_pose, thinned
from fsm_calib.diagnosis.replay.wheels import Wheels, wheels_of
from fsm_calib.recording.channels import Stamp
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import travel
from fsm_calib.types import FloatArray

CLOCK_SPREAD = 0.5  # s, prior of the difference of the two channels' clocks
WHEEL_NOISE = {"q_f": 0.004, "q_t": 0.01}  # m/sqrt(m), rad/sqrt(m): a small robot on a hard floor
CLEARLY_LIKELIER = 5.0  # log units by which another way of reading must win (a factor 150 in likelihood)


class WheelMotion:
    """The wheels were measured: steps of path and turn between the filter's events (see
    `identify_pose.Motion`).
    """

    mode = BY_WHEELS
    noise = WHEEL_NOISE

    def __init__(self, wheels: Wheels, scales: tuple[float, float], axle: float) -> None:
        self.wheels = wheels
        self._scales = np.array(scales)
        self._known: dict[float, tuple[FloatArray, FloatArray, FloatArray]] = {}
        self.parameters = {
            "left": Parameter(scales[0], scales[0]),
            "right": Parameter(scales[1], scales[1]),
            "axle": Parameter(axle, axle),
            "clock": Parameter(0.0, 0.05, CLOCK_SPREAD),
        }

    def times(self, pose_times: FloatArray, delay: float) -> FloatArray:
        """Return pose times and, between them, the wheels' own times."""
        own = self.wheels.time
        inside = own[(own > pose_times[0]) & (own < pose_times[-1])]
        return np.unique(np.concatenate([pose_times, inside]))

    def steps(self, times: FloatArray, p: dict[str, float]) -> FloatArray:
        """Return duration, path, turn, the mean way of the two wheels and the sway for each event; the first
        is at rest.

        The way, over which noise grows and the tracker's errors change, is that of the first guess of the scales:
        were it theirs, wheels of no size would make a tracker's errors wander without end, which tells every path.
        (So it was for a robot of 470 kg that slides sideways on gravel: a radius of 4 to 28 mm in place of 270.)
        """
        scales = np.array([p["left"], p["right"]])
        rolled, gained = self._along(times, p["clock"])
        travel, gained = rolled * scales, gained * scales
        steps = np.zeros((len(times), STEP_COLUMNS))
        steps[1:, 0] = np.diff(times)
        steps[1:, 1] = travel.mean(axis=1)
        steps[1:, 2] = (travel[:, 1] - travel[:, 0]) / p["axle"]
        steps[1:, 3] = np.abs(rolled * self._scales).mean(axis=1)
        steps[1:, 5] = sway(
            steps[1:, 1], steps[1:, 2], gained.mean(axis=1), (gained[:, 1] - gained[:, 0]) / p["axle"]
        )
        return steps

    def _along(self, times: FloatArray, clock: float) -> tuple[FloatArray, FloatArray]:
        """Return `Wheels.along` by the poses' clock; most steps of a search leave the clocks as they were."""
        if clock not in self._known or self._known[clock][0] is not times:
            self._known = {clock: (times, *self.wheels.along(times + clock))}
        return self._known[clock][1:]

    def constants(self, p: dict[str, float]) -> tuple[float, float]:
        """Return unit time constants: measured wheels need none."""
        return 1.0, 1.0


def fit_wheels(recording: Recording) -> tuple[PoseFit, Wheels, tuple[str, ...]]:
    """Fit one recording; return the fit, the wheels as they were read and what to tell about the reading."""
    readings = _readings(recording)
    fits = [(_fit(recording, wheels), wheels, note) for wheels, note in readings]
    stated = fits[0]
    best = max(fits, key=lambda found: found[0].log_likelihood)
    if best[0].log_likelihood < stated[0].log_likelihood + CLEARLY_LIKELIER:
        best = stated
    return best[0], best[1], (best[2],) if best[2] else ()


def _fit(recording: Recording, wheels: Wheels) -> PoseFit:
    pose = thinned(recording.pose)
    start = align(wheels, pose, recording.robot.axle_length)
    return fit_pose(pose, WheelMotion(start.applied(wheels), start.scales, start.axle), start)


def _readings(recording: Recording) -> list[tuple[Wheels, str]]:
    """Return the wheels as stated first, then the other ways of reading them with a sentence for each."""
    stated = wheels_of(recording)
    readings = [(stated, "")]
    track = recording.wheel_angle or recording.wheel_rate or recording.wheel_speed
    if track is None or track.duration is not None:
        return readings
    if recording.wheel_angle is None and track.stamp is None:
        other: tuple[tuple[str, Stamp], ...] = (("before", "end"), ("after", "start"))
        for sentence, stamp in other:
            _, left, right = travel(dataclasses.replace(track, stamp=stamp))
            note = f"the wheels' rates are best read as means over the interval {sentence} their stamp"
            readings.append((dataclasses.replace(stated, left=left, right=right), note))
    pose = recording.pose
    if recording.wheel_angle is None or pose is None or len(pose) != len(track):
        return readings
    apart = float(np.abs(pose.time - track.time).max())
    if apart > 0.0:
        note = f"wheels and poses are best paired row by row: their stamps differ by up to {apart:.2f} s"
        readings.append((dataclasses.replace(stated, time=pose.time), note))
    return readings
