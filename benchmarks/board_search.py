"""How often a board that the detector sees is lost on the way to its corners, and how far corners are from the truth.

    python benchmarks/board_search.py [--robots 150]

Robots of the fleet look at the drawing's boards from random places around the start, 14 frames each. Counted are the
frames in which OpenCV's detector reports a whole board: those whose corners the first search refines, those that the
second search saves (it begins from corners that their neighbours agree with), and those that stay lost; with the largest
error of a corner against the projection of the truth.

With --looks counted are, over the first three frames of each robot, the flat board before it: by one threshold, by
adaptive thresholds, by either, and refined.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter, defaultdict

import cv2
import numpy as np

from fsm_calib.perception import chessboard
from fsm_calib.types import BoardSpec, FloatArray, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import draw_robot
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.lens import camera_pose
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

FRAMES = 14
LOOKS = 3
"""Frames of a robot that has just been placed."""
BOARD, SETTINGS = BoardSpec(), chessboard.DEFAULT_DETECTOR
WRONG_PX = 1.0
"""A corner farther than this from the truth is wrong."""
NEAREST = 0.05
"""Boards that come nearer to the lens are not compared [m]."""


def true_corners(renderer: Renderer, placements, pose: Pose2) -> list[FloatArray]:
    """Return the corners of the boards before the camera, each of shape (35, 2) [px]."""
    rotation, position = camera_pose(pose, renderer.mount)
    turn, _ = cv2.Rodrigues(rotation.T)
    found = []
    for placement in placements:
        points = board_points_world(placement)
        if ((points - position) @ rotation)[:, 2].min() > NEAREST:
            camera = renderer.camera
            image, _ = cv2.projectPoints(
                points, turn, -rotation.T @ position, camera.matrix, camera.distortion
            )
            found.append(image.reshape(-1, 2))
    return found


def largest_error(corners: FloatArray, truth: list[FloatArray]) -> float:
    """Return the largest distance from the board that fits best, in either order of its corners [px]."""
    ways = [np.linalg.norm(corners - board[::way], axis=1).max() for board in truth for way in (1, -1)]
    return float(min(ways, default=math.nan))


def search(gray) -> tuple[str, FloatArray | None]:
    """Return by which search the first board of a frame is found, and its corners; "none" where none is seen."""
    rough = chessboard._rough_corners(gray, BOARD, chessboard._TWO_LOOKS, SETTINGS)
    if rough is None:
        return "none", None
    corners = chessboard._refined_from(gray, rough, BOARD, SETTINGS)
    if corners is not None:
        return "first", corners
    corners = chessboard._refined(gray, rough, BOARD, SETTINGS)
    return ("lost" if corners is None else "second"), corners


def first_looks(robots: int) -> None:
    """Print in how many of the first frames each way to look finds the flat board that the robot stands before."""
    area, rng = calibration_area(), np.random.default_rng(0)
    scene = build_scene(area, rng)
    found: Counter[str] = Counter()
    for _ in range(robots):
        robot = draw_robot(rng)
        renderer = Renderer(scene, robot.camera, robot.mount)
        for _ in range(LOOKS):
            light = renderer.ideal(Pose2())
            gray = chessboard.as_gray(expose(light, robot.camera, SensorSettings(defocus=robot.defocus), rng))
            ways = [
                chessboard._rough_corners(gray, BOARD, (way,), SETTINGS) is not None
                for way in chessboard._TWO_LOOKS
            ]
            found.update({"one threshold": ways[0], "adaptive thresholds": ways[1], "either": any(ways)})
            found["with its corners"] += chessboard.find_board(gray, BOARD) is not None
    print(f"the flat board in {LOOKS * robots} first frames: {dict(found)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=150)
    parser.add_argument("--looks", action="store_true", help="the first looks at the flat board instead")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if options.looks:
        first_looks(options.robots)
        return
    area, rng = calibration_area(), np.random.default_rng(0)
    scene = build_scene(area, rng)
    errors: defaultdict[str, list[float]] = defaultdict(list)
    for _ in range(options.robots):
        robot = draw_robot(rng)
        renderer = Renderer(scene, robot.camera, robot.mount)
        sensor = SensorSettings(defocus=robot.defocus)
        for _ in range(FRAMES):
            pose = Pose2(*rng.uniform((-0.08, -0.08, -1.3), (0.08, 0.08, 1.3)))
            gray = chessboard.as_gray(expose(renderer.ideal(pose), robot.camera, sensor, rng))
            how, corners = search(gray)
            truth = true_corners(renderer, area.boards, pose)
            errors[how].append(math.nan if corners is None else largest_error(corners, truth))
    print(f"{sum(len(errors[how]) for how in ('first', 'second', 'lost'))} boards seen by the detector")
    for how in ("first", "second"):
        wrong = sum(error > WRONG_PX for error in errors[how])
        print(f"corners found by the {how} search: {len(errors[how])}, of them {wrong} with a wrong corner")
    print(f"lost: {len(errors['lost'])}")


if __name__ == "__main__":
    main()
