"""Where the boards were before the camera: the poses of the views that a calibration used, as a drawing in space."""

from __future__ import annotations

from itertools import product

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.lens import intrinsics_vector, unproject
from fsm_calib.report.palette import BOARD_COLOURS, INK
from fsm_calib.report.run_style import Margins, figure, svg
from fsm_calib.types import BoardSpec, CameraModel, FloatArray

_FRUSTUM = 0.3
"""Length of the camera's drawn pyramid, in distances of the median board [1]."""
_ROOM = Margins(left=0.0, right=0.3, bottom=0.1, top=0.0)


def poses(calibration: CameraCalibration, board: BoardSpec) -> str:
    """Return the boards of the used views and the camera's field of view as SVG: right, away from it, up [m]."""
    points = board.points_board()
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])
    flat = np.column_stack([corners, np.zeros(4)])
    boards = flat @ calibration.rotation.transpose(0, 2, 1) + calibration.shift[:, None, :]
    sides = _pyramid(calibration.camera, _FRUSTUM * float(np.median(boards[..., 2])))
    with figure(5.2, 3.9, _ROOM) as fig:
        axes = fig.add_subplot(projection="3d")
        axes.add_collection3d(
            Poly3DCollection(
                _upright(boards), facecolors=BOARD_COLOURS[0], edgecolors=INK, alpha=0.25, linewidths=0.7
            )
        )
        axes.add_collection3d(
            Poly3DCollection(_upright(sides), facecolors="none", edgecolors=BOARD_COLOURS[1], linewidths=1.0)
        )
        everything = _upright(np.concatenate([boards.reshape(-1, 3), sides.reshape(-1, 3)]))
        lowest, highest = everything.min(axis=0), everything.max(axis=0)
        axes.set(xlabel="right [m]", ylabel="away [m]", zlabel="up [m]")
        axes.set(xlim=(lowest[0], highest[0]), ylim=(lowest[1], highest[1]), zlim=(lowest[2], highest[2]))
        axes.set_box_aspect(np.maximum(highest - lowest, 1e-6), zoom=1.0)
        axes.view_init(elev=22.0, azim=-62.0)
        axes.locator_params(nbins=4)
        axes.tick_params(labelsize=8)
        return svg(fig, "Where the boards were before the camera, in space")


def _upright(points_camera: FloatArray) -> FloatArray:
    """Return points of the camera's frame with the depth as the second axis and up as the third."""
    return np.stack([points_camera[..., 0], points_camera[..., 2], -points_camera[..., 1]], axis=-1)


def _pyramid(camera: CameraModel, depth: float) -> FloatArray:
    """Return the four sides of the field of view up to a depth, shape (4, 3, 3) [m]."""
    pixels = np.array(list(product((0.0, camera.width - 1.0), (0.0, camera.height - 1.0))))[[0, 1, 3, 2]]
    rays = unproject(intrinsics_vector(camera), pixels)
    ends = depth * np.column_stack([rays, np.ones(4)])
    return np.stack([[np.zeros(3), ends[corner], ends[(corner + 1) % 4]] for corner in range(4)])
