r"""The robot turns as if its wheels stood farther apart: several wheels a side must skid to turn.

    omega = (w_r - w_l) / (b (1 + stretch))

omega [rad/s] yaw rate, w [m/s] rim speeds, b [m] the stated distance of left and right wheels, stretch [1]. Each side's
treads have their own instantaneous centre of rotation on the floor, outside the wheels; its distance over half the
track is 1 + stretch, 1.3 to 2.5 on real robots, and nearly constant on one floor. Two-wheeled robots have none of it.
Only measured wheels tell it from motors that answer each other's commands: both scale all turning by one factor.
Source: Mandow, Martinez, Morales, Blanco, Garcia-Cerezo & Gonzalez, Experimental kinematics for wheeled skid-steer
mobile robots, IROS 2007, section III.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import HALF_AXLE, INERTIA


@njit(error_model="numpy")
def widen(P, o, W):
    """Set the wheels apart; the time constants stay."""
    factor = 1.0 + P[o]
    W[HALF_AXLE] *= factor
    W[INERTIA] *= factor * factor


EFFECT = Effect(
    name="skid_steer",
    family="tyre",
    summary="turns as if the wheels stood farther apart (skidding treads)",
    equation="omega = (w_r - w_l) / (b (1 + stretch))",
    parameters=(
        Parameter(
            "stretch", "chi - 1", "1", 0.0, 0.0, 2.0, 0.5, "1.3 to 2.5 times the track (Mandow et al. 2007)",
            starts=(0.3, 1.0),
        ),
    ),
    hooks={"begin": widen},
    channels=("turn",),
    regimes=("turning",),
    separates="all turning is too slow by one factor, at every rate, both ways; the stated axle speaks for it",
    rivals=("tyre_scrub", "motor_deadband", "wheel_slip"),
    manoeuvre="spins and arcs at three rates, and a tape measure on the track",
    sentence="The robot turns as if its wheels stood {stretch} of the stated axle farther apart: they skid sideways.",
    source="Mandow et al., IROS 2007, section III",
    input="wheels",
    order=10,
)  # fmt: skip
