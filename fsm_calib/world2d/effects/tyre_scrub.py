r"""The tyres' wide contact resists turning.

    M = -moment omega / sqrt(omega^2 + rate^2)

M [N m] about the vertical: half the contact's length times friction times load for each wheel; omega [rad/s] yaw
rate; rate [rad/s] below which it acts as a damper: a turning contact slides as a whole only when it turns faster
than its tread can bend and roll off. Source: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 9.2 (turn
slip and parking torque).

Not in it: a contact that spins slips more easily in all directions (Contensou's friction; contact models with one
cone for sliding and spinning have it, too, MuJoCo's by a tenth of a metre times omega). A closure with that length as a
second number predicts scrub in MuJoCo to within the noise, but on real robots it takes the place of treads that skid
(`skid_steer`).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.forces import add_dry_moment


@njit(error_model="numpy")
def scrub(P, o, S, m, W):
    """Add the moment."""
    add_dry_moment(W, P[o], P[o + 1])


EFFECT = Effect(
    name="tyre_scrub",
    family="resistance",
    summary="resistance to turning",
    equation="M = -moment omega / sqrt(omega^2 + rate^2)",
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
    ),
    order=76,
    dissipative=True,
    universal=True,
)
