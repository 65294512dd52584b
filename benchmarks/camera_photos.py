"""What the camera tool makes of real photos: two chessboard sets, a Duckiebot's floor board, a turned tag.

    python benchmarks/camera_photos.py

Photos are found below the folder to which the environment variable FSM_CALIB_SHARED points (../shared).
"""

import math
import os
import sys
import time
from pathlib import Path

import cv2
import numpy as np

from fsm_calib.commands.extrinsics import extrinsics_text
from fsm_calib.perception.camera_files import read_intrinsics, read_projection
from fsm_calib.perception.extrinsics import FLOOR_BOARD_OFFSET, calibrate_extrinsics
from fsm_calib.perception.ground import tag_poses
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.photos import find_in_photos, read_photo
from fsm_calib.perception.tags import find_tags
from fsm_calib.types import BoardSpec, CameraModel

PHOTOS = Path(os.environ.get("FSM_CALIB_SHARED", "../shared")) / "photos"
TTIC = Path(__file__).with_name("ttic_camera.yaml")
TAG_SIZE = 0.065  # m
TAG_CAMERA = CameraModel(  # test_info.yaml beside the photos, which are rectified
    np.array([[329.873, 0.0, 528.0], [0.0, 332.946, 396.0], [0.0, 0.0, 1.0]]),
    np.zeros(5),
    1056,
    792,
    "plumb_bob",
)


def chessboards(folder: str, pattern: str, board: BoardSpec) -> None:
    """Print how a set of photos of a board is solved."""
    paths = sorted((PHOTOS / folder).glob(pattern))
    begun = time.perf_counter()
    found = find_in_photos(paths, board)
    result = calibrate(found.views, board, found.image_size)
    seconds = time.perf_counter() - begun
    print(
        f"{folder}: {len(found.views)} of {len(paths)} boards, rms {result.rms_px:.3f} px, views left out "
        f"{result.cross_validated_px:.3f} px, predicted {result.predicted_px:.2f} px, {result.camera.model}, "
        f"k3 = {result.camera.distortion[4]:.3f}, {seconds:.2f} s"
    )
    for model in result.models:
        print(
            f"    {model.coefficients} coefficients: left out {model.cross_validated_px:.3f} px, {model.verdict}"
        )


def floor_board() -> None:
    """Print the mount that one photo of a board on the floor gives."""
    image = read_photo(PHOTOS / "duckiebot-extrinsic" / "ttic_board.jpg")
    board, camera, projection = BoardSpec(7, 5, 0.031), read_intrinsics(TTIC), read_projection(TTIC)
    found = calibrate_extrinsics(image, board, camera, FLOOR_BOARD_OFFSET, projection)
    print("ttic_board (by hand: the principal point 0.40 m ahead)")
    print("    " + extrinsics_text(found, camera, projection).replace("\n", "\n    "))


def turned_tag() -> None:
    """Print a tag's turn about its vertical against the label of each photo."""
    labels, turns = [], []
    for label in range(-70, 80, 10):
        gray = read_photo(PHOTOS / "apriltag-duckietown" / f"test_image_rotation_{label}.png")
        tags = find_tags(gray)
        if not tags:
            print(f"    {label:4d} deg: no tag found")
            continue
        outward = tag_poses(tags[0], TAG_CAMERA, TAG_SIZE)[0].rotation[:, 2]
        labels.append(label)
        turns.append(math.degrees(math.atan2(outward[0], -outward[2])))
    errors = np.array(turns) - labels
    errors -= (errors.max() + errors.min()) / 2.0
    print(f"apriltag turns: {len(labels)} of 15 found, {min(labels)} to {max(labels)} deg")
    print(
        f"    off the label, up to one constant: at most {np.abs(errors).max():.1f} deg; {errors.round(1).tolist()}"
    )


def main() -> None:
    """Print all figures."""
    if not PHOTOS.is_dir():
        sys.exit(f"no photos at {PHOTOS}: set FSM_CALIB_SHARED")
    cv2.setNumThreads(1)
    chessboards("opencv-left", "*.jpg", BoardSpec(9, 6, 0.025))
    chessboards("gopro-wide-chessboard", "GOPR*.jpg", BoardSpec(8, 6, 0.025))
    floor_board()
    turned_tag()


if __name__ == "__main__":
    main()
