"""Where the robot stands among the markers: a small map that grows as markers are seen together.

The first reading fixes the map's frame. A reading that shares a marker with the map places the robot: each
known marker with pose M in the map and pose T in the robot's frame says robot = M T^-1; the weighted mean of
these is taken, and markers seen for the first time are added. Positions are good to a centimetre: enough to
know how far the robot drove and whether it drove at all. Headings for k come from `heading_adjustment`, not
from here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from fsm_calib.actions.notebook import MarkerReading
from fsm_calib.types import Pose2, TagObservation

MarkerMap = dict[int, Pose2]
"""Number of the marker -> its pose in the map."""


def place(markers: MarkerMap, reading: MarkerReading) -> Pose2 | None:
    """Return the robot's pose in the map, None when no known marker is in the reading."""
    known = [tag for tag in reading.tags if tag.tag_id in markers]
    if not known:
        return None
    poses = [markers[tag.tag_id].then(_pose(tag).inverse()) for tag in known]
    return _mean(poses, [1.0 / tag.distance**4 for tag in known])


def extend(markers: MarkerMap, reading: MarkerReading) -> Pose2 | None:
    """Add the markers of a reading that are not in the map yet, and return the robot's pose in it.

    An empty map begins with the robot at its origin; a reading without a known marker adds nothing and
    returns None.
    """
    robot = Pose2() if not markers else place(markers, reading)
    if robot is not None:
        for tag in reading.tags:
            markers.setdefault(tag.tag_id, robot.then(_pose(tag)))
    return robot


def _pose(tag: TagObservation) -> Pose2:
    return Pose2(tag.x, tag.y, tag.heading)


def _mean(poses: Sequence[Pose2], weights: Sequence[float]) -> Pose2:
    total = sum(weights)
    pairs = list(zip(poses, weights, strict=True))
    sine = sum(weight * math.sin(pose.theta) for pose, weight in pairs)
    cosine = sum(weight * math.cos(pose.theta) for pose, weight in pairs)
    x = sum(weight * pose.x for pose, weight in pairs) / total
    y = sum(weight * pose.y for pose, weight in pairs) / total
    return Pose2(x, y, math.atan2(sine, cosine))
