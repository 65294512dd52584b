"""Pictures of a board that a person holds before the camera: where it is held, how it moves, what is seen.

The board is drawn fixed and the camera moves before it, which gives the same picture. The hand never quite
rests: the board moves with a velocity and turns at a rate that stay the same during a picture. The Duckiebot's
camera exposes its rows one after the other (rolling shutter), so that a moving board is not only blurred but
also sheared and stretched: at 1 cm/s and 0.3 m by 0.25 px between the first and the last row. A robot that
stands still, looking at boards that are screwed down, has neither.

Sources: Raspberry Pi camera documentation (OV5647: rolling shutter; the 1296 x 972 mode, which 640 x 480 at
30 Hz is made of, reaches 42 Hz, so that its rows take at most 24 ms); how a hand moves is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.perception.lens import intrinsics_vector, project, unproject
from fsm_calib.perception.rotations import BASE_FROM_OPTICAL, mount_from_pose, rotation_from_vector
from fsm_calib.study.operator import OperatorSettings
from fsm_calib.types import BoardSpec, CameraModel, FloatArray, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import RobotSpec
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import Light, SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene
from fsm_calib.world2d.textures import Image

HELD = BoardPlacement(x=2.0, y=0.0, z=1.5, yaw=math.pi)
"""The board in its scene: only what the camera sees relative to it matters."""
EDGE_PX = 12.0
"""Corners nearer to the image's edge than this are not wanted [px]: the pattern must be whole in the picture."""
WIDEST_RAY = 1.6
"""Tangent of the widest angle off the optical axis of a corner [1]: 58 degrees, beyond the picture."""
LEAST_DEPTH = 0.05
"""Least distance of a corner in front of the camera [m]."""
STEP_PX = 0.5
"""Image motion between two drawings of one picture [px]."""
FEWEST_DRAWINGS, MOST_DRAWINGS = 3, 16
"""Drawings of the moving board that one picture is made of."""
WINDOW_POINTS = 8
"""Moments at which each row's exposure is evaluated."""


@dataclass(frozen=True, eq=False)
class CameraPose:
    """A camera before the board: rotation world_from_camera (3, 3) and position (3,) [m]."""

    rotation: FloatArray
    position: FloatArray


@dataclass(frozen=True, eq=False)
class HandMotion:
    """How the board moves: velocity (3,) [m/s] and turn rate about its middle (3,) [rad/s], in the world."""

    velocity: FloatArray
    rate: FloatArray


@dataclass(frozen=True, eq=False)
class HandWork:
    """Who calibrates what by hand.

    robot : whose true lens and mount take the pictures; sensor : exposure, noise, focus; operator : the person;
    board : what is held before the camera or laid on the floor.
    """

    robot: RobotSpec
    sensor: SensorSettings
    operator: OperatorSettings
    board: BoardSpec


