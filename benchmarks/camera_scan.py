"""How good is the camera that a scan gives? Robots of the fleet, rendered pixels, error against truth.

    python benchmarks/camera_scan.py --runs 100 --out out/camera_scan.jsonl      (resumable; --table prints only)

Each run draws a robot (lens, pitch, height, focus), lets it turn on one wheel, 3 deg a step, 75 deg to each side, in
an area with boards, renders every stop, and solves. Beside it 30 hand-held views of one board, 0.18 to 0.6 m away,
tilted up to 45 deg, are rendered and solved by the same code. The error is "al": projections of the same ray over
the whole image, best rotation removed.
"""

import argparse
import json
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from fsm_calib.perception.chessboard import find_board, find_boards
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.perception.information import (
    DEFAULT_STOP,
    begin_scan,
    is_enough,
    is_worth_keeping,
    solve_scan,
    with_view,
)
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import intrinsics_vector, project, unproject
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.perception.rotations import (
    BASE_FROM_OPTICAL,
    mount_from_pose,
    rotation_from_vector,
)
from fsm_calib.perception.static_boards import calibrate_static, frames_of
from fsm_calib.types import BoardSpec, BoardView, CameraModel, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import RobotSpec, draw_robot
from fsm_calib.world2d.layout import mixed_boards, upright_boards
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

SIZE = (640, 480)
BOARD = BoardSpec()
SWEEP, STEP = math.radians(75.0), math.radians(3.0)
AHEAD = math.radians(12.0)  # boards follow the last frame's within this azimuth
LAYOUTS = {"mixed3": mixed_boards(3), "mixed4": mixed_boards(4), "upright2": upright_boards(2)}


def scan_poses(axle: float, rng: np.random.Generator) -> Iterator[Pose2]:
    """Yield the stops of a robot that turns on one wheel: clockwise, then counter-clockwise, then back."""
    pose = Pose2()
    stops = [pose]
    for sign, end in ((-1.0, -SWEEP), (1.0, SWEEP), (-1.0, 0.0)):
        pivot = Pose2(0.0, sign * axle / 2.0)  # the standing wheel: the right one for a clockwise turn
        while sign * (pose.theta - end) < 0.0:
            turn = Pose2(0.0, 0.0, sign * STEP * float(rng.uniform(0.7, 1.3)))
            pose = pose.then(pivot).then(turn).then(pivot.inverse())
            stops.append(pose)
    yield from stops


class Labels:
    """Tells boards apart by following their azimuth from frame to frame; a new one is numbered in turn."""

    def __init__(self, layout: tuple[BoardPlacement, ...]) -> None:
        self.azimuths = [math.atan2(placement.y, placement.x) for placement in layout]

    def number(self, view: BoardView, heading: float) -> int:
        """Return the number of the board nearest to where the view points, by the robot's rough heading [rad]."""
        ray = unproject(intrinsics_vector(fleet_camera()), view.corners_image.mean(axis=0, keepdims=True))[0]
        azimuth = heading - math.atan2(float(ray[0]), 1.0)
        return int(np.argmin([abs(math.remainder(azimuth - other, math.tau)) for other in self.azimuths]))


def scan(robot: RobotSpec, layout: tuple[BoardPlacement, ...], rng: np.random.Generator) -> list[BoardView]:
    """Return every board view of one scan, numbered, in order of time."""
    renderer = Renderer(build_scene(SceneSpec(boards=layout), rng), robot.camera, robot.mount)
    sensor, labels, views = SensorSettings(defocus=robot.defocus), Labels(layout), []
    for index, pose in enumerate(scan_poses(robot.axle_length, rng)):
        image = expose(renderer.ideal(pose), robot.camera, sensor, rng)
        for view in find_boards(image, BOARD):
            views.append(replace(view, board=labels.number(view, pose.theta), source=f"frame {index}"))
    return views


def informed(views: list[BoardView], boards: int) -> tuple[list[BoardView], bool]:
    """Return the views that the scan would have kept by what they add, and whether its stop rule was reached."""
    progress, kept, history = begin_scan(SIZE, boards), [], []
    for view in views:
        if not is_worth_keeping(view, BOARD, progress):
            continue
        kept.append(view)
        progress = with_view(view, BOARD, progress)
        if len(kept) % 5 == 0:
            progress = solve_scan(kept, BOARD, progress)
            history.append(progress.predicted_px)
            if is_enough(history, progress.views_per_board, DEFAULT_STOP):
                return kept, True
    return kept, False


def hand_held(robot: RobotSpec, count: int, rng: np.random.Generator) -> list[BoardView]:
    """Return views of one board held by hand before the camera, each whole in the image."""
    placement = BoardPlacement(BOARD, x=2.0, y=0.0, z=1.5, yaw=math.pi)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    sensor, views = SensorSettings(defocus=robot.defocus), []
    world = board_points_world(placement)
    while len(views) < count:
        mount = _hand_pose(world, robot.camera, rng)
        image = expose(Renderer(scene, robot.camera, mount).ideal(Pose2()), robot.camera, sensor, rng)
        view = find_board(image, BOARD)
        if view is not None:
            views.append(replace(view, source=f"frame {len(views)}"))
    return views


