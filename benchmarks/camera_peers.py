"""The tutorial's pipeline, OpenCV with fixed lens models, mrcal and `calibrate` on the same photos, in one run.

    python benchmarks/camera_peers.py [--json FILE]

Photos are found below the folder to which the environment variable FSM_CALIB_SHARED points (../shared). mrcal runs
in whichever Python has it (--mrcal, by default /usr/bin/python3, where Debian installs it); its rows are left out
with a note where it is missing. Distances are root mean squares over corners [px]; a view left out keeps the lens of
the others and gets its own pose. Time is the processor's, for the solve: without cross-validation for the peers, with
it for fsm_calib, which needs it to choose.
"""

import argparse
import json
import os
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np

from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.photos import find_in_photos, read_photo
from fsm_calib.types import BoardSpec

PHOTOS = Path(os.environ.get("FSM_CALIB_SHARED", "../shared")) / "photos"
SETS = {
    "opencv-left, 9x6": (sorted((PHOTOS / "opencv-left").glob("*.jpg")), BoardSpec(9, 6, 0.025)),
    "gopro-wide, 8x6": (
        sorted((PHOTOS / "gopro-wide-chessboard").glob("GOPR*.jpg")),
        BoardSpec(8, 6, 0.025),
    ),
}
#: flags of `cv2.calibrateCamera` for so many distortion coefficients
MODELS = {
    4: cv2.CALIB_FIX_K3,
    5: 0,
    8: cv2.CALIB_RATIONAL_MODEL,
    12: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
}
COEFFICIENTS = {8: 4, 9: 5, 12: 8}  # by intrinsics freed
TUTORIAL_WINDOW = (11, 11)
TUTORIAL_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.001)


@dataclass(frozen=True)
class Row:
    """One calibration: photos used, rms, rms on views left out, predicted error over the image [px], time [s]."""

    photos: str
    pipeline: str
    views: int
    rms_px: float
    cross_validated_px: float
    predicted_px: float | None
    seconds: float


def tutorial_corners(paths: Sequence[Path], board: BoardSpec) -> np.ndarray:
    """Return corners as OpenCV's tutorial finds them, shape (views, corners, 2) [px]."""
    found = []
    for gray in map(read_photo, paths):
        seen, corners = cv2.findChessboardCorners(gray, (board.columns, board.rows), None)
        if seen:
            corners = cv2.cornerSubPix(gray, corners, TUTORIAL_WINDOW, (-1, -1), TUTORIAL_STOP)
            found.append(corners.reshape(-1, 2))
    return np.array(found, dtype=np.float32)


def opencv_fit(corners: np.ndarray, board: BoardSpec, size: tuple[int, int], flags: int) -> tuple:
    """Return rms [px], camera matrix and distortion of `cv2.calibrateCamera`."""
    points = [board.points_board().astype(np.float32)] * len(corners)
    return cv2.calibrateCamera(points, list(corners), size, None, None, flags=flags)[:3]


def left_out_error(
    corners: np.ndarray, view: int, board: BoardSpec, size: tuple[int, int], flags: int
) -> float:
    """Return the mean squared corner distance of one view under the lens of the others [px^2]."""
    _, matrix, distortion = opencv_fit(np.delete(corners, view, axis=0), board, size, flags)
    points = board.points_board()
    _, turn, shift = cv2.solvePnP(points, corners[view], matrix, distortion)
    turn, shift = cv2.solvePnPRefineLM(points, corners[view], matrix, distortion, turn, shift)
    predicted = cv2.projectPoints(points, turn, shift, matrix, distortion)[0][:, 0]
    return float(np.mean(np.sum((predicted - corners[view]) ** 2, axis=1)))


def opencv_row(
    photos: str, pipeline: str, corners: np.ndarray, board: BoardSpec, size: tuple[int, int], flags: int
) -> Row:
    """Return the figures of `cv2.calibrateCamera`; it predicts no error over the image."""
    begun = time.process_time()
    rms = float(opencv_fit(corners, board, size, flags)[0])
    seconds = time.process_time() - begun
    left_out = [left_out_error(corners, view, board, size, flags) for view in range(len(corners))]
    return Row(photos, pipeline, len(corners), rms, float(np.sqrt(np.mean(left_out))), None, seconds)


def mrcal_row(
    photos: str, coefficients: int, corners: np.ndarray, board: BoardSpec, size: tuple[int, int], python: str
) -> Row | None:
    """Return mrcal's figures, None where it is missing."""
    task = {
        "corners": corners.reshape(len(corners), board.rows, board.columns, 2).tolist(),
        "size": size,
        "square": board.square,
        "model": f"LENSMODEL_OPENCV{coefficients}",
    }
    script = [python, str(Path(__file__).with_name("camera_mrcal.py"))]
    try:
        done = subprocess.run(script, input=json.dumps(task), capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    found = json.loads(done.stdout)
    pipeline = f"mrcal, {coefficients} coefficients, board warp, {found['outliers']} corners left out"
    figures = (found[name] for name in ("rms_px", "cross_validated_px", "predicted_px", "seconds"))
    return Row(photos, pipeline, len(corners), *figures)


def rows_of(photos: str, paths: Sequence[Path], board: BoardSpec, python: str) -> list[Row]:
    """Return every pipeline's figures on one set of photos."""
    begun = time.process_time()
    found = find_in_photos(paths, board)
    detected = time.process_time() - begun
    size = found.image_size
    begun = time.process_time()
    ours = calibrate(found.views, board, size)
    seconds = time.process_time() - begun
    own = np.array([view.corners_image for view in found.views], dtype=np.float32)
    print(f"{photos}: {len(own)} of {len(paths)} boards found in {detected:.2f} s of CPU", flush=True)
    rows = [
        opencv_row(photos, "tutorial: window 11, 5", tutorial_corners(paths, board), board, size, MODELS[5])
    ]
    rows += [
        opencv_row(photos, f"OpenCV on our corners, {count}", own, board, size, flags)
        for count, flags in MODELS.items()
    ]
    freed = int(np.count_nonzero(np.diag(ours.covariance)))
    pipeline = f"fsm_calib, {COEFFICIENTS[freed]} chosen of 4, 5, 8"
    figures = (ours.rms_px, ours.cross_validated_px, ours.predicted_map.expected, seconds)
    rows.append(Row(photos, pipeline, ours.views_used, *figures))
    peers = [mrcal_row(photos, count, own, board, size, python) for count in (4, 5, 8)]
    return rows + [row for row in peers if row is not None]


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a Markdown table."""
    lines = [
        "| photos | pipeline, distortion coefficients | views | rms | views left out | predicted | CPU s |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        predicted = "-" if row.predicted_px is None else f"{row.predicted_px:.2f}"
        lines.append(
            f"| {row.photos} | {row.pipeline} | {row.views} | {row.rms_px:.3f} | {row.cross_validated_px:.3f} "
            f"| {predicted} | {row.seconds:.2f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Run every pipeline on every set of photos."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mrcal", default="/usr/bin/python3", help="the Python that has mrcal")
    parser.add_argument("--json", type=Path, help="write the rows as JSON")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    rows = [
        row for name, (paths, board) in SETS.items() for row in rows_of(name, paths, board, options.mrcal)
    ]
    print(table(rows))
    if not any(row.pipeline.startswith("mrcal") for row in rows):
        print(f"mrcal is not installed for {options.mrcal}: its rows are left out")
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
