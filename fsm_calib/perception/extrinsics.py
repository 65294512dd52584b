"""Where the camera sits on the robot, from one image of a board flat on the floor, and the homography of the
floor.

Duckietown's board lies ahead of the robot with its rows across: the offset (x, y) [m] from the robot's origin
(centre of the axle on the floor) to the board's near right corner, the outer corner of its outermost square;
columns run along x, rows along y. The homography maps rectified pixels to the floor: (x, y, 1) ~ H (u, v, 1),
metres. Sources: duckietown/dt-core image_processing and lib-dt-computer-vision boards.py (offsets, origin);
the rule H[1][2] > 0 = corrupt from calibration_utils.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import DataError
from fsm_calib.perception.board_order import half_turned
from fsm_calib.perception.bundle import fit
from fsm_calib.perception.chessboard import inspect_board
from fsm_calib.perception.free_boards import FreeBoards, start_poses
from fsm_calib.perception.lens import intrinsics_vector, unproject
from fsm_calib.perception.rotations import base_from_camera, mount_from_pose, nearest_rotation
from fsm_calib.types import BoardSpec, BoardView, CameraModel, CameraMount, FloatArray

_LARGEST_RMS_PX = 3.0  # a board that fits worse is not flat, or the camera file is another camera's
FLOOR_BOARD_OFFSET = (0.16, -0.124)  # m; lib-dt-computer-vision boards.py, the A3 board of 8x6 squares


@dataclass(frozen=True, eq=False)
class Extrinsics:
    """The mount, the floor homography (3, 3) of rectified pixels, the fit's rms [px], and two points [m].

    mount comes from the pose of the board (six unknowns), homography from the corners directly (eight);
    axis_reach is where the homography sends the optical axis: the principal point of the rectified image.
    principal_point_reach is where it sends the pixel (cx, cy) of the raw image's matrix, taken in the rectified
    image: what Duckietown's software calls the principal point (camera/types.py and test_calibration.py of
    lib-dt-computer-vision). Both ahead of the axle; they are one where rectifying keeps the matrix.
    """

    mount: CameraMount
    homography: FloatArray
    rms_px: float
    axis_reach: float
    principal_point_reach: float


def board_points_base(board: BoardSpec, offset: tuple[float, float] = FLOOR_BOARD_OFFSET) -> FloatArray:
    """Return the inner corners of a floor board in `base`, shape (rows * columns, 3) [m].

    The first corner is the far left one; rows run to the right (-y), so that the robot reads the board
    upright.
    """
    points = board.points_board()
    near, right = offset[0] + board.square, offset[1] + board.square
    base = np.zeros_like(points)
    base[:, 0] = near + (board.rows - 1) * board.square - points[:, 1]
    base[:, 1] = right + (board.columns - 1) * board.square - points[:, 0]
    return base


def calibrate_extrinsics(
    image: NDArray[np.uint8],
    board: BoardSpec,
    camera: CameraModel,
    offset: tuple[float, float] = FLOOR_BOARD_OFFSET,
    projection: FloatArray | None = None,
) -> Extrinsics:
    """Return mount and floor homography from one image of a board flat on the floor.

    Parameters
    ----------
    image : array, uint8, grey or BGR, not rectified
    board : BoardSpec
        Columns across the robot, rows ahead of it.
    camera : CameraModel
    offset : (x, y) [m]
        Robot's origin to the board's near right corner.
    projection : array, shape (3, 3), optional
        Camera matrix of the rectified image (P of the camera file); the camera's own matrix when missing.

    Raises
    ------
    DataError
        No board in the image, or it does not fit a floor.
    """
    finding = inspect_board(image, board)
    if finding.view is None:
        raise DataError(
            finding.refusal, cure="Lay the board flat ahead of the robot, whole in the image and well lit."
        )
    return extrinsics_of(finding.view, board, camera, offset, projection)


def extrinsics_of(
    view: BoardView,
    board: BoardSpec,
    camera: CameraModel,
    offset: tuple[float, float] = FLOOR_BOARD_OFFSET,
    projection: FloatArray | None = None,
) -> Extrinsics:
    """Return mount and floor homography from the corners of a board flat on the floor; see
    `calibrate_extrinsics`.
    """
    ways = (view.corners_image, half_turned(view.corners_image))
    fits = [_fit(corners, board, camera, offset) for corners in ways]
    upright = [(mount, rms) for mount, rms in fits if mount.height > 0.0 and abs(mount.yaw) < np.pi / 2.0]
    if not upright or min(rms for _, rms in upright) > _LARGEST_RMS_PX:
        raise DataError(
            f"the board is not on the floor ahead (best fit {min(rms for _, rms in fits):.1f} px)",
            cure="Check the camera file, the board's size and its offset.",
        )
    mount, rms = min(upright, key=lambda found: found[1])
    direct = _direct_homography(ways[0 if fits[0][0] is mount else 1], board, camera, offset)
    reach = direct[0, 2] / direct[2, 2]
    matrix = camera.matrix if projection is None else projection[:3, :3]
    homography = direct @ np.linalg.inv(matrix)
    pixel = homography @ camera.matrix[:, 2]
    return Extrinsics(mount, homography / homography[2, 2], rms, float(reach), float(pixel[0] / pixel[2]))


def _direct_homography(
    corners: FloatArray, board: BoardSpec, camera: CameraModel, offset: tuple[float, float]
) -> FloatArray:
    """Return the homography from undistorted rays to the floor with the least squared error on the floor.

    It has two unknowns more than a pose, which take up what the camera file has wrong: on the floor near the
    board it is nearer to the truth than the pose's own homography.
    """
    rays = unproject(intrinsics_vector(camera), corners)
    homography, _ = cv2.findHomography(rays, board_points_base(board, offset)[:, :2], 0)
    return np.asarray(homography, dtype=float)


def _fit(
    corners: FloatArray, board: BoardSpec, camera: CameraModel, offset: tuple[float, float]
) -> tuple[CameraMount, float]:
    """Return the mount that explains the corners, and the fit's rms [px]."""
    points = board_points_base(board, offset)
    middle = points.mean(axis=0)
    problem = FreeBoards(corners[None], points - middle)
    start = start_poses(intrinsics_vector(camera), corners[None], points - middle)
    solution = fit(problem, start, np.ones(12, dtype=bool), np.ones((1, len(points))))
    rotation = solution.state.rotation[0].T
    position = middle - rotation @ solution.state.shift[0]
    return mount_from_pose(rotation, position), float(np.sqrt(2.0 * np.mean(solution.residual**2)))


