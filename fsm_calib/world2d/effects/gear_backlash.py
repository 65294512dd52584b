r"""Play in the gears: after each change of the torque's sign the motor crosses a gap before it drives again.

    d p / d t = (w_m - v_i) / R,    0 <= p <= gap
    rotor m_w d w_m / d t = D (T - w_m),  F = 0    while 0 < p < gap

p [rad] place of the motor's tooth in the gap, seen at the wheel, gap [rad] the whole play (of both gears, or of one
alone: gap_left, gap_right come on top), w_m [m/s] the motor's
speed as a rim speed, v_i [m/s] the ground's speed at the wheel, R [m] radius, m_w [kg] rotating inertia, of which
`rotor` [1] is the motor's, D [N s/m] and T [m/s] the motor's line. The step in which the tooth arrives drives for the
rest of it, and begins with the motor's momentum. Encoders count the motor's turns or the wheel's (`encoder_side` [1],
0 motor, 1 wheel), which part while the teeth do. Source: Nordin & Gutman, Automatica 38 (2002) 1633, section 3.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import contact_arm
from fsm_calib.world2d.effects.wheels import of_each_wheel
from fsm_calib.world2d.slots import (
    DRIVE,
    ENGAGED,
    FREE_ROTATING,
    OMEGA,
    RADIUS,
    RIM,
    ROTATING,
    STEP,
    TARGET,
    WHEEL_ENCODER,
    V,
)
from fsm_calib.world2d.tyres import free_speed

TOUCH = 1e-9
"""Travel [rad] in one step below which teeth that touch are taken to stay engaged."""


@njit(error_model="numpy")
def cross_gap(P, o, S, m, W):
    """Disengage the motors while their teeth are between the flanks."""
    h = W[STEP]
    W[WHEEL_ENCODER] = P[o + 1]
    W[FREE_ROTATING] = P[o + 2] * W[ROTATING]
    for side in range(2):
        gap = P[o] + P[o + 3 + side]
        if gap <= 0.0:
            continue
        rim = S[RIM + side]
        ground = S[V] - contact_arm(W, side, 1.0) * S[OMEGA]
        free = free_speed(rim, W[TARGET + side], W[DRIVE + side], W[FREE_ROTATING], h)
        travel = (0.5 * (rim + free) - ground) * h / W[RADIUS + side]
        after = S[m + side] + travel
        S[m + side] = min(max(after, 0.0), gap)
        if abs(travel) > TOUCH:
            beyond = after - gap if travel > 0.0 else -after
            W[ENGAGED + side] = min(max(beyond / abs(travel), 0.0), 1.0)
            if W[ENGAGED + side] > 0.0 and S[m + 2 + side] > 0.0:  # the rotor hits a wheel that rolls
                S[RIM + side] = ground + P[o + 2] * (rim - ground)
            S[m + 2 + side] = 1.0 if W[ENGAGED + side] == 0.0 else 0.0


EFFECT = Effect(
    name="gear_backlash",
    family="timing",
    summary="play in the gears",
    equation="dp/dt = (w_m - v_i)/R in [0, gap], F = 0 inside",
    parameters=(
        Parameter(
            "gap",
            "delta",
            "rad",
            0.0,
            0.0,
            1.5,
            0.15,
            "2 to 10 degrees at the wheel",
            starts=(0.02, 0.05, 0.12, 0.25),
            step=8e-3,  # rugged below: teeth touch within a step of the roll-out, or not
            doubt=0.35,  # where motors push little, random forces let the teeth float
        ),
        Parameter(
            "encoder_side",
            "e",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "1 encoders on the wheels, 0 on the motors",
            strength=False,
            fitted=False,
            with_encoders=True,
            starts=(0.0, 1.0),
        ),
        Parameter(
            "rotor",
            "r",
            "1",
            1.0,
            0.05,
            1.0,
            1.0,
            "the motors' part of the rotating inertia, rest on the wheels",
            strength=False,
            starts=(0.15, 0.7),
            step=5e-2,
            rugged=True,
        ),
        *of_each_wheel(
            Parameter(
                "gap",
                "delta",
                "rad",
                0.0,
                0.0,
                1.5,
                0.0,
                "one gear worn, or put in new",
                starts=(0.12, 0.05, 0.02, 0.25),
                step=8e-3,
                doubt=0.35,
            )
        ),
    ),
    hooks={"step": cross_gap},
    channels=("forward", "turn"),
    regimes=("after_reversal", "transient"),
    separates="a fixed angle is lost at each change of the torque's sign: the slower, the longer",
    rivals=("command_delay", "motor_asymmetric_lag", "caster_drag", "coulomb_friction"),
    manoeuvre="forward and reverse at three speeds",
    sentence="The gears have {gap} of play, seen at the wheel.",
    input="command",
    source="Nordin & Gutman 2002",
    closures=(
        Closure("both alike", ("gap", "rotor"), "the same in both gears"),
        Closure(
            "left wheel",
            ("gap_left", "rotor"),
            "of the left wheel's gear alone",
            sentence="The left wheel's gear has {gap_left} of play, seen at the wheel.",
        ),
        Closure(
            "right wheel",
            ("gap_right", "rotor"),
            "of the right wheel's gear alone",
            sentence="The right wheel's gear has {gap_right} of play, seen at the wheel.",
        ),
    ),
    memory=4,
    order=65,
    dissipative=True,
)
