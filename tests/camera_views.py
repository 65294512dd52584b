"""Views of boards with known truth, made by projection alone, for the tests of the camera solve."""

import math

import numpy as np

from fsm_calib.perception.fleet_camera import FLEET_MEDIAN
from fsm_calib.perception.lens import project
from fsm_calib.perception.rotations import base_from_camera, rotation_from_vector, yaw_rotation
from fsm_calib.types import BoardSpec, BoardView, CameraMount

BOARD = BoardSpec()
SIZE = (640, 480)
TRUTH = FLEET_MEDIAN + np.array([4.0, 5.0, -6.0, 5.0, 0.01, -0.005, 1e-3, -1e-3, 0, 0, 0, 0])
MOUNT = CameraMount(height=0.112, pitch=math.radians(21.0), roll=math.radians(0.7))
#: azimuth [deg], distance [m], height of the centre [m], turn from facing [deg], lean [deg]
AREA = ((-48.0, 0.55, 0.11, 28.0, 15.0), (0.0, 0.37, 0.0, 0.0, 90.0), (48.0, 0.50, 0.11, -28.0, 30.0))


def hand_held(count: int, noise_px: float, seed: int = 0, vector: np.ndarray = TRUTH) -> list[BoardView]:
    """Return random views of one board, whole in the image."""
    rng = np.random.default_rng(seed)
    views: list[BoardView] = []
    points = BOARD.points_board() - BOARD.points_board().mean(axis=0)
    while len(views) < count:
        turn = rotation_from_vector(rng.uniform(-0.6, 0.6, 3))
        distance = rng.uniform(0.2, 0.5)
        place = distance * np.array([*rng.uniform(-0.9, 0.9, 2), 1.0])
        seen = points @ turn.T + place
        image = project(vector, seen)
        inside = np.all((image > 8.0) & (image < np.array(SIZE) - 9.0)) and np.all(seen[:, 2] > 0.05)
        if inside and np.all(np.linalg.norm(seen[:, :2] / seen[:, 2:], axis=1) < 1.5):
            views.append(BoardView(image + rng.normal(size=image.shape) * noise_px, 0, f"frame {len(views)}"))
    return views


def board_in_world(spot: tuple[float, float, float, float, float]) -> np.ndarray:
    """Return the corners of a board of the area, shape (35, 3) [m]."""
    azimuth, distance, height, turn, lean = spot
    yaw, tip = math.radians(azimuth + turn), math.radians(lean)
    away = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    right = np.array([math.sin(yaw), -math.cos(yaw), 0.0])
    down = np.array([0.0, 0.0, -math.cos(tip)]) - away * math.sin(tip)
    points = BOARD.points_board() - BOARD.points_board().mean(axis=0)
    centre = distance * np.array([math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth)), 0.0])
    return points @ np.array([right, down, np.cross(right, down)]) + centre + [0.0, 0.0, height]


def scanned(noise_px: float, seed: int = 0, step: float = 6.0) -> list[BoardView]:
    """Return the views of a robot that turns on one wheel before the area, rows running right in the image."""
    rng = np.random.default_rng(seed)
    views: list[BoardView] = []
    rotation, position = base_from_camera(MOUNT)
    worlds = [board_in_world(spot) for spot in AREA]
    for frame, heading in enumerate(np.arange(-60.0, 61.0, step)):
        turn = yaw_rotation(math.radians(heading + rng.normal()))
        place = np.array([0.0, -0.05, 0.0]) + turn @ np.array([0.0, 0.05, 0.0])
        for number, world in enumerate(worlds):
            seen = ((world - place) @ turn - position) @ rotation
            image = project(TRUTH, seen)
            outside = np.any(image < 8.0) or np.any(image > np.array(SIZE) - 9.0) or np.any(seen[:, 2] < 0.05)
            if outside or np.any(np.linalg.norm(seen[:, :2] / seen[:, 2:], axis=1) > 1.8):
                continue
            image = image + rng.normal(size=image.shape) * noise_px
            grid = image.reshape(BOARD.rows, BOARD.columns, 2)
            runs_right = (grid[:, -1] - grid[:, 0]).mean(axis=0)[0] > 0.0
            views.append(BoardView(image if runs_right else image[::-1], number, f"frame {frame}"))
    return views
