r"""The tyres' wide contact resists turning.

    M = -sum_i moment/2 omega / sqrt(omega^2 + rate^2 + (roll v_i)^2)
    s1^2 <- s1^2 + (spin omega)^2                a contact that spins slips more easily

M [N m] about the vertical: half the contact's length times friction times load for each wheel; omega [rad/s] yaw
rate; rate [rad/s] below which it acts as a damper: a turning contact slides as a whole only when it turns faster than
its tread can bend and roll off. Tread that rolls off is renewed, so that a rolling tyre resists less: by its turn
slip, yaw rate over rolling speed v_i [m/s], which slides as a whole above roll [1/m] only: most where a wheel stands
while the robot pivots about it. s1 [m/s] is the slip speed of
`dynamics`; spin [m] is of the size of the contact: its points slide by the spin already, in all directions, and a
small slip only tips their balance. Contact models with one cone for sliding and spinning have it, too, larger
(MuJoCo's a tenth of a metre). Skidding treads (`skid_steer`) slip as they turn, too, and this length would take their
place, so it only refines scrub that has been found without it.
Sources: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 9.2 (turn slip and parking torque); Leine & Glocker,
Eur. J. Mech. A 22 (2003) 193 (Contensou's friction: sliding and spinning at once).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import contact_arm
from fsm_calib.world2d.forces import add_dry_moments
from fsm_calib.world2d.slots import OMEGA, SLIP_SPEED, V


@njit(error_model="numpy")
def scrub(P, o, S, m, W):
    """Add the moment, less for tyres that roll, and let them slip more easily while they spin."""
    rate_l = rate_r = P[o + 1]
    if P[o + 3] != 0.0:
        roll_l = P[o + 3] * (S[V] - contact_arm(W, 0, 1.0) * S[OMEGA])
        roll_r = P[o + 3] * (S[V] - contact_arm(W, 1, 1.0) * S[OMEGA])
        rate_l, rate_r = math.sqrt(rate_l**2 + roll_l**2), math.sqrt(rate_r**2 + roll_r**2)
    add_dry_moments(W, P[o], rate_l, rate_r)
    if P[o + 2] != 0.0:
        W[SLIP_SPEED] = math.sqrt(W[SLIP_SPEED] ** 2 + (P[o + 2] * S[OMEGA]) ** 2)


EFFECT = Effect(
    name="tyre_scrub",
    family="resistance",
    summary="resistance to turning",
    equation="M = -sum moment/2 omega / sqrt(omega^2 + rate^2 + (roll v_i)^2), s1^2 = s1^2 + (spin omega)^2",
    parameters=(
        Parameter(
            "moment",
            "M_s",
            "N m",
            0.0,
            0.0,
            0.5,
            0.02,
            "contact 5 to 10 mm wide under 5 N",
            starts=(0.01, 0.04),
        ),
        Parameter(
            "rate",
            "w_s",
            "rad/s",
            0.0,
            0.0,
            1.0,
            0.1,
            "0 (sliding at once) to 0.3 for soft treads",
            strength=False,
            step=5e-3,
            starts=(0.1,),
        ),
        Parameter(
            "spin",
            "l_s",
            "m",
            0.0,
            0.0,
            0.3,
            0.0,
            "a third of the contact's radius",
            strength=False,
            step=2e-3,
            starts=(0.03,),
        ),
        Parameter(
            "roll",
            "p_s",
            "1/m",
            0.0,
            0.0,
            400.0,
            0.0,
            "4 over the contact's width: 100 for 4 cm; less for treads that bend",
            strength=False,
            step=0.05,
            starts=(8.0, 60.0),
        ),
    ),
    hooks={"step": scrub},
    channels=("turn",),
    regimes=("turning",),
    separates="turning alone suffers, by the same moment at every rate; a longer axle scales with the rate",
    rivals=("coulomb_friction", "caster_drag", "motor_deadband", "lateral_slip"),
    manoeuvre="spins at three rates and wide arcs",
    sentence="The tyres resist turning with {moment}.",
    source="Pacejka 2012, section 9.2",
    closures=(
        Closure("usual tread", ("moment",), "slides as a whole"),
        Closure("own tread", ("moment", "rate"), "a tread that bends and rolls off first"),
        Closure("rolling tread", ("moment", "roll"), "resists less on wide arcs, where the tread is renewed"),
        Closure(
            "spinning contact",
            ("moment", "rate", "spin"),
            "slips more easily while it spins",
            sentence="The tyres resist turning with {moment}; over {spin} of their contact they slip as they spin.",
            source="Leine & Glocker 2003",
            refines=True,
        ),
    ),
    order=76,
    dissipative=True,
)
