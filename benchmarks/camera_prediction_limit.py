"""How well could any prediction of a camera's error correlate with the true one? The limit that chance sets.

    python benchmarks/camera_prediction_limit.py --runs 24

A prediction tells the size of an error that is drawn by chance, not the draw. So even one that is exactly right has
a log-correlation of at most

    r = s / sqrt(s^2 + c^2)

over N cameras, s the standard deviation of the logarithm of the predicted errors, c that of true errors about one
prediction: errors of the intrinsics are drawn from the solve's own covariance, and the error over the image is taken of
each. Robots, boards and rule are those of `camera_scan.py`.
"""

import argparse

import cv2
import numpy as np
from camera_runs import BOARD, LAYOUTS, SIZE, hand_held, scan
from camera_scan import RULES, informed

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import intrinsics_vector
from fsm_calib.perception.prediction import sensitivity
from fsm_calib.perception.static_boards import calibrate_static, frames_of
from fsm_calib.world2d.fleet import draw_robot

DRAWS = 2000
LAYOUT = "mixed3"


def chance(found: CameraCalibration, rng: np.random.Generator) -> float:
    """Return the standard deviation of log error over the image that the solve's covariance gives by chance."""
    motion = sensitivity(intrinsics_vector(found.camera), SIZE)
    errors = rng.multivariate_normal(np.zeros(12), found.covariance, DRAWS, check_valid="ignore") @ motion.T
    return float(np.std(np.log(np.linalg.norm(errors, axis=1))))


def cameras(seed: int) -> tuple[CameraCalibration, CameraCalibration]:
    """Return one robot's camera by the default rule (static boards) and from 30 hand-held views."""
    rng = np.random.default_rng([seed, 5])
    robot, boards = draw_robot(rng, f"robot{seed}"), LAYOUTS[LAYOUT]
    views, held = scan(robot, boards, rng), hand_held(robot, 30, rng)
    kept, _ = informed(views, len(boards), RULES["stopped"])
    free = calibrate(kept, BOARD, SIZE, is_duckiebot=True)
    static = calibrate_static(kept, frames_of(kept), BOARD, free).calibration
    return static, calibrate(held, BOARD, SIZE, is_duckiebot=True)


def main() -> None:
    """Solve the robots' cameras and print what chance leaves to a perfect prediction."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=24)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    rng = np.random.default_rng(0)
    found = [cameras(seed) for seed in range(options.runs)]
    print(
        "| cameras | predicted, sd of log | chance, sd of log | largest log-correlation |\n|---|---|---|---|"
    )
    for label, column in (
        ("robot's rule", [row[0] for row in found]),
        ("by hand", [row[1] for row in found]),
    ):
        spread = float(np.std(np.log([camera.predicted_map.expected for camera in column])))
        drawn = float(np.sqrt(np.mean([chance(camera, rng) ** 2 for camera in column])))
        print(
            f"| {label}, {len(column)} | {spread:.2f} | {drawn:.2f} | {spread / np.hypot(spread, drawn):.2f} |"
        )


if __name__ == "__main__":
    main()
