"""The robot's own camera as the source of poses: the drawing's map, what is seen from where, what drives tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.floor_tracker import FloorTracker, PoseRow, camera_offset, moved_to_axle
from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.investigating import Field
from fsm_calib.actions.markers import camera_of
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.sight import Sight
from fsm_calib.diagnosis.replay.prepared import FEWEST_FRAMES
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.errors import InputError
from fsm_calib.perception.floor_map import adjusted_poses, pose_spreads
from fsm_calib.perception.floor_pose import view_on_floor
from fsm_calib.perception.levelled import levelled
from fsm_calib.types import CameraMount, Pose2
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.vocabulary import POSE_HOOKS
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.scene import SceneSpec
from fsm_calib.world2d.surfaces import field_markers

Seat = tuple[float, float, float, float]
"""Where poses lie on the robot, x, y [m], yaw [rad], and by how much their stamps are late [s]."""
MOST_OFFSET, MOST_YAW = 0.01, 0.03
"""By so much a calibrated camera may sit elsewhere than it is known to [m, rad]."""
MOST_LATE = 0.2
"""By so much a frame's time may be off [s]: a robot on a network stamps it late, and its link dates it back."""
SEATS = ("sensor_offset", "sensor_yaw")
"""The effects that tell where the poses lie on the robot."""
SEEN = 2.0
"""Log-likelihood that a seat wins from which on it is more than chance: two standard deviations."""
POORLY = 3.0
"""Times the median pose's standard deviation from which on a pose is left out: the likelihood takes all as equally
good, and a robot that spins past a single blurred tag errs by 40 mrad where it usually errs by one."""
VIEW_CELL, VIEW_REACH = (
    0.02,
    0.6,
)  # m: cells of the camera's view of the floor; farther tags are not relied on


def drawn_tags(scene: SceneSpec) -> dict[int, Pose2]:
    """Return where the drawing has the floor markers; how they were laid is a little off, which nobody tells.

    Raises
    ------
    InputError
        The drawing has none.
    """
    if scene.field is None:
        raise InputError(
            "there are no floor markers", where="scene.field", cure="Draw a field, or take poses: tracker."
        )
    exact = replace(scene.field, spacing_sd=0.0, heading_sd=0.0)
    markers = field_markers(exact, np.random.default_rng(0))  # nothing is drawn: both spreads are zero
    return {marker.tag_id: marker.pose for marker in markers}


def tag_size(scene: SceneSpec) -> float:
    """Return the side of the drawing's floor markers [m]."""
    return 0.065 if scene.field is None else scene.field.size


def tracker_of(bench: Bench, scene: SceneSpec, asked: InvestigateSettings) -> FloorTracker:
    """Return the tracker that looks through the robot's own camera."""
    return FloorTracker(bench, drawn_tags(scene), tag_size(scene), asked.exposure)


def with_sight(area: Area, bench: Bench, scene: SceneSpec, asked: InvestigateSettings) -> Area:
    """Return the area in which the camera, as it is known, also sees enough tags."""
    tags = drawn_tags(scene)
    ahead = np.arange(-0.2, VIEW_REACH, VIEW_CELL)
    aside = np.arange(-VIEW_REACH, VIEW_REACH, VIEW_CELL)
    x, y = (a.ravel() for a in np.meshgrid(ahead, aside, indexing="ij"))
    cells = np.column_stack([x, y]) + 0.5 * VIEW_CELL
    view = view_on_floor(camera_of(bench), bench.notebook.mount, cells, tag_size(scene), VIEW_REACH)
    sight = Sight(
        tags=np.array([(pose.x, pose.y) for pose in tags.values()]),
        view=view.reshape(len(ahead), len(aside)),
        view_corner=(float(ahead[0]), float(aside[0])),
        view_cell=VIEW_CELL,
        bounds=(area.x_low, area.x_high, area.y_low, area.y_high),
        fewest=asked.tags,
        blind=asked.unseen,
    )
    return replace(area, sight=sight)


