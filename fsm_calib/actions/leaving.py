"""The verbs of the exit (paper, section 5.1): straight out of the field, then hand over in the lane."""

from __future__ import annotations

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.held_up import why_held_up
from fsm_calib.actions.markers import MARKER_MISSED, look_at_markers
from fsm_calib.actions.moving import drive
from fsm_calib.actions.notebook import MarkerReading
from fsm_calib.outcome import Outcome
from fsm_calib.types import STOP, TagObservation


def drive_off(bench: Bench) -> Outcome:
    """Drive straight for one stretch with the k found, then look for markers.

    When the last look showed none, or no frame came, the robot stays where it is and looks again.
    """
    settings, notebook = bench.settings.drive, bench.notebook
    before = notebook.reading.tags if notebook.reading is not None else ()
    drives = not notebook.field_left and not notebook.unseen
    if drives:
        drive(bench, settings.stretch / speed_of(bench), notebook.wheel_ratio)
        notebook.marker_ahead = _farthest(before, notebook.marker_ahead) - settings.stretch
    after = look_at_markers(bench)
    if isinstance(after, Outcome):
        return after
    if drives and _stands(before, after, settings.moved_share * settings.stretch):
        return why_held_up(bench)
    notebook.field_left = not after
    if not after:
        return MARKER_MISSED
    notebook.reading = MarkerReading(after, after[0].heading, bench.robot.now())
    notebook.marker_ahead = _farthest(after, 0.0)
    evidence = {"markers": len(after), "ahead": round(notebook.marker_ahead, 3)}
    return Outcome("marker_seen", evidence, f"{len(after)} markers are still in sight.")


def hand_over(bench: Bench) -> Outcome:
    """Drive on by the known way from the last markers to the lane's middle, stop, hand the robot over."""
    way = max(bench.notebook.marker_ahead + bench.settings.lane.advance, 0.0)
    if way > 0.0:
        drive(bench, way / speed_of(bench), bench.notebook.wheel_ratio)
    bench.robot.command(STOP)
    bench.notebook.marker_ahead, bench.notebook.field_left = 0.0, False
    return Outcome(
        "control_handed", {"advance": round(way, 3)}, "The robot stands in the lane; it may take over."
    )


def speed_of(bench: Bench) -> float:
    """Return the speed of straight drives [m/s]: measured, or the nominal one."""
    return bench.notebook.speed or bench.settings.drive.expected_speed


def _farthest(tags: tuple[TagObservation, ...], otherwise: float) -> float:
    return max((tag.x for tag in tags), default=otherwise)


def _stands(before: tuple[TagObservation, ...], after: tuple[TagObservation, ...], least: float) -> bool:
    """Whether the markers common to both looks say that the robot did not move by `least` [m]."""
    start = {tag.tag_id: tag.x for tag in before}
    shifts = [start[tag.tag_id] - tag.x for tag in after if tag.tag_id in start]
    return bool(shifts) and max(shifts) < least
