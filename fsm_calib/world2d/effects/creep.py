r"""What holds a sensor gives way during a recording: it moves on to its place, ever more slowly.

    share(t) = 1 - creep exp(-t / settle)

share [1] of its last displacement at which a sensor is at t [s] since the recording's zero; creep [1]: the part that it
moves during the recording; settle [s]: within what time most of that is done. Foam tape creeps by the logarithm of
time, a clamp slides in jerks; an exponential is within a tenth of either over a minute. Source: viscoelastic creep by a
standard linear solid: Ferry, Viscoelastic Properties of Polymers, 3rd ed. 1980, chapter 3.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.closure import Closure
from fsm_calib.world2d.effects.parameter import Parameter

CREEP_PARAMETERS = (
    Parameter(
        "creep",
        "c",
        "1",
        0.0,
        -1.0,
        1.0,
        0.35,
        "a tenth to two thirds of it within a minute: foam tape, clamps",
        strength=False,
        step=0.01,
        starts=(0.3, -0.3),
    ),
    Parameter(
        "settle",
        "tau",
        "s",
        20.0,
        2.0,
        90.0,
        20.0,
        "15 to 40 s: soft tape under a plate",
        strength=False,
        step=0.2,
    ),
)
"""The numbers of a mount that gives way, which an effect of it has after its own."""


def creeping(moves: tuple[str, ...], sentence: str) -> Closure:
    """Return the closure of a mount that gives way, of an effect whose plain one, *full*, frees `moves`."""
    return Closure(
        "creeping",
        (*moves, *(p.name for p in CREEP_PARAMETERS)),
        "its mount gives way during a drive",
        sentence=sentence,
        source="Ferry 1980, chapter 3",
        extends=("full",),
    )


def crept(p: FloatArray, times: FloatArray) -> FloatArray:
    """Return the share of its displacement at which a sensor is at times (n,) [s], shape (n,) [1].

    p : creep [1] and settle [s].
    """
    creep, settle = p
    return np.asarray(1.0 - creep * np.exp(-times / settle), dtype=float)
