"""Refine k in the lane (paper, section 5.2): from marker to marker, then judge all measurements together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.leaving import speed_of
from fsm_calib.actions.markers import MARKER_MISSED, read_markers
from fsm_calib.actions.moving import drive
from fsm_calib.actions.notebook import WheelRun
from fsm_calib.actions.ratio import adjusted, corrected, drive_scatter
from fsm_calib.actions.wheel_runs import driven
from fsm_calib.outcome import Outcome


def drive_to_next_marker(bench: Bench) -> Outcome:
    """Drive straight until the next marker lies where the nearest one lay."""
    notebook, reading = bench.notebook, bench.notebook.reading
    if reading is None:
        return MARKER_MISSED
    ahead = sorted(tag.x for tag in reading.tags)
    way = ahead[1] - ahead[0] if len(ahead) > 1 else bench.settings.lane.marker_pitch
    notebook.last_duration, notebook.last_ratio = way / speed_of(bench), notebook.wheel_ratio
    drive(bench, notebook.last_duration, notebook.last_ratio)
    return Outcome("next_marker_reached", {"way": round(way, 4)}, "Driven straight to the next marker.")


def refine_ratio(bench: Bench) -> Outcome:
    """Measure the markers after the drive: one more k_i."""
    notebook, start = bench.notebook, bench.notebook.reading
    reading = read_markers(bench)
    if isinstance(reading, Outcome) or start is None:
        return reading if isinstance(reading, Outcome) else MARKER_MISSED
    distance, _ = driven(bench, start, reading)
    notebook.lane_readings += [start, reading]
    turned, sd = adjusted(bench, notebook.lane_readings).turned(-2, -1)
    k_i = 1.0 - turned * bench.settings.ratio.axle_length / distance
    notebook.lane_runs.append(
        WheelRun(notebook.last_ratio, notebook.last_duration, distance, turned, sd, k_i)
    )
    evidence = {"k_i": k_i, "turned": turned, "distance": distance, "markers": len(notebook.lane_runs)}
    return Outcome("ratio_measured", evidence, f"k_i = {k_i:.4f} in the lane.")


@dataclass(frozen=True, slots=True)
class Judgement:
    """All drives of the marked section together: k - k_in_use, its standard error, the scatter of the k_i
    [1].
    """

    correction: float
    error: float
    scatter: float
    readings: int


def judge_refinement(bench: Bench) -> Outcome:
    """Apply a new k only when its measurements are constant and differ significantly from the k in use."""
    notebook, settings = bench.notebook, bench.settings.lane
    judgement = judge(bench)
    least = max(settings.change, settings.significance * judgement.error)
    constant = judgement.scatter <= settings.largest_scatter and judgement.readings >= settings.least_readings
    evidence = {
        "correction": judgement.correction,
        "standard_error": judgement.error,
        "scatter": judgement.scatter,
        "readings": judgement.readings,
        "least": least,
    }
    if constant and abs(judgement.correction) > least:
        notebook.wheel_ratio += judgement.correction
        return Outcome("ratio_applied", evidence, f"A new k is in use: {notebook.wheel_ratio:.4f}.")
    why = "its values scatter" if not constant else "the difference is not significant"
    return Outcome("ratio_kept", evidence, f"The k in use is kept: {why}.")


def judge(bench: Bench) -> Judgement:
    """Return what the drives of the marked section say together.

    k - k_in_use = -L sum(turned) / sum(s): the sum weighs long drives more, and the markers' own orientation
    errors cancel between neighbours. Its error has two parts, as that of `combined_ratio`: the headings', from the
    covariance of all, and the drives' own, q / sqrt(sum(s)), without which six short drives seem to tell more than
    wheels repeat.
    """
    notebook = bench.notebook
    count = len(notebook.lane_runs)
    if count == 0:
        return Judgement(0.0, float("inf"), 0.0, 0)
    headings = adjusted(bench, notebook.lane_readings)
    distance = np.array([run.distance for run in notebook.lane_runs])
    pick, length = np.kron(np.eye(count), [-1.0, 1.0]), bench.settings.ratio.axle_length
    turned, total = pick @ headings.theta, float(distance.sum())
    single, mean = -turned * length / distance, -float(turned.sum()) * length / total
    covariance = pick @ headings.covariance @ pick.T
    sd = np.sqrt(np.diag(covariance)) * length / distance
    own = drive_scatter(single - mean, sd, distance, bench.settings.ratio.run_scatter) / total
    error = float(np.sqrt(covariance.sum() * (length / total) ** 2 + own))
    ratio = notebook.lane_runs[-1].wheel_ratio
    correction = float(corrected(np.array(ratio), np.array(mean))) - ratio
    return Judgement(correction, ratio * error, float(np.std(single)), count)
