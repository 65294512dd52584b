"""The verbs of the wheel iteration (paper, section 3.4): forward, compare, back, update."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import median

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.held_up import DRIVE_BLOCKED, why_held_up
from fsm_calib.actions.marker_map import extend, place
from fsm_calib.actions.markers import look_at_markers, read_markers
from fsm_calib.actions.moving import drive
from fsm_calib.actions.notebook import MarkerReading, WheelRun
from fsm_calib.actions.ratio import combined_ratio, run_from_readings
from fsm_calib.actions.turning import WHEEL_STALLED
from fsm_calib.outcome import Outcome
from fsm_calib.perception.turning import likeness_above
from fsm_calib.types import Pose2, TagObservation


def drive_forward(bench: Bench) -> Outcome:
    """Drive forward with the k so far; the drive is as long as its expected curvature lets the markers stay
    in sight.

    When the markers say that the first drive moved nothing, the command is raised and the drive made again;
    when the most moves nothing forward, a short drive back tells an obstacle from a dead wheel. A robot that
    the last shuttle did not bring back to where it began was held up on the way.
    """
    notebook = bench.notebook
    if _ended_elsewhere(bench):
        return _obstacle_or_wheel(bench)
    notebook.last_duration = _duration(bench)
    notebook.last_ratio = notebook.wheel_ratio
    notebook.is_length_told = True
    notebook.start_panorama = notebook.panorama
    settings = bench.settings
    while True:
        drive(bench, notebook.last_duration, notebook.last_ratio)
        if notebook.runs or _has_moved(bench) is not False:
            return Outcome(
                "drive_finished", {"duration": round(notebook.last_duration, 4)}, "Driven forward."
            )
        command = (notebook.drive_command or settings.drive.command) * settings.turn.raise_factor
        if command > settings.turn.largest_command:
            return _why_still(bench)
        notebook.drive_command = command


def drive_back(bench: Bench) -> Outcome:
    """Drive back for as long as the last drive forward, with the k that it used.

    After a drive whose length no marker told, a way back that ends elsewhere, by the markers it began with, or by the
    picture where there is none: the robot was held up on the way there.
    """
    notebook = bench.notebook
    drive(bench, notebook.last_duration, notebook.last_ratio, backward=True)
    if not notebook.is_length_told and _has_lost_its_start(bench):
        return _obstacle_or_wheel(bench)
    return Outcome("drive_finished", {"duration": round(notebook.last_duration, 4)}, "Driven back.")


def _obstacle_or_wheel(bench: Bench) -> Outcome:
    """Return what held the robot up where pictures have just shown that something did: a loss of one now is not it."""
    held = why_held_up(bench)
    return held if held.trigger in (DRIVE_BLOCKED.trigger, WHEEL_STALLED.trigger) else DRIVE_BLOCKED


def measure_ratio(bench: Bench) -> Outcome:
    """Measure the markers after the drive: k_i from the change of heading and the length of the path."""
    notebook, start = bench.notebook, bench.notebook.reading
    if start is None:
        return Outcome("marker_missed", sentence="No marker was measured before the drive.")
    reading = read_markers(bench)
    if isinstance(reading, Outcome):
        return reading
    distance, seen = driven(bench, start, reading)
    notebook.is_length_told = seen
    if seen and _fell_short(bench, distance):
        return why_held_up(bench)
    if seen:
        notebook.speed = distance / notebook.last_duration
        learn_yaw(bench, distance)
    notebook.readings += [start, reading]
    run = run_from_readings(bench, distance)
    if (
        abs(run.k_i - 1.0) > bench.settings.drive.one_wheel_mismatch
        and bench.settings.ratio.equation == "corrected"
    ):
        notebook.readings = notebook.readings[:-2]
        return WHEEL_STALLED
    notebook.runs.append(run)
    return Outcome("ratio_measured", _run_evidence(run), f"k_i = {run.k_i:.4f} over {run.distance:.2f} m.")


def update_ratio(bench: Bench) -> Outcome:
    """Refine k by a share of k_i - 1; when the correction is quiet (paper: E), leave it, or combine the
    drives.

    As published a quiet drive leaves k alone, and what remains of the mismatch, up to 2 E, is never applied.
    Here a small correction moves k to the weighted least-squares value of all drives, and counts as quiet
    when that value is known well enough: single drives scatter by as much as E.
    """
    notebook, settings = bench.notebook, bench.settings.ratio
    run = notebook.runs[-1]
    correction = settings.share * (run.k_i - 1.0)
    small = abs(correction) < settings.quiet_correction and _is_full(bench, run)
    combined = combined_ratio(bench) if settings.combine and small else None
    quiet = small and (combined is None or combined.error <= settings.largest_error)
    if combined is not None:
        notebook.wheel_ratio = combined.ratio
    elif not quiet:
        notebook.wheel_ratio = run.wheel_ratio + correction
    notebook.wheel_ratio = min(max(notebook.wheel_ratio, settings.least_ratio), 1.0 / settings.least_ratio)
    notebook.ratio_history.append(notebook.wheel_ratio)
    evidence = {"quiet": quiet, "k_i": run.k_i, "wheel_ratio": notebook.wheel_ratio}
    if combined is not None:
        evidence["error"] = combined.error
    return Outcome("ratio_updated", evidence, f"k = {notebook.wheel_ratio:.4f}{', quiet' if quiet else ''}.")


def _run_evidence(run: WheelRun) -> dict[str, float]:
    return {"k_i": run.k_i, "turned": run.turned, "turned_sd": run.sd, "distance": run.distance}


def _fell_short(bench: Bench, distance: float) -> bool:
    """Whether a drive of `distance` [m] is much shorter than the drives before it let expect."""
    runs = bench.notebook.runs
    if not runs or bench.settings.ratio.equation == "published":
        return False
    usual = median(run.distance / run.duration for run in runs)
    return distance < bench.settings.drive.reached_share * usual * bench.notebook.last_duration


def _ended_elsewhere(bench: Bench) -> bool:
    """Whether the last drive forward and back ended far from where it began, by the markers seen at both
    times.

    It catches an obstacle that hides the markers behind it: the drive's length is not known then, but the way
    back is longer than the way there.
    """
    notebook = bench.notebook
    if not notebook.runs or notebook.reading is None or bench.settings.ratio.equation == "published":
        return False
    return _is_elsewhere(bench, notebook.reading.tags) is True


def _has_lost_its_start(bench: Bench) -> bool:
    """Whether two frames show the first markers of the last drive elsewhere, or none of them and another place.

    The first frame of a camera that froze on the way shows the way; the second one is then the same.
    """
    if bench.settings.ratio.equation == "published":
        return False
    for _ in range(2):
        tags = look_at_markers(bench)
        if isinstance(tags, Outcome):
            return False  # a lost frame is told by the next look
        is_elsewhere = _is_elsewhere(bench, tags)
        if is_elsewhere is False or (is_elsewhere is None and _looks_as_at_start(bench)):
            return False
    return True


def _looks_as_at_start(bench: Bench) -> bool:
    """Whether what stands far off looks as it did before the last drive: then it is the markers that are not seen."""
    before, after = bench.notebook.start_panorama, bench.notebook.panorama
    if before is None or after is None:
        return False
    return likeness_above(before, after) >= bench.settings.drive.same_place


def _is_elsewhere(bench: Bench, tags: Sequence[TagObservation]) -> bool | None:
    """Whether the markers that the last drive began with are far from where they were; None where none is seen."""
    notebook, settings = bench.notebook, bench.settings.drive
    began, distance = notebook.readings[-2], notebook.runs[-1].distance
    shifts = [math.hypot(a.x - b.x, a.y - b.y) for a, b in _common(began.tags, tags)]
    most = max((1.0 - settings.reached_share) * distance, settings.least_shift)
    return median(shifts) > most if shifts else None


def _common(
    before: Sequence[TagObservation], after: Sequence[TagObservation]
) -> list[tuple[TagObservation, TagObservation]]:
    """Return the markers of both looks, paired."""
    known = {tag.tag_id: tag for tag in before}
    return [(known[tag.tag_id], tag) for tag in after if tag.tag_id in known]


def _speed(bench: Bench) -> float:
    return bench.notebook.speed or bench.settings.drive.expected_speed


def _duration(bench: Bench) -> float:
    """Return how long to drive [s]: full length when the last residual allows, else shorter; at most twice
    the last.
    """
    settings, runs = bench.settings.drive, bench.notebook.runs
    if bench.settings.ratio.equation == "published":
        return bench.settings.ratio.published_duration
    mismatch = settings.first_mismatch
    longest = settings.distance
    if runs:
        mismatch = (1.0 - bench.settings.ratio.share) * abs(runs[-1].k_i - 1.0) + settings.mismatch_margin
        longest = min(longest, settings.growth * runs[-1].distance)
    allowed = settings.largest_heading_change * bench.settings.ratio.axle_length / mismatch
    return max(min(longest, allowed), settings.shortest) / _speed(bench)


def _is_full(bench: Bench, run: WheelRun) -> bool:
    """Whether a drive was long enough to count as quiet: nine tenths of the full length (its speed is
    estimated).
    """
    return bench.settings.ratio.equation == "published" or run.distance >= 0.9 * bench.settings.drive.distance


def _has_moved(bench: Bench) -> bool | None:
    """Whether the markers moved as a drive moves them; None when no marker of the start is in sight any
    more.
    """
    start = bench.notebook.reading
    tags = look_at_markers(bench)
    if start is None or isinstance(tags, Outcome):
        return None
    common = _common(start.tags, tags)
    if not common:
        return None
    expected = _speed(bench) * bench.notebook.last_duration
    return max(_shift(*pair) for pair in common) > bench.settings.drive.moved_share * min(expected, 0.1)


def _shift(before: TagObservation, after: TagObservation) -> float:
    return (
        math.hypot(after.x - before.x, after.y - before.y)
        + abs(after.heading - before.heading) * before.distance
    )


def _why_still(bench: Bench) -> Outcome:
    drive(bench, bench.notebook.last_duration, bench.notebook.last_ratio, backward=True)
    return DRIVE_BLOCKED if _has_moved(bench) is not False else WHEEL_STALLED


def driven(bench: Bench, start: MarkerReading, reading: MarkerReading) -> tuple[float, bool]:
    """Return the length of the path [m] and whether the markers told it (else speed times time did)."""
    markers = bench.notebook.marker_map
    first = extend(markers, start)
    if first is None:
        markers.clear()
        first = extend(markers, start)
    second = place(markers, reading)
    if first is None or second is None:
        return _speed(bench) * bench.notebook.last_duration, False
    extend(markers, reading)
    bench.notebook.last_step = first.inverse().then(second)
    return path_length(first, second), True


def learn_yaw(bench: Bench, distance: float) -> None:
    """Refine the camera's yaw by the direction in which the markers say that the robot drove.

    An arc that turns by a [rad] leaves along a / 2 of the robot's forward direction; a camera that looks to
    the left by y sees it along a / 2 - y. The mean over drives is weighted by their squared lengths; a drive
    that turned far tells nothing.
    """
    notebook = bench.notebook
    step, yaw = notebook.last_step, notebook.mount.yaw
    if abs(step.theta) > bench.settings.drive.straight_within:
        return
    seen = math.atan2(step.y, step.x) - 0.5 * step.theta
    notebook.yaw_weight += distance**2
    share = distance**2 / notebook.yaw_weight
    notebook.mount = replace(notebook.mount, yaw=yaw - share * seen)


def path_length(first: Pose2, second: Pose2) -> float:
    """Return the length of the circular arc between two poses [m]: s = c (a / 2) / sin(a / 2).

    c : distance of the end points [m]; a : change of heading [rad].
    """
    step = first.inverse().then(second)
    chord, half = math.hypot(step.x, step.y), 0.5 * abs(step.theta)
    return chord if half < 1e-6 else chord * half / math.sin(half)
