"""Robots drawn from the statistics of real fleets: cameras, camera mounts and wheels.

Sources, all from Duckietown's published calibration logs (dt-core, `log-calib-config/baseline/calibration`):

- wheel ratio of 32 robots: 0.78 to 1.19, standard deviation 0.106, from gain and trim k = (g + t) / (g - t);
- lenses of 50 robots: medians and the 5 % to 95 % ranges in `FLEET`; k3 = 0 in all; k1 and k2 strongly
  anticorrelated (shipped and sample calibrations: -0.257, 0.045; -0.294, 0.070; -0.235, 0.036);
- mounts of 41 robots, from their ground homographies: height 0.099 to 0.131 m, pitch 15.8 to 27.1 deg.

Assumed, for want of data: roll 0.8 deg, axle length 2 mm, overall speed 8 % (standard deviations), focus blur
0.5 to 0.9 px.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.types import CameraModel, CameraMount, FloatArray
from fsm_calib.world2d.lens import sees_everywhere
from fsm_calib.world2d.parameters import parameter_table


@dataclass(frozen=True, slots=True)
class Spread:
    """A truncated normal quantity: mean, standard deviation, ends, unit."""

    mean: float
    sd: float
    low: float
    high: float
    unit: str

    def draw(self, rng: np.random.Generator) -> float:
        """Draw by rejection; every end lies more than a standard deviation out, so few draws are refused."""
        while True:
            value = float(rng.normal(self.mean, self.sd))
            if self.low <= value <= self.high:
                return value


FLEET: Mapping[str, Spread] = {
    "wheel_ratio": Spread(0.973, 0.106, 0.78, 1.19, "1"),
    "speed": Spread(1.0, 0.08, 0.8, 1.2, "1"),
    "axle_length": Spread(0.100, 0.002, 0.095, 0.105, "m"),
    "fx": Spread(318.0, 10.5, 298.0, 345.0, "px"),
    "fy_over_fx": Spread(1.003, 0.006, 0.985, 1.02, "1"),
    "cx": Spread(320.4, 12.0, 295.0, 345.0, "px"),
    "cy": Spread(231.0, 10.0, 206.0, 250.0, "px"),
    "k1": Spread(-0.271, 0.0173, -0.31, -0.235, "1"),
    "p1": Spread(0.0006, 0.0024, -0.005, 0.005, "1"),
    "p2": Spread(0.0006, 0.0018, -0.004, 0.004, "1"),
    "forward": Spread(0.070, 0.0115, 0.054, 0.092, "m"),
    "left": Spread(0.0, 0.007, -0.014, 0.014, "m"),
    "height": Spread(0.113, 0.0095, 0.099, 0.131, "m"),
    "pitch": Spread(math.radians(22.0), math.radians(2.7), math.radians(15.8), math.radians(27.1), "rad"),
    "roll": Spread(0.0, math.radians(0.8), math.radians(-2.0), math.radians(2.0), "rad"),
    "yaw": Spread(math.radians(1.2), math.radians(2.8), math.radians(-5.0), math.radians(7.0), "rad"),
    "defocus": Spread(0.65, 0.12, 0.5, 0.9, "px"),
}
"""What differs between robots of one fleet."""

K2_ON_K1 = -0.60
"""Slope of k2 on k1 [1]: line through the published calibrations."""
K2_AT_MEAN = 0.053
"""k2 at the mean k1 [1]."""
K2_RESIDUAL = 0.004
"""Standard deviation of k2 about that line [1]; with the slope it gives the fleet's 0.039 to 0.077."""


@dataclass(frozen=True, eq=False)
class RobotSpec:
    """One robot as it truly is.

    name; camera, mount : the true lens and where it sits; wheel_ratio : the true k, right command over left
    command for driving straight; speed : all motor gains times this [1]; axle_length [m]; defocus : focus
    blur [px]; effects : values of further parameters by full name (``battery_sag.per_charge``), as in
    `parameters.parameter_table`.
    """

    name: str
    camera: CameraModel
    mount: CameraMount
    wheel_ratio: float = 1.0
    speed: float = 1.0
    axle_length: float = 0.100
    defocus: float = 0.6
    effects: Mapping[str, float] = field(default_factory=dict)

    def parameters(self) -> FloatArray:
        """Return the parameter vector of the physics, shape (p,), checked against its bounds.

        Both gains share the difference, G_left = 2 k G / (1 + k), G_right = 2 G / (1 + k), so that the
        command (u, k u) drives both wheels alike.
        """
        if not (math.isfinite(self.wheel_ratio) and 0.2 <= self.wheel_ratio <= 5.0):
            raise InputError(
                f"wheel_ratio is {self.wheel_ratio:g}", where="robot", cure="Use a value from 0.2 to 5."
            )
        table = parameter_table()
        vector = table.null.copy()
        nominal = vector[table.place("gain_left")] * self.speed
        vector[table.place("gain_left")] = 2.0 * self.wheel_ratio * nominal / (1.0 + self.wheel_ratio)
        vector[table.place("gain_right")] = 2.0 * nominal / (1.0 + self.wheel_ratio)
        vector[table.place("axle_length")] = self.axle_length
        for name, value in self.effects.items():
            vector[table.place(name)] = value
        table.check(vector, "robot")
        return vector


def nominal_camera() -> CameraModel:
    """Return the median lens of 50 real robots (fx 316.2, fy 317.2, cx 320.4, cy 231.9 px; k1 -0.269, k2
    0.050).
    """
    matrix = np.array([[316.2, 0.0, 320.4], [0.0, 317.2, 231.9], [0.0, 0.0, 1.0]])
    return CameraModel(matrix, np.array([-0.269, 0.050, 6e-4, 2e-4, 0.0]))


def nominal_robot(name: str = "duckiebot", wheel_ratio: float = 1.0) -> RobotSpec:
    """Return a robot with the fleet's median camera and mount and, by default, equal wheels."""
    return RobotSpec(name, nominal_camera(), CameraMount(height=0.113), wheel_ratio)


def draw_camera(rng: np.random.Generator) -> CameraModel:
    """Draw a plumb_bob lens; a draw that folds inside the image is drawn again."""
    while True:
        fx = FLEET["fx"].draw(rng)
        fy = fx * FLEET["fy_over_fx"].draw(rng)
        cx, cy = FLEET["cx"].draw(rng), FLEET["cy"].draw(rng)
        k1 = FLEET["k1"].draw(rng)
        k2 = K2_AT_MEAN + K2_ON_K1 * (k1 - FLEET["k1"].mean) + K2_RESIDUAL * float(rng.standard_normal())
        distortion = np.array([k1, k2, FLEET["p1"].draw(rng), FLEET["p2"].draw(rng), 0.0])
        camera = CameraModel(np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]), distortion)
        if sees_everywhere(camera):
            return camera


def draw_mount(rng: np.random.Generator) -> CameraMount:
    """Draw where the camera sits."""
    names = ("forward", "left", "height", "pitch", "roll", "yaw")
    return CameraMount(**{name: FLEET[name].draw(rng) for name in names})


def draw_robot(rng: np.random.Generator, name: str = "duckiebot") -> RobotSpec:
    """Draw a robot of the fleet; the same generator state gives the same robot."""
    wheels, optics = rng.spawn(2)
    return RobotSpec(
        name,
        draw_camera(optics),
        draw_mount(optics),
        wheel_ratio=FLEET["wheel_ratio"].draw(wheels),
        speed=FLEET["speed"].draw(wheels),
        axle_length=FLEET["axle_length"].draw(wheels),
        defocus=FLEET["defocus"].draw(optics),
    )
