"""The frozen values that pass between the rooms.

Frames (REP-103): `world` and `base` have x forward, y left, theta counter-clockwise; `base` stands on the floor
under the centre of the axle; `camera` has x right, y down, z forward; `image` has (0, 0) at the centre of the top
left pixel. SI units throughout; pixels are named `_px` or `image`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
LensModel = Literal["plumb_bob", "rational_polynomial", "equidistant"]


def wrap_angle(angle: float) -> float:
    """Return `angle` [rad] wrapped to (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


def is_finite_number(value: object) -> bool:
    """Return whether `value` is a number that a float can hold: no boolean, no text, no nan, no infinity."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond any float
        return False


def read_only(array: object, dtype: type = np.float64) -> NDArray:
    """Return a contiguous copy of `array` that cannot be written to."""
    frozen: NDArray = np.array(array, dtype=dtype, order="C")
    frozen.setflags(write=False)
    return frozen


@dataclass(frozen=True, slots=True)
class Pose2:
    """A pose on the floor, of `base` in `world` unless a name says otherwise.

    Parameters
    ----------
    x, y : float
        Place: ahead and to the left in the parent frame [m].
    theta : float
        Heading, counter-clockwise from the parent's x axis [rad].
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def then(self, other: Pose2) -> Pose2:
        """Compose: the pose `other`, given in this pose's frame, in this pose's parent frame."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> Pose2:
        """Return the pose of the parent frame in this pose's frame."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.theta))


@dataclass(frozen=True, slots=True)
class WheelCommand:
    """Normalized wheel commands in [-1, 1], positive forward."""

    left: float = 0.0
    right: float = 0.0


STOP = WheelCommand(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WheelCalibration:
    """How the wheels answer commands; `wheel_ratio` is the paper's k: right command over left command.

    `gain`, `trim`, `motor_constant` (k, rad/s at command 1) and `limit` are Duckietown's;
    wheel_ratio = (gain + trim) / (gain - trim).
    """

    wheel_ratio: float = 1.0
    gain: float = 1.0
    axle_length: float = 0.100
    wheel_radius: float = 0.0318
    motor_constant: float = 27.0
    limit: float = 1.0

    @property
    def trim(self) -> float:
        """Duckietown's trim: gain (k - 1) / (k + 1)."""
        return self.gain * (self.wheel_ratio - 1.0) / (self.wheel_ratio + 1.0)


@dataclass(frozen=True, eq=False)
class CameraModel:
    """Intrinsics of one camera.

    matrix : array, shape (3, 3), [px]; distortion : array, shape (5,) k1 k2 p1 p2 k3 for `plumb_bob`,
    shape (8,) k1 k2 p1 p2 k3 k4 k5 k6 for `rational_polynomial`, shape (4,) k1 k2 k3 k4 for the `equidistant` lens of
    a fisheye (`cv2.fisheye`); width, height [px].
    """

    matrix: FloatArray
    distortion: FloatArray
    width: int = 640
    height: int = 480
    model: LensModel = "plumb_bob"

    def __post_init__(self) -> None:
        """Copy the arrays and make them read-only."""
        object.__setattr__(self, "matrix", read_only(self.matrix).reshape(3, 3))
        object.__setattr__(self, "distortion", read_only(self.distortion).ravel())


@dataclass(frozen=True, slots=True)
class CameraMount:
    """Where the camera sits on the robot and where it looks.

    Parameters
    ----------
    forward : float
        How far ahead of the axle's centre [m].
    left : float
        How far to the left of it [m].
    height : float
        How far above the floor [m].
    pitch : float
        How far it looks down [rad].
    roll : float
        Turn about its line of sight [rad]; positive lowers its right side.
    yaw : float
        How far it looks to the left [rad].
    """

    forward: float = 0.070
    left: float = 0.0
    height: float = 0.110
    pitch: float = math.radians(22.0)
    roll: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, eq=False)
class Frame:
    """One image as the robot delivers it: 8-bit, (height, width) or (height, width, 3) BGR; time [s]; its number."""

    image: NDArray[np.uint8]
    time: float
    index: int


@dataclass(frozen=True, slots=True)
class BoardSpec:
    """A chessboard.

    Parameters
    ----------
    columns : int
        Inner corners along a row [1].
    rows : int
        Inner corners along a column [1].
    square : float
        Side of a square [m].
    """

    columns: int = 7
    rows: int = 5
    square: float = 0.031

    def points_board(self) -> FloatArray:
        """Corners in the board's frame, shape (rows * columns, 3) [m], row by row, z = 0."""
        grid = np.zeros((self.rows * self.columns, 3))
        grid[:, :2] = np.mgrid[0 : self.columns, 0 : self.rows].T.reshape(-1, 2) * self.square
        return grid


@dataclass(frozen=True, eq=False)
class BoardView:
    """The corners of one board found in one image: shape (rows * columns, 2) [px], in `points_board` order."""

    corners_image: FloatArray
    board: int = 0
    source: str = ""

    def __post_init__(self) -> None:
        """Copy the corners and make them read-only."""
        object.__setattr__(self, "corners_image", read_only(self.corners_image).reshape(-1, 2))


@dataclass(frozen=True, eq=False)
class TagDetection:
    """A tag36h11 in an image: its number and corners, shape (4, 2) [px], in the AprilTag library's order."""

    tag_id: int
    corners_image: FloatArray

    def __post_init__(self) -> None:
        """Copy the corners and make them read-only."""
        object.__setattr__(self, "corners_image", read_only(self.corners_image).reshape(4, 2))


@dataclass(frozen=True, slots=True)
class TagObservation:
    """A floor tag relative to the robot: centre (x, y) [m] and heading [rad] of the tag's x axis in `base`.

    `distance` [m] from the camera; `heading_camera` [rad] is the paper's reading (yaw about the optical axis), kept
    for comparison. A robot that stands along the tags sees heading 0.
    """

    tag_id: int
    x: float
    y: float
    heading: float
    distance: float
    heading_camera: float = 0.0


@dataclass(frozen=True, slots=True)
class LanePose:
    """The robot in its lane: d [m] left of the centre, phi [rad] heading left; how many edge points told so."""

    d: float
    phi: float
    support: int = 0
