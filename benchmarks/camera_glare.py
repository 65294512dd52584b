"""What glare does to a camera's calibration: what is left of the bias of bent edges, and true against predicted error.

    python benchmarks/camera_glare.py --runs 24

Each robot scans the same boards in plain light and in glare (all light doubled, so that white runs over). For either: the
share of the bias of bent edges that its removal leaves in the corners (fitted to their true errors; 0 is right), the
noise of corners, and the true error over the expected one, over the whole image, and how often it is within the predicted.
"""

import argparse
from dataclasses import replace

import cv2
import numpy as np
from camera_runs import BOARD, LAYOUTS, SIZE, Labels, scan_poses

from fsm_calib.perception.chessboard import find_boards, half_windows
from fsm_calib.perception.corner_bias import expected_bias
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.perception.static_boards import calibrate_scan
from fsm_calib.types import BoardView, Pose2
from fsm_calib.world2d.camera import Renderer, camera_pose
from fsm_calib.world2d.fleet import RobotSpec, draw_robot
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

LIGHTS = {"plain": 1.0, "glare": 2.0}
EVERY = 2  # stops of the scan that are looked from: each second one


def true_corners(
    robot: RobotSpec, boards: tuple[BoardPlacement, ...], pose: Pose2, view: BoardView
) -> np.ndarray:
    """Return where the corners of the board that is nearest to a view truly are, in its order [px]."""
    rotation, position = camera_pose(pose, robot.mount)
    seen = [(board_points_world(board) - position) @ rotation for board in boards]
    images = [
        project(intrinsics_vector(robot.camera), points) for points in seen if np.all(points[:, 2] > 0.05)
    ]
    every = [corners for image in images for corners in (image, image[::-1])]
    return min(every, key=lambda corners: float(np.abs(corners - view.corners_image).mean()))


def looked(seed: int, light: float) -> dict[str, float]:
    """Return what one robot's scan gives in one light."""
    rng, boards = np.random.default_rng([seed, 5]), LAYOUTS["mixed3"]
    robot = draw_robot(rng, f"robot{seed}")
    renderer = Renderer(build_scene(SceneSpec(boards=boards), rng), robot.camera, robot.mount)
    sensor, labels = SensorSettings(defocus=robot.defocus, brightness=light), Labels(boards)
    views: list[BoardView] = []
    bias, errors = [], []
    for index, pose in enumerate(list(scan_poses(robot.axle_length, rng))[::EVERY]):
        for view in find_boards(expose(renderer.ideal(pose), robot.camera, sensor, rng), BOARD):
            views.append(replace(view, board=labels.number(view, pose.theta), source=f"frame {index}"))
            true = true_corners(robot, boards, pose, view)
            bias.append(expected_bias(true, half_windows(true, BOARD), BOARD))
            errors.append(view.corners_image - true)
    found = calibrate_scan(views, BOARD, SIZE).calibration
    near = np.abs(errors) < 5.0 * found.noise_px
    return {
        "left": float(np.sum(np.multiply(bias, errors) * near) / np.sum(np.square(bias) * near)),
        "noise": found.noise_px,
        "true": projection_difference(robot.camera, found.camera).rms,
        "expected": found.predicted_map.expected,
        "predicted": found.predicted_px,
    }


def main() -> None:
    """Print a row for each light."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=24)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    print(
        "| light | robots | bias left: mean, sd | noise px | true px: median, largest | expected, predicted px | true / expected "
        "| within the predicted |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, light in LIGHTS.items():
        rows = [looked(seed, light) for seed in range(options.runs)]
        left, noise, true, expected, predicted = (np.array([row[key] for row in rows]) for key in rows[0])
        ratio = true / expected
        print(
            f"| {name} | {len(rows)} | {left.mean():+.2f}, {left.std():.2f} | {np.median(noise):.3f} "
            f"| {np.median(true):.3f}, {true.max():.3f} | {np.median(expected):.3f}, {np.median(predicted):.3f} "
            f"| median {np.median(ratio):.2f}, largest {ratio.max():.2f} | {np.mean(true <= predicted):.0%} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
