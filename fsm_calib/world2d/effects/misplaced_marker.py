r"""One marker on the floor is not where the map says: poses measured by it are wrong.

    pose_measured = T pose          |(x, y) - (x_m, y_m)| <= radius
    T: turn by `turn` about (x_m, y_m), then shift by (shift_x, shift_y)
    T: turn of the heading alone                   rigid = 0
    pose_measured = pose                           |heading - face| > view

(x_m, y_m) [m] the marker, radius [m] within which it is the one that is seen, turn [rad] and shift [m] its
error in the map. The robot does not feel it: the pose jumps on the way in and back on the way out, or slides over a
band of `fade` [m] to both sides where a place is told by several markers at once. A camera sees a board on a wall only
while the robot looks its way: within `view` [rad] of the heading `face` [rad]. Headings alone are wrong where a
place is told by other marks, or by a compass near iron. Sources: map errors of tag localisation, e.g. Olson, ICRA
2011 (AprilTag), section V; Angermann, Frassl, Doniec, Julian & Robertson, Characterization of the indoor magnetic
field, IPIN 2012.
"""

from __future__ import annotations

import math

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import centre_parameters, heading_parameter
from fsm_calib.world2d.slots import EDGE

LOOK_EDGE = 0.2
"""How far beyond its view a marker that is seen from one side is lost, as a difference of cosines [1] (assumed: some
10 degrees at the sides)."""


def displace(p: FloatArray, poses: FloatArray, places: FloatArray) -> FloatArray:
    """Return the poses as measured by the misplaced marker where it is seen, shape (n, 3); `places`, shape
    (n, 2), say where.
    """
    turn, shift_x, shift_y, x, y, radius, rigid, fade, face, view = p
    dx, dy = places[:, 0] - x, places[:, 1] - y
    s = np.clip(0.5 + 0.5 * (radius - np.hypot(dx, dy)) / (EDGE + fade), 0.0, 1.0)
    looks = np.clip(1.0 + (np.cos(poses[:, 2] - face) - np.cos(view)) / LOOK_EDGE, 0.0, 1.0)
    inside = s * s * (3.0 - 2.0 * s) * looks
    wrong = poses.copy()
    wrong[:, 0] += inside * (rigid * ((np.cos(turn) - 1.0) * dx - np.sin(turn) * dy) + shift_x)
    wrong[:, 1] += inside * (rigid * (np.sin(turn) * dx + (np.cos(turn) - 1.0) * dy) + shift_y)
    wrong[:, 2] += inside * turn
    return wrong


EFFECT = Effect(
    name="misplaced_marker",
    family="sensor",
    summary="one marker is not where the map says",
    equation="pose_measured = T pose near the marker",
    parameters=(
        Parameter("turn", "psi_m", "rad", 0.0, -1.6, 1.6, 0.1, "1 to 10 degrees", mirror="negate"),
        Parameter("shift_x", "s_x", "m", 0.0, -0.3, 0.3, 0.01, "2 to 20 mm"),
        Parameter("shift_y", "s_y", "m", 0.0, -0.3, 0.3, 0.0, "2 to 20 mm", mirror="negate"),
        *centre_parameters("m"),
        Parameter(
            "radius",
            "r_m",
            "m",
            0.3,
            0.05,
            1.2,
            0.3,
            "half the pitch of the markers to the view's reach",
            strength=False,
            step=6e-3,
            starts=(0.15, 0.3),
        ),
        Parameter(
            "rigid",
            "k_m",
            "1",
            1.0,
            0.0,
            1.0,
            1.0,
            "1 place and heading turn together, 0 the heading alone",
            strength=False,
            fitted=False,
        ),
        Parameter(
            "fade",
            "d_m",
            "m",
            0.0,
            0.0,
            0.6,
            0.0,
            "half the band over which a view passes from one marker to the next: a fifth of their pitch",
            strength=False,
            step=6e-3,
            starts=(0.08,),
        ),
        heading_parameter("face", "phi_m", starts=(-2.4, -1.6, -0.8, 0.0, 0.8, 1.6, 2.4, 3.1)),
        Parameter(
            "view",
            "w_m",
            "rad",
            math.pi,
            0.4,
            math.pi,
            math.pi,
            "0.5 to 1.3: half of what a camera sees",
            strength=False,
            step=0.02,
            starts=(0.8, 1.6),
        ),
    ),
    hooks={"observe": displace},
    channels=("sensor",),
    regimes=("place",),
    separates="the pose jumps on entering and back on leaving, at standstill too; encoders see nothing",
    rivals=("sensor_yaw", "sensor_offset", "rough_floor_patch", "wheel_eccentricity"),
    manoeuvre="cross the place on two headings and at two speeds",
    sentence="The marker at ({x}, {y}) is turned by {turn}, shifted by ({shift_x}, {shift_y}), on the map.",
    source="Olson, ICRA 2011, section V",
    jumps=True,
    closures=(
        Closure("turned", ("turn", "x", "y", "radius"), "turned about its own place", fixes={"rigid": 1.0}),
        Closure(
            "turned and shifted",
            ("turn", "shift_x", "shift_y", "x", "y", "radius"),
            "turned and shifted",
            fixes={"rigid": 1.0},
        ),
        Closure(
            "blended",
            ("turn", "shift_x", "shift_y", "x", "y", "radius", "fade"),
            "turned and shifted; several markers are averaged, so that its error fades",
            fixes={"rigid": 1.0},
        ),
        Closure(
            "heading alone",
            ("turn", "x", "y", "radius"),
            "headings are wrong there, places are not",
            sentence="Headings are told wrong by {turn} within {radius} of ({x}, {y}); places are not.",
            source="Angermann et al., IPIN 2012",
            fixes={"rigid": 0.0},
        ),
        Closure(
            "seen from one side",
            ("turn", "shift_x", "shift_y", "x", "y", "radius", "face", "view"),
            "turned and shifted; it counts only while the robot looks its way",
            sentence="The marker at ({x}, {y}) is turned by {turn}, shifted by ({shift_x}, {shift_y}), on the map; it "
            "counts within {view} of the heading {face}.",
            fixes={"rigid": 1.0},
            extends=("turned and shifted",),
        ),
    ),
    where="disc",
    acts_on="pose",
    order=30,
)