class HeldBoard:
    """A board that a person holds before a camera; everything that is random is drawn from `rng`."""

    def __init__(self, work: HandWork, rng: np.random.Generator) -> None:
        placement = replace(HELD, board=work.board)
        self._camera, self._sensor = work.robot.camera, work.sensor
        self._operator, self._rng = work.operator, rng
        self._scene = build_scene(SceneSpec(boards=(placement,)), rng)
        self._corners = board_points_world(placement)
        self._middle = self._corners.mean(axis=0)

    def picture(self) -> Image:
        """Return a picture, uint8 (height, width, 3) BGR, of the board held somewhere, moving a little."""
        pose = held_pose(self._corners, self._camera, self._operator, self._rng)
        light = self._light(pose, hand_motion(self._operator, self._rng))
        return expose(light, self._camera, self._sensor, self._rng)

    def _light(self, pose: CameraPose, motion: HandMotion) -> Light:
        """Return what reaches the sensor while its rows are exposed one after the other."""
        span = self._operator.readout + self._sensor.exposure
        moments = np.linspace(-0.5 * span, 0.5 * span, self._drawings(pose, motion, span))
        lights = [self._ideal(moved(pose, motion, self._middle, moment)) for moment in moments]
        shares = row_shares(moments, self._camera.height, self._operator.readout, self._sensor.exposure)
        luma = np.zeros((self._camera.height, self._camera.width), dtype=np.float32)
        for share, light in zip(shares, lights):
            luma += share[:, None] * light.luma
        return Light(np.rint(luma).astype(np.uint8), lights[len(lights) // 2].chroma)

    def _drawings(self, pose: CameraPose, motion: HandMotion, span: float) -> int:
        """Return how many drawings show the motion in steps of `STEP_PX`."""
        near = float(np.linalg.norm(self._corners - pose.position, axis=1).min())
        size = float(np.linalg.norm(self._corners - self._middle, axis=1).max())
        speed = float(np.linalg.norm(motion.velocity) + size * np.linalg.norm(motion.rate))
        travel_px = span * speed / near * float(self._camera.matrix[0, 0])
        return int(np.clip(math.ceil(travel_px / STEP_PX) + 1, FEWEST_DRAWINGS, MOST_DRAWINGS))

    def _ideal(self, pose: CameraPose) -> Light:
        mount = mount_from_pose(pose.rotation, pose.position)
        return Renderer(self._scene, self._camera, mount).ideal(Pose2())


def row_shares(moments: FloatArray, rows: int, readout: float, exposure: float) -> FloatArray:
    """Return the share of each drawing in each row, shape (moments, rows) [1]; shares of a row add up to one.

    Parameters
    ----------
    moments : array, shape (m,) [s]
        When the drawings were made, increasing, about the middle of the picture; between them the light is
        interpolated.
    rows : int
        Rows of the image.
    readout : float
        From the first row's exposure to the last row's [s].
    exposure : float
        Duration of a row's exposure [s].
    """
    middles = readout * (np.arange(rows) / (rows - 1.0) - 0.5)
    window = exposure * ((np.arange(WINDOW_POINTS) + 0.5) / WINDOW_POINTS - 0.5)
    times = middles[:, None] + window
    return np.stack([np.interp(times, moments, unit).mean(axis=1) for unit in np.eye(len(moments))]).astype(
        np.float32
    )


def moved(pose: CameraPose, motion: HandMotion, middle: FloatArray, moment: float) -> CameraPose:
    """Return the camera as the moving board sees it, `moment` [s] after the middle of the picture.

    The board at time t is x' = R (x - m) + m + v t with R = exp(rate t); the camera goes the inverse way.
    """
    turn = rotation_from_vector(motion.rate * moment).T
    position = middle + turn @ (pose.position - middle - motion.velocity * moment)
    return CameraPose(turn @ pose.rotation, position)


def hand_motion(operator: OperatorSettings, rng: np.random.Generator) -> HandMotion:
    """Draw how the board moves in one picture: a tremor always, now and then a hand that has not stopped."""
    factor = operator.fast_factor if rng.random() < operator.fast_share else 1.0
    velocity = factor * rng.normal(0.0, operator.tremor_speed, 3)
    return HandMotion(velocity, factor * rng.normal(0.0, operator.tremor_rate, 3))


def held_pose(
    corners: FloatArray, camera: CameraModel, operator: OperatorSettings, rng: np.random.Generator
) -> CameraPose:
    """Draw where the camera is such that the board is whole in the picture.

    Parameters
    ----------
    corners : array, shape (n, 3) [m]
        The board's inner corners in the scene.
    camera : CameraModel
    operator : OperatorSettings
    rng : numpy.random.Generator
    """
    middle, lens = corners.mean(axis=0), intrinsics_vector(camera)
    size = np.array([camera.width, camera.height], dtype=float)
    while True:
        lean, turn = rng.uniform(0.0, operator.largest_tilt), rng.uniform(0.0, math.tau)
        tilt = rotation_from_vector(lean * np.array([0.0, math.cos(turn), math.sin(turn)]))
        roll = rotation_from_vector(np.array([rng.normal(0.0, operator.roll_sd), 0.0, 0.0]))
        rotation = tilt @ roll @ BASE_FROM_OPTICAL
        pixel = rng.uniform(EDGE_PX, size - EDGE_PX)
        aim = np.append(unproject(lens, pixel[None])[0], 1.0)
        distance = rng.uniform(operator.nearest, operator.farthest)
        position = middle - rotation @ (aim / np.linalg.norm(aim) * distance)
        if _is_whole((corners - position) @ rotation, lens, size):
            return CameraPose(rotation, position)


def _is_whole(points: FloatArray, lens: FloatArray, size: FloatArray) -> bool:
    """Tell whether points, shape (n, 3) [m] in the camera's frame, all fall well inside the picture."""
    if np.any(points[:, 2] < LEAST_DEPTH):
        return False
    if np.any(np.linalg.norm(points[:, :2] / points[:, 2:], axis=1) > WIDEST_RAY):
        return False
    image = project(lens, points)
    return bool(np.all((image > EDGE_PX) & (image < size - 1.0 - EDGE_PX)))
