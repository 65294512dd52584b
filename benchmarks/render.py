"""What a frame costs against what the robot does to find the boards or the markers in it, in one process on one core.

    python benchmarks/render.py

Prints CPU times (median of 15) of drawing and of exposing a frame, and of the search that the robot makes in that
frame: `find_boards` in the scan, `find_tags` elsewhere; their ratio is judged (bar: at most 1). For comparison
`find_board`, which stops at the first board, and OpenCV's search for one board without any refinement. Then the error
of the corners found in rendered frames.
"""

import math
import time

import cv2
import numpy as np

from fsm_calib.perception.chessboard import find_board, find_boards, inspect_board
from fsm_calib.perception.tags import find_tags
from fsm_calib.types import BoardSpec, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer, render
from fsm_calib.world2d.fleet import nominal_camera
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.lens import camera_pose
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

PLACES = {
    "boards, flat ahead": Pose2(),
    "boards, turned left": Pose2(theta=0.8),
    "boards, turned right": Pose2(theta=-0.8),
    "marker field": Pose2(-0.05, 0.02, math.pi),
    "marked lane": Pose2(-1.87, 0.7, math.pi / 2),
}
REPEATS = 15


def milliseconds(work):
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - begin))
    return float(np.median(times))


def costs():
    scene = build_scene(calibration_area(), np.random.default_rng(0))
    camera, settings, board = nominal_camera(), SensorSettings(), BoardSpec()
    renderer = Renderer(scene, camera, CameraMount(height=0.113))
    print(
        f"{'view':22} {'draw':>6} {'expose':>7} {'search':>7} {'ratio':>6}   {'one board':>9} {'OpenCV':>7}   [ms]"
    )
    for name, pose in PLACES.items():
        light = renderer.ideal(pose)
        image = expose(light, camera, settings, np.random.default_rng(0))
        draw = milliseconds(lambda pose=pose: renderer._draw(pose))
        shoot = milliseconds(lambda light=light: expose(light, camera, settings, np.random.default_rng(0)))
        if "boards" in name:
            search = milliseconds(lambda image=image: find_boards(image, board))
            one = milliseconds(lambda image=image: find_board(image, board))
            plain = milliseconds(
                lambda image=image: cv2.findChessboardCorners(image, (board.columns, board.rows))
            )
            others = f"   {one:9.1f} {plain:7.1f}"
        else:
            search, others = milliseconds(lambda image=image: find_tags(image)), ""
        ratio = (draw + shoot) / search
        print(f"{name:22} {draw:6.1f} {shoot:7.1f} {search:7.1f} {ratio:6.2f}{others}")


def corner_error(distance, lean, seed):
    placement = BoardPlacement(x=distance, yaw=math.pi + 0.3, lean=lean)
    camera, mount, rng = nominal_camera(), CameraMount(height=0.113), np.random.default_rng(seed)
    image = render(
        build_scene(SceneSpec(boards=(placement,)), rng), camera, mount, [Pose2()], SensorSettings(), rng
    )
    rotation, position = camera_pose(Pose2(), mount)
    rvec, _ = cv2.Rodrigues(rotation.T)
    truth, _ = cv2.projectPoints(
        board_points_world(placement), rvec, -rotation.T @ position, camera.matrix, camera.distortion
    )
    view = inspect_board(image, placement.board).view
    if view is None:
        return math.nan
    truth = truth.reshape(-1, 2)
    errors = [corners - truth for corners in (view.corners_image, view.corners_image[::-1])]
    return min(math.sqrt(float(np.mean(np.sum(error**2, axis=1)))) for error in errors)


def accuracy():
    print("corners found against projectPoints of the truth, rms px over 8 noise seeds (largest):")
    for distance, lean in ((0.36, 90.0), (0.5, 0.0), (0.5, 30.0), (0.7, 0.0), (0.9, 15.0), (1.1, 0.0)):
        every = [corner_error(distance, math.radians(lean), seed) for seed in range(8)]
        rms = [error for error in every if math.isfinite(error)]
        mean = math.sqrt(float(np.mean(np.square(rms))))
        print(
            f"  {distance:.2f} m, leaned {lean:2.0f} deg: {mean:.3f} ({max(rms):.3f}), found in {len(rms)} of 8"
        )


if __name__ == "__main__":
    cv2.setNumThreads(1)
    costs()
    accuracy()