def _hand_pose(world: np.ndarray, camera: CameraModel, rng: np.random.Generator) -> CameraMount:
    """Draw a camera pose that sees the whole board, as a mount on a robot at the origin."""
    middle, vector = world.mean(axis=0), intrinsics_vector(camera)
    while True:
        lean, turn = rng.uniform(0.0, math.pi / 4.0), rng.uniform(0.0, math.tau)
        tilt = rotation_from_vector(lean * np.array([0.0, math.cos(turn), math.sin(turn)]))
        roll = rotation_from_vector(np.array([rng.normal(0.0, math.radians(10.0)), 0.0, 0.0]))
        rotation = tilt @ roll @ BASE_FROM_OPTICAL
        aim = np.append(unproject(vector, rng.uniform([20, 20], [620, 460])[None])[0], 1.0)
        distance = rng.uniform(0.18, 0.6)
        position = middle - rotation @ (aim / np.linalg.norm(aim) * distance)
        seen = (world - position) @ rotation
        if np.all(seen[:, 2] > 0.05) and np.all(np.linalg.norm(seen[:, :2] / seen[:, 2:], axis=1) < 1.6):
            image = project(vector, seen)
            if np.all((image > 12.0) & (image < np.array(SIZE) - 13.0)):
                return mount_from_pose(rotation, position)


def figures(views: list[BoardView], robot: RobotSpec, *, static: bool) -> dict[str, object]:
    """Return what solving the views gives against the truth."""
    begun = time.perf_counter()
    free = calibrate(views, BOARD, SIZE, is_duckiebot=True)
    row: dict[str, object] = {
        "views": free.views_used,
        "per_board": list(free.views_per_board),
        "dropped": len(free.views_dropped),
        "coefficients": 4 if free.camera.distortion[4] == 0.0 else 5,
        "model": free.camera.model,
        "noise_px": free.noise_px,
        "rms_px": free.rms_px,
        "free_px": projection_difference(robot.camera, free.camera).rms,
        "free_predicted_px": free.predicted_px,
        "refused": free.reason,
    }
    if static:
        found = calibrate_static(views, frames_of(views), BOARD, free)
        row |= {
            "static_px": projection_difference(robot.camera, found.calibration.camera).rms,
            "static_predicted_px": found.calibration.predicted_px,
            "is_static": found.is_static,
            "sentence": found.sentence,
            "pitch_error_deg": math.degrees(found.pitch - robot.mount.pitch),
            "roll_error_deg": math.degrees(found.roll - robot.mount.roll),
            "height_error_m": found.height - robot.mount.height,
        }
    return row | {"solve_s": time.perf_counter() - begun}


def run(seed: int, layout: str) -> dict[str, object]:
    """Return the figures of one robot: its whole scan, the scan that stops by information, 30 hand-held views."""
    rng = np.random.default_rng([seed, 5])
    robot = draw_robot(rng, f"robot{seed}")
    begun = time.perf_counter()
    views = scan(robot, LAYOUTS[layout], rng)
    scanned = time.perf_counter()
    kept, stopped = informed(views, len(LAYOUTS[layout]))
    chosen = time.perf_counter()
    held = hand_held(robot, 30, rng)
    return {
        "seed": seed,
        "layout": layout,
        "scan": figures(views, robot, static=True),
        "stopped": figures(kept, robot, static=True) | {"reached": stopped},
        "hand": figures(held, robot, static=False),
        "seconds": [scanned - begun, chosen - scanned, time.perf_counter() - chosen],
    }


def table(rows: list[dict]) -> str:
    """Return the figures of all runs as text."""
    lines = [f"{len(rows)} runs, layout {rows[0]['layout']}: error against truth over the image, px"]
    lines.append(f"{'':34} median    95 %     max  ahead of hand  log-corr  within 2.5 x predicted")
    hand = np.array([row["hand"]["free_px"] for row in rows])
    series = (
        ("whole scan, static boards", "scan", "static"),
        ("whole scan, free boards", "scan", "free"),
        ("stopped by information, static", "stopped", "static"),
        ("stopped by information, free", "stopped", "free"),
        ("30 hand-held views", "hand", "free"),
    )
    for label, part, kind in series:
        true = np.array([row[part][f"{kind}_px"] for row in rows])
        predicted = np.array([row[part][f"{kind}_predicted_px"] for row in rows])
        correlation = np.corrcoef(np.log(true), np.log(predicted))[0, 1] if len(rows) > 2 else math.nan
        within = np.mean(true <= 2.5 * predicted)
        lines.append(
            f"{label:34} {np.median(true):6.3f}  {np.percentile(true, 95):6.3f}  {true.max():6.3f}"
            f"  {np.mean(true < hand):8.0%}       {correlation:5.2f}     {within:.0%}"
        )
    views = [np.median([row[part]["views"] for row in rows]) for part in ("scan", "stopped")]
    noise = np.median([row["scan"]["noise_px"] for row in rows])
    kept = np.mean([row["scan"]["is_static"] for row in rows])
    lines.append(
        f"views: {views[0]:.0f} whole, {views[1]:.0f} stopped; corner noise {noise:.3f} px; static in {kept:.0%}"
    )
    for name in ("pitch_error_deg", "roll_error_deg", "height_error_m"):
        values = np.abs([row["scan"][name] for row in rows])
        lines.append(f"|{name}| median {np.nanmedian(values):.4f}, 95 % {np.nanpercentile(values, 95):.4f}")
    return "\n".join(lines)


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--layout", choices=sorted(LAYOUTS), default="mixed3")
    parser.add_argument("--out", type=Path, default=Path("out/camera_scan.jsonl"))
    parser.add_argument("--table", action="store_true", help="print what is there, run nothing")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    lines = options.out.read_text().splitlines() if options.out.exists() else []
    rows = [row for row in map(json.loads, lines) if row["layout"] == options.layout]
    done = {row["seed"] for row in rows}
    for seed in range(0 if options.table else options.runs):
        if seed not in done:
            rows.append(run(seed, options.layout))
            with options.out.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
