"""The verbs of orientation (paper, section 3.3): turn to the markers, turn along them, measure at rest."""

from __future__ import annotations

import math

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.markers import MARKER_MISSED, heading_of, read_markers, tags_in
from fsm_calib.actions.moving import CLOCKWISE, COUNTERCLOCKWISE
from fsm_calib.actions.turning import turn_step
from fsm_calib.outcome import Outcome


def turn_to_marker(bench: Bench) -> Outcome:
    """Turn one search step counter-clockwise and look for floor markers."""
    return _turn(bench, COUNTERCLOCKWISE, bench.settings.turn.search_step)


def turn_clockwise(bench: Bench) -> Outcome:
    """Turn clockwise by a share of the remaining angle and look at the markers."""
    return _turn(bench, CLOCKWISE, _align_angle(bench))


def turn_counterclockwise(bench: Bench) -> Outcome:
    """Turn counter-clockwise by a share of the remaining angle and look at the markers."""
    return _turn(bench, COUNTERCLOCKWISE, _align_angle(bench))


def measure_marker(bench: Bench) -> Outcome:
    """Measure the markers at rest over several frames and keep the reading as the next drive's start."""
    reading = read_markers(bench)
    if isinstance(reading, Outcome):
        return reading
    notebook = bench.notebook
    notebook.reading, notebook.heading = reading, reading.heading
    evidence = {
        "heading": reading.heading,
        "marker": reading.tags[0].tag_id,
        "distance": round(reading.tags[0].distance, 4),
        "markers": len(reading.tags),
    }
    return Outcome(
        "marker_measured", evidence, f"The marker's angle is {math.degrees(reading.heading):.2f} deg."
    )


def _align_angle(bench: Bench) -> float:
    """Return the size of the next aligning step [rad]."""
    settings = bench.settings.turn
    wanted = settings.align_share * abs(bench.notebook.heading)
    return min(max(wanted, settings.smallest_align_step), settings.largest_align_step)


def _turn(bench: Bench, way: str, angle: float) -> Outcome:
    step = turn_step(bench, way, angle)
    if isinstance(step, Outcome):
        return step
    turned = {"turned": round(step.turned, 5)}
    tags = tags_in(bench, step.frame)
    if not tags:
        return Outcome("marker_missed", turned, MARKER_MISSED.sentence, MARKER_MISSED.cure)
    bench.notebook.heading = heading_of(bench, tags)
    evidence = {**turned, "heading": bench.notebook.heading, "marker": tags[0].tag_id}
    return Outcome(
        "marker_seen", evidence, f"A marker is in sight at {math.degrees(bench.notebook.heading):.1f} deg."
    )
