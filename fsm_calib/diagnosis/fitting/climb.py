"""A fit goes on as long as it climbs: along a curved valley a few Gauss-Newton steps do not reach the end.

Where two numbers do nearly the same, as a motor's gain K and the offset d that its driver adds to a command u,
w = K (u + |d|), the likelihood is a curved ridge (K ~ 1 / (u + |d|)), of which a step follows the tangent. (Laps of a
real Duckiebot, from d = -0.04: 226 units of evidence after twelve steps, at d = -0.17; 480 at -0.77, where the ridge
ends.)
"""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.valley import along_the_valley
from fsm_calib.types import FloatArray

LAST_STEPS = 6  # Gauss-Newton steps; in most cases the last one wins next to nothing
STILL_CLIMBING = 3.0  # log-likelihood units that they must have won for the fit to go on along the valley


def last_steps(engine: Engine, fit: Fit, known: Sequence[FloatArray] | None = None) -> Fit:
    """Return a fit with what more Gauss-Newton steps win, at its noise.

    known : raw columns (n, 5, q) of the first q slots, computed nearby.
    """
    return engine.fit(fit.values, fit.slots, fit.noise, known=known, steps=LAST_STEPS)


def still_climbs(won: float) -> bool:
    """Return whether a fit whose last steps won so much log-likelihood goes on along a valley."""
    return won >= STILL_CLIMBING


def to_its_end(engine: Engine, fit: Fit) -> Fit:
    """Return a fit that still climbs where its valley ends."""
    return engine.fit(along_the_valley(engine, fit), fit.slots, fit.noise, steps=LAST_STEPS)


def climbed(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with all that climbing wins, at its noise."""
    found = last_steps(engine, fit)
    return to_its_end(engine, found) if still_climbs(found.score - fit.score) else found
