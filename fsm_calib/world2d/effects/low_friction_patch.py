r"""A slippery spot: tyres that stand on it pass less force.

    mu_i = mu (1 - loss)        |p_i - (x, y)| <= radius

mu [1] friction coefficient, loss [1] the part that is missing, p_i [m] place of wheel i (or nearer to the body's
middle: `spread` [1], 1 wheel, 0 middle, where a spot takes both wheels at once), centre (x, y) and radius [m] of a
disc. Wheels then spin up or slide. Source: combined slip of `dynamics`; Pacejka 2012, section
3.2.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.effects.places import (
    centre_parameters,
    contact_arm,
    contact_place,
    in_disc,
    spread_parameter,
)
from fsm_calib.world2d.slots import GRIP

LEAST_LOSS = 0.2
"""Loss of grip: on one clean floor friction differs by a tenth or two from place to place. Nine true spots of robots of
others' physics lose 0.43 to 0.87, three that were none, in the place of what is inexact in tyres, 0.15 to 0.17."""
SLIDE_DOUBT = 0.06  # m: a slide is chaotic, and its likelihood flat in the spot's place (20 concealed spots)


@njit(error_model="numpy")
def slip(P, o, S, m, W):
    """Lower the grip of each wheel inside."""
    for side in range(2):
        x, y = contact_place(W, contact_arm(W, side, P[o + 4]))
        W[GRIP + side] *= 1.0 - P[o] * in_disc(x, y, P[o + 1], P[o + 2], P[o + 3])


EFFECT = Effect(
    name="low_friction_patch",
    family="patch",
    summary="a slippery spot",
    equation="mu_i = mu (1 - loss) for wheels inside a disc",
    parameters=(
        Parameter(
            "loss",
            "q",
            "1",
            0.0,
            0.0,
            0.995,
            0.93,
            "dust, water or tape: 0.5 to 0.95",
            starts=(0.8, 0.95),
            step=1e-3,
            natural_end=True,
            least=LEAST_LOSS,
            doubt=0.07,  # a tyre's law of slipping stands for another's
        ),
        *centre_parameters("s", SLIDE_DOUBT),
        Parameter(
            "radius",
            "r_s",
            "m",
            0.2,
            0.03,
            3.0,
            0.25,
            "a spot of 5 to 40 cm",
            strength=False,
            step=6e-3,
            starts=(0.15, 0.25),
            doubt=SLIDE_DOUBT,
        ),
        spread_parameter("w_s"),
    ),
    hooks={"step": slip},
    reads=("place", "heading"),
    channels=("forward", "turn", "lateral"),
    regimes=("place",),
    separates="shows when accelerating or curving there, wheels spin; a rough spot slows at any time",
    rivals=("rough_floor_patch", "misplaced_marker", "external_push"),
    manoeuvre="start, stop and turn on the spot, on two headings",
    sentence="Within {radius} of ({x}, {y}) the floor has lost {loss} of its grip.",
    source="Pacejka 2012, section 3.2",
    where="disc",
    acts_on="grip",
    order=84,
    dissipative=True,
)
