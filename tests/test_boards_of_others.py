"""Boards that the programs of others draw, photographed by a camera with a known lens, through the command line.

`FSM_CALIB_KALIBR` and `FSM_CALIB_OPENCV` name checkouts of Kalibr and OpenCV: their generators of targets draw the
boards, and OpenCV's own sample solves the same photos. Nothing of them is here; without them, the tests
are skipped.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import needs_browser, picture_of
from camera_views import SIZE, TRUTH
from test_perception_photos import photos
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.perception.grid_boards import BoardRequest
from fsm_calib.perception.lens import project, unproject
from fsm_calib.perception.rotations import rotation_from_vector

KALIBR = ("FSM_CALIB_KALIBR", "aslam_offline_calibration/kalibr/python/kalibr_create_target_pdf")
GENERATOR = ("FSM_CALIB_OPENCV", "doc/pattern_tools/gen_pattern.py")
SAMPLE = ("FSM_CALIB_OPENCV", "samples/python/calibrate.py")
PX_PER_M = 3000.0
"""Of a page that is drawn: finer than any photo of it."""
FINE = 3
"""Rays along a pixel's side, and pixels of a page's raster along one that is kept."""
PHOTOS = 14
BLUR = 0.5  # px
NOISE = 2.0  # of 255
POINTS_PER_M = 72.0 / 0.0254
"""PDF's unit of length."""
OFF = 0.15
"""A point's typical distance from where it was drawn may be so much [px]."""


@dataclass(frozen=True)
class Drawn:
    """A page with a board: pixels, where the board's first point lies in it [px], and what was asked for."""

    page: np.ndarray
    first: np.ndarray
    asked: BoardRequest


def program(variable: str, path: str) -> Path:
    """Return a program of a checkout that a variable names; skip the test where none does."""
    if variable not in os.environ:
        pytest.skip(f"{variable} names no checkout with {path} (docs/camera.md)")
    return Path(os.environ[variable]) / path


