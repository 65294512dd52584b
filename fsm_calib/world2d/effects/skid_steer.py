r"""The robot turns as if its wheels stood farther apart: several wheels a side must skid to turn.

    omega = (w_r - w_l) / (b (1 + stretch))

omega [rad/s] yaw rate, w [m/s] rim speeds, b [m] the stated distance of left and right wheels, stretch [1]. Each side's
treads have their own instantaneous centre of rotation on the floor, outside the wheels; its distance over half the
track is 1 + stretch, 1.3 to 2.5 on real robots, and nearly constant on one floor. Two-wheeled robots have none of it,
and those that have it have no caster, and no side slip to be named beside it: that treads slide sideways is what skid
steering is. Only measured wheels tell it from motors that answer each other's commands: both scale all turning by one
factor.

Soft treads and belts wind up before they turn the body: a difference of the wheels' speeds reaches it through a lag,

    trail d(d) / dt = (w_r - w_l) - d      or      sigma d(d) / ds = (w_r - w_l) - d,

d [m/s] the difference that turns the robot, trail [s], s [m] the way that the wheels roll, sigma [m] the way over
which a rolling tyre builds up its force (relaxation length: one to two radii, Pacejka, Tyre and Vehicle Dynamics, 3rd
ed. 2012, section 7.2). Which of the two it is depends on what is soft: belts and gears know no way.

On a floor that grips, treads stick: dry friction holds the body's turning until they are twisted far enough, so that a
turn the other way begins late by 2 twist over its rate, however fast the robot rolls, and between two turns the body
stands still in yaw,

    dphi / dt = (w_r - w_l) / (b (1 + stretch)) - omega,   |phi| <= twist,   omega = 0 where |phi| < twist,

phi [rad] the angle by which the wheels are ahead of the body, twist [rad] dry friction's moment over the treads'
stiffness (Coulomb's element in series with a spring: Jenkin's element; Al-Bender, Lampaert & Swevers, IEEE T. Automatic
Control 50 (2005) 1883, section II). A Husky indoors: 0.04 rad, 1 cm of its wheels' way.

A tyre whose contact is wide, as that of twin tyres on one hub, rolls about whichever part of it is pressed most, and
the wheels seem as much farther apart or nearer. A stretch within the length over which scrubbing tyres spin
(`tyre_scrub`) is modelled and has no name: that wheels skid is 1.3 and more.

Treads that slide already hold a curve badly: the robot drifts outwards by l = -drift v omega, drift [s], as tyres do
that yield (`lateral_slip`, whose equation this is).
Source: Mandow, Martinez, Morales, Blanco, Garcia-Cerezo & Gonzalez, Experimental kinematics for wheeled skid-steer
mobile robots, IROS 2007, section III.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import HALF_AXLE, INERTIA, MASS, SIDE_COMPLIANCE, STEP, TARGET


def may_be_a_wide_contact(numbers: Mapping[str, float]) -> bool:
    """Return whether the tyres of a model that scrub are as wide as the wheels seem farther apart, for
    `Closure.has_twin`.
    """
    return abs(numbers["stretch"]) * numbers["axle_length"] <= numbers["tyre_scrub.spin"]


@njit(error_model="numpy")
def widen(P, o, W):
    """Set the wheels apart; the time constants stay."""
    factor = 1.0 + P[o]
    W[HALF_AXLE] *= factor
    W[INERTIA] *= factor * factor


@njit(error_model="numpy")
def wind_up(P, o, S, m, W):
    """Let the difference of the wheels' speeds reach the floor late, their mean as it is, and treads drift.

    S[m] [m/s] is the difference that has wound through; S[m + 1] [m] how far the right wheel is ahead of what the
    treads have passed on.
    """
    W[SIDE_COMPLIANCE] += 2.0 * P[o + 4] / W[MASS]
    trail, way, slack, step = P[o + 1], P[o + 2], 2.0 * W[HALF_AXLE] * P[o + 3], W[STEP]
    if slack > 0.0:
        mean, ahead = 0.5 * (W[TARGET] + W[TARGET + 1]), S[m + 1] + (W[TARGET + 1] - W[TARGET]) * step
        S[m + 1] = min(max(ahead, -slack), slack)
        half = 0.5 * (ahead - S[m + 1]) / step
        W[TARGET], W[TARGET + 1] = mean - half, mean + half
    if trail <= 0.0 and way <= 0.0:
        return
    left, right = W[TARGET], W[TARGET + 1]
    gone = step / trail if trail > 0.0 else 0.5 * (abs(left) + abs(right)) * step / way
    if gone <= 0.0:  # wheels that stand turn nothing, and what is wound up stays
        return
    mean, short = 0.5 * (left + right), S[m] - (right - left)
    half = 0.5 * (right - left + short * (1.0 - math.exp(-gone)) / gone)
    S[m] = right - left + short * math.exp(-gone)
    W[TARGET], W[TARGET + 1] = mean - half, mean + half


WIDER = "The robot turns as if its wheels stood {stretch} of the stated axle farther apart"

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
        Parameter(
            "trail", "tau", "s", 0.0, 0.0, 2.0, 0.0, "soft treads and belts: 0.1 to 1", strength=False,
            starts=(0.1, 0.4),
        ),
        Parameter(
            "way", "sigma", "m", 0.0, 0.0, 1.0, 0.0, "relaxation length: 0.5 to 2 wheel radii", strength=False,
            starts=(0.05, 0.2),
        ),
        Parameter(
            "twist", "phi_0", "rad", 0.0, 0.0, 0.3, 0.0, "own (0.04 on a Husky indoors)", strength=False,
            starts=(0.02, 0.06),
        ),
        Parameter(
            "drift", "K_y", "s", 0.0, 0.0, 0.3, 0.0, "0.2 on a Warthog on gravel, own", strength=False,
            starts=(0.03, 0.1),
        ),
    ),
    closures=(
        Closure("full", ("stretch",), "at once", has_twin=may_be_a_wide_contact),
        Closure("trailing", ("stretch", "trail"), "the body turns late",
            WIDER + ", and {trail} late."),
        Closure("winding up", ("stretch", "way"), "the treads wind up first",
            WIDER + ", after {way} of way."),
        Closure("drifting", ("stretch", "drift"), "and drifts outwards in curves",
            WIDER + ", and drifts outwards in curves by {drift} times its centripetal acceleration."),
        Closure("sticking", ("stretch", "twist"), "the treads stick and twist before they turn the body",
            WIDER + "; its treads stick until they are twisted by {twist}."),
        Closure("sticking, trailing", ("stretch", "twist", "trail"), "and it turns late",
            WIDER + "; its treads stick until they are twisted by {twist}, and the body follows {trail} late."),
    ),
    hooks={"begin": widen, "step": wind_up},
    memory=2,
    channels=("turn", "lateral"),
    regimes=("turning",),
    separates="all turning is too slow by one factor, at every rate, both ways; the stated axle speaks for it",
    rivals=("tyre_scrub", "motor_deadband", "wheel_slip"),
    manoeuvre="spins and arcs at three rates, and a tape measure on the track",
    sentence=WIDER + ": they skid sideways.",
    source="Mandow et al., IROS 2007, section III",
    input="wheels",
    excludes=("caster_drag", "lateral_slip"),
    order=10,
)  # fmt: skip
