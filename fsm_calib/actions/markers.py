"""Read the floor markers: where they lie relative to the robot, and how the camera is tilted over the
floor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from statistics import median

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import FRAME_MISSING, look
from fsm_calib.actions.notebook import MarkerReading
from fsm_calib.errors import DataError
from fsm_calib.outcome import Outcome
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.perception.ground import floor_points, observe_tags
from fsm_calib.perception.tags import find_tags
from fsm_calib.perception.tilt import estimate_tilt
from fsm_calib.types import CameraModel, Frame, TagDetection, TagObservation

MARKER_MISSED = Outcome(
    "marker_missed",
    sentence="No floor marker is in sight.",
    cure="Place the robot so that the floor markers begin close behind it, and light the floor.",
)
_TAGS_FOR_TILT = 6  # nearest markers of one tilt fit: more cost time and add little
_LEAST_FOR_TILT = 4  # two or three in a row put the height off by 5 %


def camera_of(bench: Bench) -> CameraModel:
    """Return the calibrated camera, or the fleet's median one before the calibration."""
    return bench.notebook.camera or fleet_camera()


def tags_in(bench: Bench, frame: Frame) -> tuple[TagObservation, ...]:
    """Return the floor markers of one frame relative to the robot, the nearest first."""
    found = found_in(bench, frame)
    seen = observe_tags(found, camera_of(bench), bench.notebook.mount, bench.settings.marker.size)
    return tuple(sorted(_on_floor(bench, found, seen), key=lambda tag: tag.distance))


def found_in(bench: Bench, frame: Frame) -> tuple[TagDetection, ...]:
    """Return the tags of one frame in the image; the first frames also tell how the camera is tilted."""
    found = find_tags(frame.image)
    known = bench.notebook.mount_known == "all"
    if not known and len(bench.notebook.tilt_readings) < bench.settings.marker.tilt_readings:
        _read_tilt(bench, found)
    corners = np.vstack([tag.corners_image for tag in found]) if found else np.empty((0, 2))
    bench.keep(frame.image, frame.time, "markers", corners)
    return found


def _on_floor(
    bench: Bench, found: Sequence[TagDetection], seen: Sequence[TagObservation]
) -> Iterator[TagObservation]:
    """Place the markers where their corners' rays meet the floor.

    The size of a marker in the picture tells its distance poorly, 3 % too far at 0.4 m, because its far edge
    is a few pixels high; the height of the camera tells it within 1 mm there.
    """
    if not seen:
        return
    corners = {tag.tag_id: tag.corners_image for tag in found}
    every = np.vstack([corners[tag.tag_id] for tag in seen])
    centres = floor_points(every, camera_of(bench), bench.notebook.mount).reshape(-1, 4, 2).mean(axis=1)
    for tag, (x, y) in zip(seen, centres.tolist(), strict=True):
        yield replace(tag, x=x, y=y) if math.isfinite(x + y) else tag


def look_at_markers(bench: Bench) -> tuple[TagObservation, ...] | Outcome:
    """Take one frame and return its markers (perhaps none), or the loss of the frame."""
    frame = look(bench)
    return frame if isinstance(frame, Outcome) else tags_in(bench, frame)


def read_markers(bench: Bench) -> MarkerReading | Outcome:
    """Measure the markers at rest over several frames: medians per marker, of those that half of the frames show.

    Frames that do not come are done without; where no marker is left of the others, that is told. After a frozen frame
    the ones before it are not to be trusted.
    """
    settings, start = bench.settings.marker, bench.robot.now()
    tags_by_number: dict[int, list[TagObservation]] = {}
    missed = MARKER_MISSED
    for number in range(settings.frames):
        if number:
            bench.robot.wait(bench.settings.turn.quantum)
        tags = look_at_markers(bench)
        if tags is FRAME_MISSING:
            missed = FRAME_MISSING
            continue
        if isinstance(tags, Outcome):
            return tags
        for tag in tags:
            if tag.distance <= settings.farthest:
                tags_by_number.setdefault(tag.tag_id, []).append(tag)
    medians = [_median_tag(group) for group in tags_by_number.values() if 2 * len(group) >= settings.frames]
    if not medians:
        return missed
    nearest_first = tuple(sorted(medians, key=lambda tag: tag.distance))
    return MarkerReading(nearest_first, heading_of(bench, nearest_first), start)


def heading_of(bench: Bench, tags: Sequence[TagObservation]) -> float:
    """Return the heading [rad] of the nearest marker, by the rules of the settings (published: the last
    one's).
    """
    settings = bench.settings.marker
    tag = max(tags, key=lambda item: item.tag_id) if settings.nearest == "last" else tags[0]
    return tag.heading_camera if settings.heading == "camera" else tag.heading


def heading_sd(bench: Bench, tag: TagObservation) -> float:
    """Return the standard deviation of one marker's heading [rad], without its placement's error.

    It rises with the cube of the distance, as measured on rendered markers: 0.15 deg at 0.25 m, 0.5 at 0.35,
    1.2 at 0.45.
    """
    settings = bench.settings.marker
    share = (tag.distance / settings.reference_distance) ** 3
    return max(settings.heading_sd * share, settings.least_heading_sd)


def _median_tag(group: Sequence[TagObservation]) -> TagObservation:
    """Return the component-wise median; headings are taken about the first one, so that they do not wrap."""
    first = group[0]

    def about(values: list[float], origin: float) -> float:
        return origin + median(math.remainder(value - origin, math.tau) for value in values)

    return replace(
        first,
        x=median(tag.x for tag in group),
        y=median(tag.y for tag in group),
        distance=median(tag.distance for tag in group),
        heading=about([tag.heading for tag in group], first.heading),
        heading_camera=about([tag.heading_camera for tag in group], first.heading_camera),
    )


def _read_tilt(bench: Bench, found: Sequence[TagDetection]) -> None:
    """Refine how the camera sits over the floor by what the markers of one frame tell together.

    The median of the readings is used; the mount is left alone when the markers do not agree on a floor.
    """
    near = sorted(found, key=lambda tag: -float(tag.corners_image[:, 1].max()))[:_TAGS_FOR_TILT]
    if len(near) < _LEAST_FOR_TILT:
        return
    try:
        tilt = estimate_tilt(near, camera_of(bench), bench.settings.marker.size)
    except DataError:
        return
    readings = bench.notebook.tilt_readings
    readings.append((tilt.pitch, tilt.roll, tilt.height))
    pitch, roll, height = (float(value) for value in np.median(readings, axis=0))
    mount = replace(bench.notebook.mount, height=height)
    bench.notebook.mount = mount if bench.notebook.mount_known else replace(mount, pitch=pitch, roll=roll)