def ran(*command: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a program of others in a folder."""
    words = [sys.executable, *map(str, command)]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def drawn_by_kalibr(folder: Path, asked: BoardRequest) -> Drawn:
    """Run Kalibr's generator; its page begins at the lower left corner, and keeps its own coordinates."""
    pytest.importorskip("pyx", reason="Kalibr's generator needs pyx")
    pdfium = pytest.importorskip("pypdfium2", reason="pypdfium2 renders PDF; it comes with the extra dev")
    if shutil.which("tex") is None:
        pytest.skip("Kalibr's generator writes its caption with TeX (Debian: apt-get install texlive-base)")
    path, side = program(*KALIBR), str(asked.square)
    sizes = {
        "aprilgrid": ("--type", "apriltag", "--tsize", side, "--tspace", asked.gap),
        "chessboard": ("--type", "checkerboard", "--csx", side, "--csy", side),
    }[asked.kind]
    done = ran(path, "board", *sizes, "--nx", asked.columns, "--ny", asked.rows, folder=folder)
    assert done.returncode == 0, done.stderr
    document = pdfium.PdfDocument(folder / "board.pdf")
    scale = PX_PER_M / POINTS_PER_M
    raster = document[0].render(scale=FINE * scale, grayscale=True).to_numpy().squeeze()
    left, _, _, top = document[0].get_mediabox()
    document.close()
    rest = [(0, -length % FINE) for length in raster.shape]
    whole = np.pad(raster, rest, constant_values=255)
    page = whole.reshape(whole.shape[0] // FINE, FINE, -1, FINE).mean(axis=(1, 3)).astype(np.uint8)
    if asked.kind == "aprilgrid":
        corner = np.array([0.0, asked.square * (asked.rows + (asked.rows - 1) * asked.gap)])
    else:
        corner = asked.square * np.array([1.0, asked.rows])
    first = (corner * POINTS_PER_M - [left, top]) * [scale, -scale]
    return Drawn(page, first - 0.5, asked)


PAGE = np.array([0.297, 0.210])
"""A4, lying [m]."""
OPENCV_TYPES = {
    "chessboard": "checkerboard", "circles": "circles", "asymmetric_circles": "acircles", "charuco": "charuco_board",
}  # fmt: skip


def drawn_by_opencv(folder: Path, asked: BoardRequest) -> Drawn:
    """Run OpenCV's generator, which puts the board into the middle of a page."""
    path = program(*GENERATOR)
    columns, rows = np.array([asked.columns, asked.rows]) + (1 if asked.kind == "chessboard" else 0)
    command = ["-T", OPENCV_TYPES[asked.kind], "-o", "board.svg", "-u", "mm", "-c", columns, "-r", rows]
    command += ["-s", 1000.0 * asked.square, "-w", 1000.0 * PAGE[0], "-h", 1000.0 * PAGE[1]]
    if asked.kind == "charuco":
        command += ["-p", 750.0 * asked.square, "-f", path.parent / f"{asked.dictionary}.json"]
    done = ran(path, *command, folder=folder)
    assert done.returncode == 0, done.stderr
    size = np.round(PAGE * PX_PER_M).astype(int)
    page = picture_of(folder / "board.svg", *size.tolist(), folder)
    points = asked.spec().points_board()[:, :2]
    return Drawn(page, PX_PER_M * (PAGE - np.ptp(points, axis=0)) / 2.0 - 0.5, asked)


@cache
def all_rays() -> np.ndarray:
    """Return the rays of the camera's pixels, `FINE` x `FINE` in each, shape (height, width, 3) [1]."""
    within = np.arange(FINE) / FINE - (FINE - 1) / (2.0 * FINE)
    columns, rows = (np.add.outer(np.arange(size), within).ravel() for size in SIZE)
    rays = unproject(TRUTH, np.stack(np.meshgrid(columns, rows), axis=-1))
    return np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1)


def photographed(drawn: Drawn, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a photo of a page by the camera of `TRUTH`, and where the board's points are in it [px]."""
    rng = np.random.default_rng(seed)
    board = drawn.asked.spec().points_board()
    turn = rotation_from_vector(rng.uniform(-0.5, 0.5, 3))
    middle = turn @ board.mean(axis=0)
    place = np.array([*rng.uniform(-0.06, 0.06, 2), rng.uniform(0.22, 0.36)]) - middle
    rays = all_rays() @ turn
    origin = place @ turn
    on_board = rays[..., :2] * (origin[2] / rays[..., 2:]) - origin[:2]
    at = (on_board * PX_PER_M + drawn.first).astype(np.float32)
    fine = cv2.remap(drawn.page, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderValue=255.0)
    photo = cv2.resize(cv2.GaussianBlur(fine, (0, 0), BLUR * FINE), SIZE, interpolation=cv2.INTER_AREA)
    noisy = photo + rng.normal(size=photo.shape) * NOISE
    return np.clip(noisy, 0, 255).astype(np.uint8), project(TRUTH, board @ turn.T + place)


def photos_of(drawn: Drawn, folder: Path) -> list[Path]:
    """Write photos of a page; return their files."""
    files = [folder / f"photo{seed:02}.png" for seed in range(PHOTOS)]
    for seed, file in enumerate(files):
        cv2.imwrite(str(file), photographed(drawn, seed)[0])
    return files


def calibrated(files: list[Path], asked: BoardRequest) -> dict:
    """Return what the command line tells of photos."""
    command = [
        "calibrate-camera",
        *map(str, files),
        "--kind",
        asked.kind,
        "--json",
        "-",
        "--gap",
        str(asked.gap),
    ]
    command += ["--board", f"{asked.columns}x{asked.rows}", "--square", str(asked.square)]
    done = CliRunner().invoke(app, [*command, "--dictionary", asked.dictionary])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


SAMPLE_TYPES = {"chessboard": "chessboard", "charuco": "charucoboard"}
RMS = re.compile(r"^RMS: ([\d.]+)", re.MULTILINE)


def rms_of_opencvs_sample(files: list[Path], asked: BoardRequest, folder: Path) -> float:
    """Run OpenCV's sample on photos; return the root mean square that it prints [px]."""
    options = ["-w", asked.columns, "-h", asked.rows, "-t", SAMPLE_TYPES[asked.kind], "--debug="]
    sizes = [f"--square_size={asked.square}", f"--marker_size={0.75 * asked.square}"]
    done = ran(program(*SAMPLE), *options, *sizes, f"--aruco_dict={asked.dictionary}", *files, folder=folder)
    told = RMS.search(
        done.stdout
    )  # where OpenCV has no windows, the sample ends in an error after its last line
    assert told is not None, done.stderr
    return float(told[1])


def is_found(drawn: Drawn, folder: Path) -> None:
    """Check that a board is found in all photos, its points where they were drawn, and gives the camera."""
    find, typical = drawn.asked.finder(), []
    for seed in range(3):
        photo, truth = photographed(drawn, seed)
        view = find(photo).view
        assert view is not None
        ways = [np.linalg.norm(view.corners_image - points, axis=1) for points in (truth, truth[::-1])]
        typical.append(min(np.nanmedian(off) for off in ways))  # a chessboard looks the same upside down
    told = calibrated(photos_of(drawn, folder), drawn.asked)
    found = f"{told['boards_found']} of {PHOTOS} found, rms {told['rms_px']:.3f} px"
    print(f"{drawn.asked.kind}: points {max(typical):.3f} px off, {found}, f {told['matrix'][0][0]:.2f} px")
    assert max(typical) < OFF
    assert told["boards_found"] == PHOTOS
    assert told["rms_px"] < OFF
    assert abs(told["matrix"][0][0] - TRUTH[0]) < 1.0
    assert abs(told["matrix"][1][2] - TRUTH[3]) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "asked",
    [BoardRequest("aprilgrid", 6, 6, 0.03), BoardRequest("chessboard", 7, 5, 0.03)],
    ids=lambda a: a.kind,
)
def test_targets_of_kalibrs_program_are_found(tmp_path, asked) -> None:
    is_found(drawn_by_kalibr(tmp_path, asked), tmp_path)


OPENCVS = [
    BoardRequest("chessboard", 8, 6, 0.025),
    BoardRequest("charuco", 8, 6, 0.03, dictionary="DICT_4X4_50"),
    BoardRequest("circles", 7, 5, 0.03),
    BoardRequest("asymmetric_circles", 4, 11, 0.018),
]


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("asked", OPENCVS, ids=lambda a: a.kind)
def test_targets_of_opencvs_program_are_found(tmp_path, asked) -> None:
    is_found(drawn_by_opencv(tmp_path, asked), tmp_path)


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("asked", OPENCVS[:2], ids=lambda a: a.kind)
def test_rms_is_as_good_as_that_of_opencvs_sample(tmp_path, asked) -> None:
    files = photos_of(drawn_by_opencv(tmp_path, asked), tmp_path)
    ours, theirs = calibrated(files, asked)["rms_px"], rms_of_opencvs_sample(files, asked, tmp_path)
    print(f"{asked.kind}: rms {ours:.4f} px, OpenCV's sample {theirs:.4f} px")
    assert ours <= 1.01 * theirs


@pytest.mark.parametrize(
    ("folder", "board"), [("opencv-left", (9, 6)), ("gopro-wide-chessboard", (8, 6))], ids=["left", "gopro"]
)
def test_rms_on_real_photos_is_better_than_that_of_opencvs_sample(tmp_path, folder, board) -> None:
    asked = BoardRequest("chessboard", *board, 0.025)
    files = photos(folder, "*.jpg")
    told, theirs = calibrated(files, asked), rms_of_opencvs_sample(files, asked, tmp_path)
    print(f"{folder}: rms {told['rms_px']:.3f} px, OpenCV's sample {theirs:.3f} px")
    assert told["rms_px"] < theirs