def floor_homography(mount: CameraMount, projection: FloatArray) -> FloatArray:
    """Return the homography (3, 3) from rectified pixels to the floor [m], scaled so that its last entry
    is 1.
    """
    rotation, position = base_from_camera(mount)
    camera_from_base = rotation.T
    shift = -camera_from_base @ position
    image_from_floor = projection[:3, :3] @ np.column_stack(
        [camera_from_base[:, 0], camera_from_base[:, 1], shift]
    )
    homography = np.linalg.inv(image_from_floor)
    return np.asarray(homography / homography[2, 2])


def mount_of(homography: FloatArray, projection: FloatArray) -> CameraMount:
    """Return where the camera sits by a homography from rectified pixels to the floor [m]: undo `floor_homography`.

    projection : (3, 3) of the rectified image [px]. Its inverse is P (r1 r2 t) up to a factor, with r1, r2 the first
    columns of the rotation from `base` into the camera and t = -R o, o the camera's place; the nearest rotation is
    taken.
    """
    columns = np.linalg.solve(projection[:3, :3], np.linalg.inv(homography))
    columns = columns / np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    mounts = [_mount_of_columns(sign * columns) for sign in (1.0, -1.0)]
    return max(mounts, key=lambda mount: mount.height)  # the camera is above the floor


def _mount_of_columns(columns: FloatArray) -> CameraMount:
    """Return the mount of (r1 r2 t)."""
    rotation = nearest_rotation(np.column_stack([columns[:, :2], np.cross(columns[:, 0], columns[:, 1])]))
    return mount_from_pose(rotation.T, -rotation.T @ columns[:, 2])


def is_corrupt(homography: FloatArray) -> bool:
    """Tell whether Duckietown's software would refuse the homography: H[1][2] > 0 (a board read upside
    down).
    """
    return bool(homography[1, 2] > 0.0)


def rectified_matrix(camera: CameraModel) -> FloatArray:
    """Return the camera matrix (3, 3) [px] of the rectified image that shows no black border (ROS's alpha
    0).
    """
    size = (camera.width, camera.height)
    if camera.model == "equidistant":
        return np.asarray(
            cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(
                camera.matrix, camera.distortion, size, np.eye(3)
            ),
            dtype=float,
        )
    matrix, _ = cv2.getOptimalNewCameraMatrix(camera.matrix, camera.distortion, size, 0.0, size)
    return np.asarray(matrix, dtype=float)
