"""The robot's own camera over mapped floor tags as the tracker of an investigation.

Every look is one rendered or real frame: tags are found and the camera's tilt refined as in the calibration, then all
their corners place the robot on the drawing's map (`perception.floor_pose`). Nothing else tells where the robot is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import look
from fsm_calib.actions.markers import camera_of, found_in
from fsm_calib.outcome import Outcome
from fsm_calib.perception.floor_map import SeenTag
from fsm_calib.perception.floor_pose import floor_pose
from fsm_calib.types import Pose2

PoseRow = tuple[float, float, float, float]
SPAN, MOST_TURN, LEAST_MOTION = (
    0.25,
    0.8,
    0.02,
)  # s, rad, m + rad: of a piece of path that tells how the camera sits
LEAST_PIECES = 30
MOST_AHEAD, MOST_YAW = 0.01, 0.05  # m, rad: a camera that sits farther from where it is known to was moved


@dataclass(slots=True)
class FloorTracker:
    """Tells where the robot stands on the map (`ports.Tracker`); headings are wrapped.

    tags : the map, poses in `world`. size : side of a tag [m]. exposure : time the shutter is open [s]; a frame is
    stamped at its end and shows the robot half of it before. kept : the tags of each pose since `drained`.
    """

    bench: Bench
    tags: Mapping[int, Pose2]
    size: float = 0.065
    exposure: float = 0.008
    kept: list[tuple[SeenTag, ...]] = field(default_factory=list)

    def poses(self) -> list[PoseRow]:
        """Take one frame; return its pose, or nothing when no tag tells one."""
        frame = look(self.bench)
        if isinstance(frame, Outcome):
            return []
        found = found_in(self.bench, frame)
        seen = floor_pose(found, camera_of(self.bench), self.bench.notebook.mount, self.tags, self.size)
        if seen is None:
            return []
        self.kept.append(seen.seen)
        return [(frame.time - 0.5 * self.exposure, seen.pose.x, seen.pose.y, seen.pose.theta)]

    def drained(self) -> list[tuple[SeenTag, ...]]:
        """Return the tags of each pose since the last call, and forget them."""
        kept, self.kept = self.kept, []
        return kept


def unwound(
    rows: Sequence[PoseRow], commands: Sequence[tuple[float, float, float]], rate: float
) -> list[PoseRow]:
    """Return poses whose headings go on without jumps, by whole turns nearest to what was commanded.

    rate : turning at opposite commands of 1 [rad/s].
    """
    out: list[PoseRow] = []
    before = 0.0
    for row in rows:
        expected = out[-1][3] + _commanded(commands, out[-1][0], row[0], rate) if out else row[3]
        before = row[3] + math.tau * round((expected - row[3]) / math.tau)
        out.append((row[0], row[1], row[2], before))
    return out


def _commanded(
    commands: Sequence[tuple[float, float, float]], begin: float, end: float, rate: float
) -> float:
    """Return the turn [rad] that commands ask for between two times [s]."""
    turned = 0.0
    for (time, left, right), (after, _, _) in pairwise((*commands, (math.inf, 0.0, 0.0))):
        turned += 0.5 * rate * (right - left) * max(min(end, after) - max(begin, time), 0.0)
    return turned


def camera_offset(drives: Sequence[Sequence[PoseRow]]) -> tuple[float, float]:
    """Return how far ahead of the axle poses truly are [m], and the yaw to add to their headings [rad], by drives.

    Wheels do not go sideways: of a pose that is l ahead of the axle and heads a to the right of the robot, a short
    piece of path goes to the left by dy = a dx + l dtheta in its own mean heading; least squares over all pieces of
    `SPAN` [s], twice, the second time without those that are off by three times the median. As `wheel_runs.learn_yaw`
    does for the yaw alone. Zeros where there are too few pieces.
    """
    pieces = np.array([piece for rows in drives for piece in _pieces(rows)]).reshape(-1, 3)
    if len(pieces) < LEAST_PIECES:
        return 0.0, 0.0
    kept = np.ones(len(pieces), dtype=bool)
    answer = np.zeros(2)
    for _ in range(3):
        dx, dtheta, dy = pieces[kept].T
        answer = np.linalg.lstsq(np.column_stack([dtheta, dx]), dy, rcond=None)[0]
        off = np.abs(pieces[:, 2] - pieces[:, 1] * answer[0] - pieces[:, 0] * answer[1])
        kept = off <= 3.0 * np.median(off) + 1e-12
    ahead, yaw = np.clip(answer, (-MOST_AHEAD, -MOST_YAW), (MOST_AHEAD, MOST_YAW))
    return float(ahead), float(yaw)


def _pieces(rows: Sequence[PoseRow]) -> Iterator[tuple[float, float, float]]:
    """Yield pieces of path: forward [m], turn [rad] and to the left [m], in the frame of the mean heading."""
    first = 0
    for last, row in enumerate(rows):
        while row[0] - rows[first][0] > SPAN:
            first += 1
        dx, dy, turn = (row[k] - rows[first][k] for k in (1, 2, 3))
        if last == first or abs(turn) > MOST_TURN or math.hypot(dx, dy) + abs(turn) < LEAST_MOTION:
            continue
        middle = rows[first][3] + 0.5 * turn
        c, s = math.cos(middle), math.sin(middle)
        yield c * dx + s * dy, 2.0 * math.sin(0.5 * turn), c * dy - s * dx


def moved_to_axle(rows: Sequence[PoseRow], ahead: float, yaw: float) -> list[PoseRow]:
    """Return poses of the axle's centre from poses that are `ahead` [m] of it and lack `yaw` [rad]."""
    out = []
    for time, x, y, theta in rows:
        heading = theta + yaw
        out.append((time, x - ahead * math.cos(heading), y - ahead * math.sin(heading), heading))
    return out
