"""Views for the camera's benchmarks, from rendered pixels: the scan of a robot, and a board held by hand."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fsm_calib.perception.chessboard import find_board, find_boards
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.perception.lens import intrinsics_vector, project, unproject
from fsm_calib.perception.rotations import BASE_FROM_OPTICAL, mount_from_pose, rotation_from_vector
from fsm_calib.types import BoardSpec, BoardView, CameraModel, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import RobotSpec
from fsm_calib.world2d.layout import mixed_boards, upright_boards
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

SIZE = (640, 480)
BOARD = BoardSpec()
SWEEP, STEP = math.radians(75.0), math.radians(3.0)
LAYOUTS = {"mixed3": mixed_boards(3), "mixed4": mixed_boards(4), "upright2": upright_boards(2)}


def scan_poses(axle: float, rng: np.random.Generator) -> Iterator[Pose2]:
    """Yield the stops of a robot that turns on one wheel: clockwise, then counter-clockwise, then back."""
    pose = Pose2()
    stops = [pose]
    for sign, end in ((-1.0, -SWEEP), (1.0, SWEEP), (-1.0, 0.0)):
        pivot = Pose2(0.0, sign * axle / 2.0)  # the standing wheel: the right one for a clockwise turn
        while sign * (pose.theta - end) < 0.0:
            turn = Pose2(0.0, 0.0, sign * STEP * float(rng.uniform(0.7, 1.3)))
            pose = pose.then(pivot).then(turn).then(pivot.inverse())
            stops.append(pose)
    yield from stops


class Labels:
    """Tells boards apart by following their azimuth from frame to frame; a new one is numbered in turn."""

    def __init__(self, layout: tuple[BoardPlacement, ...]) -> None:
        self.azimuths = [math.atan2(placement.y, placement.x) for placement in layout]

    def number(self, view: BoardView, heading: float) -> int:
        """Return the number of the board nearest to where the view points, by the robot's rough heading [rad]."""
        ray = unproject(intrinsics_vector(fleet_camera()), view.corners_image.mean(axis=0, keepdims=True))[0]
        azimuth = heading - math.atan2(float(ray[0]), 1.0)
        return int(np.argmin([abs(math.remainder(azimuth - other, math.tau)) for other in self.azimuths]))


def scan(robot: RobotSpec, layout: tuple[BoardPlacement, ...], rng: np.random.Generator) -> list[BoardView]:
    """Return every board view of one scan, numbered, in order of time."""
    renderer = Renderer(build_scene(SceneSpec(boards=layout), rng), robot.camera, robot.mount)
    sensor, labels, views = SensorSettings(defocus=robot.defocus), Labels(layout), []
    for index, pose in enumerate(scan_poses(robot.axle_length, rng)):
        image = expose(renderer.ideal(pose), robot.camera, sensor, rng)
        for view in find_boards(image, BOARD):
            views.append(replace(view, board=labels.number(view, pose.theta), source=f"frame {index}"))
    return views


def hand_held(robot: RobotSpec, count: int, rng: np.random.Generator) -> list[BoardView]:
    """Return views of one board held by hand before the camera, each whole in the image."""
    placement = BoardPlacement(BOARD, x=2.0, y=0.0, z=1.5, yaw=math.pi)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    sensor, views = SensorSettings(defocus=robot.defocus), []
    world = board_points_world(placement)
    while len(views) < count:
        mount = _hand_pose(world, robot.camera, rng)
        image = expose(Renderer(scene, robot.camera, mount).ideal(Pose2()), robot.camera, sensor, rng)
        view = find_board(image, BOARD)
        if view is not None:
            views.append(replace(view, source=f"frame {len(views)}"))
    return views


def _hand_pose(world: np.ndarray, camera: CameraModel, rng: np.random.Generator) -> CameraMount:
    """Draw a camera pose that sees the whole board, as a mount on a robot at the origin."""
    middle, vector = world.mean(axis=0), intrinsics_vector(camera)
    while True:
        lean, turn = rng.uniform(0.0, math.pi / 4.0), rng.uniform(0.0, math.tau)
        tilt = rotation_from_vector(lean * np.array([0.0, math.cos(turn), math.sin(turn)]))
        roll = rotation_from_vector(np.array([rng.normal(0.0, math.radians(10.0)), 0.0, 0.0]))
        rotation = tilt @ roll @ BASE_FROM_OPTICAL
        aim = np.append(unproject(vector, rng.uniform([20, 20], [620, 460])[None])[0], 1.0)
        distance = rng.uniform(0.18, 0.6)
        position = middle - rotation @ (aim / np.linalg.norm(aim) * distance)
        seen = (world - position) @ rotation
        if np.all(seen[:, 2] > 0.05) and np.all(np.linalg.norm(seen[:, :2] / seen[:, 2:], axis=1) < 1.6):
            image = project(vector, seen)
            if np.all((image > 12.0) & (image < np.array(SIZE) - 13.0)):
                return mount_from_pose(rotation, position)