def corrected(
    drives: Sequence[Field], scene: SceneSpec, mount: CameraMount, camera: Seat
) -> list[list[PoseRow]]:
    """Return the poses of drives by a map that all of them tell together, and with where the camera sits by them.

    How tags were laid and how the camera is mounted, known to 3 mm and half a degree, are no physics of the robot.
    Poses that their tags tell poorly (`well_told`) are left out. mount : as it was known when the tags were seen.
    """
    size, drawn = tag_size(scene), drawn_tags(scene)
    frames = levelled([tags for drive in drives for tags in drive.seen], drawn, mount, size)
    poses, _ = adjusted_poses(frames, drawn, size)
    rows, begin = list[list[PoseRow]](), 0
    for drive, good in zip(drives, well_told(drives, size), strict=True):
        told = zip(drive.poses, poses[begin : begin + len(drive.poses)].tolist(), strict=True)
        begin += len(drive.poses)
        rows.append([_as_wound(row, pose) for row, pose in compress(told, good)])
    ahead, yaw = camera_offset(rows)
    return [_seen_from(moved_to_axle(r, ahead, yaw), camera) for r in rows]


def well_told(drives: Sequence[Field], size: float) -> list[NDArray[np.bool_]]:
    """Return which poses of each drive their tags of side `size` [m] tell well enough, (n,) each: not those whose place
    or heading is known `POORLY` times worse than that of the median of all. Of a drive that would be too short without
    them all stay.
    """
    spreads = [pose_spreads(drive.seen, size) for drive in drives]
    usual = np.median(np.vstack(spreads), axis=0)
    good = [np.asarray((s <= POORLY * usual).all(axis=1)) for s in spreads]
    return [g if g.sum() >= FEWEST_FRAMES else np.ones(len(g), dtype=bool) for g in good]


def not_of_a_camera(linked: bool) -> frozenset[str]:
    """Return the effects that only a pose sensor has, and a robot that places itself by its own camera has not.

    How markers were laid is learnt from its frames, and frames and commands are dated by one clock, unless frames come
    over a network (`linked`). Where the camera sits is asked for, and learnt (`camera_found`).
    """
    of_sensor = [e for e in registry().values() if set(e.hooks) <= set(POSE_HOOKS) and e.name not in SEATS]
    return frozenset(e.name for e in of_sensor if not (linked and "clock" in e.hooks))


def camera_found(decision: Decision, linked: bool) -> Seat:
    """Return where an answer has the poses on the robot, and how late; zeros where it has them right.

    Only what a mount and a clock may be off is taken: more is the robot's or the floor's. linked : whether frames come
    over a network, which dates them; one that stamps its own is not late. Where nothing is missing, or what is missing
    has no name, a seat too small to be found is taken too: no camera sits to a tenth of a millimetre where it is known
    to, and what that leaves was taken for physics.
    """
    table, model = parameter_table(), decision.model
    alone = (
        {}
        if model.effects
        else {r.name: r.fit for r in decision.ranking if r.name in SEATS and r.gain > SEEN}
    )

    def number(effect: str, name: str) -> float:
        return float(alone.get(effect, model.fit).values[0, table.place(f"{effect}.{name}")])

    x, y, yaw = number("sensor_offset", "x"), number("sensor_offset", "y"), number("sensor_yaw", "yaw")
    late = number("observation_delay", "delay")
    if math.hypot(x, y) > MOST_OFFSET or abs(yaw) > MOST_YAW:
        x = y = yaw = 0.0
    return x, y, yaw, late if linked and abs(late) <= MOST_LATE else 0.0


def _seen_from(rows: Sequence[PoseRow], camera: Seat) -> list[PoseRow]:
    """Return the poses of the axle's centre, when they were true, of poses that the camera tells from its seat."""
    x, y, yaw, late = camera
    out = []
    for time, px, py, theta in rows:
        base = Pose2(px, py, theta - yaw).then(Pose2(-x, -y))
        out.append((time - late, base.x, base.y, theta - yaw))
    return out


def _as_wound(row: PoseRow, pose: Sequence[float]) -> PoseRow:
    """Return a new pose (x, y, theta) in place of a row's, with as many whole turns as that has."""
    x, y, theta = pose
    return row[0], x, y, row[3] + math.remainder(theta - row[3], math.tau)
