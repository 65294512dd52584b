r"""What data leave open beside an explanation: further effects of a size that matters, and that it holds only here.

A further effect is simulated at sizes s (shares of the size that its fits begin at, both signs where it has both).
Its columns x(s), whitened and without what the fitted numbers could take over, win

    ln L(s) = x' r - x' x / 2,      odds = mean over s of exp(ln L(s) / TEMPER)

against the explanation without it [1], with the residual r. A size that would have shown has odds near zero, one that
these drives could not show keeps those it had before: odds are Bayes factors with all sizes alike before (Kass &
Raftery, J. Am. Stat. Assoc. 90 (1995) 773). A size that changes these drives by nothing at all counts only where none
of them does: another drive may.

Where all that an effect explained lies within a disc, it may be the floor's there: that outside the disc nothing is
missing has lost half of the whitened power that the effect explains outside, over TEMPER [nat].
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, hypotheses_of, scaled, shown_by
from fsm_calib.diagnosis.candidates.starts import Prober
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.shapes.score_tests import project
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table

TEMPER = 3.0  # evidence is divided by it: likelihoods of inexact equations are over-confident by so much
SIZES = (0.2, 0.4, 0.7, 1.0)  # of the usual size: a smaller one changes no drive by more than its noise
SIZE_SPREAD = 0.3  # of a size: they lie so far apart
NO_POWER = 1e-9  # whitened and squared: the drives are the same
SPOT = 0.3  # m: radius of a spot on the floor, the wheels at half an axle beside the middle


@dataclass(frozen=True, slots=True)
class Doubt:
    """A further effect: parameter of its strength, the value it may have, its spread, log odds of its presence given
    that it was as likely as not.
    """

    effect: str
    parameter: str
    values: dict[str, float]
    spread: float
    log_odds: float


def further_effects(prober: Prober) -> Iterator[Doubt]:
    """Yield what may be there beside the fit of `prober`; effects of a place or a moment are left out."""
    active = parameter_table().active_effects(prober.parent.values[0])
    for effect in shown_by(registry().values(), prober.simulators):
        if effect.scan or effect.family == "base" or effect.name in active:
            continue
        doubt = _doubt(prober, effect)
        if doubt is not None:
            yield doubt


def _doubt(prober: Prober, effect: Effect) -> Doubt | None:
    """Return how likely an effect is, and at which size; None where nothing of it has a size."""
    runs = len(prober.simulators)
    changes = declared_starts(next(hypotheses_of(effect, runs)))[0]
    strength = next((n for n in effect.strengths if f"{effect.name}.{n}" in changes), None)
    if strength is None:
        return None
    full, entry = f"{effect.name}.{strength}", effect.parameter(strength)
    tried = [scaled(effect, changes, sign * share) for share in SIZES for sign in (1.0, -1.0)]
    tried = [values for values in tried if values[full] != entry.null]
    if not tried:
        return None
    power, won = np.array([_told(prober, values) for values in tried]).T
    shown = power > NO_POWER if np.any(power > NO_POWER) else np.ones(len(tried), dtype=bool)
    won = np.where(shown, won / TEMPER, -math.inf)
    best = int(np.argmax(won))
    odds = np.exp(won - won[best])
    sizes = np.array([values[full] for values in tried])
    weights = odds * (np.sign(sizes - entry.null) == np.sign(sizes[best] - entry.null))
    weights /= weights.sum()
    mean = float(weights @ sizes)
    spread = math.hypot(math.sqrt(float(weights @ (sizes - mean) ** 2)), SIZE_SPREAD * abs(mean - entry.null))
    log_odds = float(won[best]) + math.log(float(odds.sum()) / float(shown.sum()))
    return Doubt(effect.name, strength, tried[best] | {full: mean}, spread, log_odds)


def _told(prober: Prober, changes: dict[str, float]) -> tuple[float, float]:
    """Return the whitened power of a change and the log-likelihood that it wins, the fitted numbers free."""
    columns = prober.columns(with_values(prober.parent.values, changes))
    x = project(prober.residual, columns)[:, 0]
    power = float(x @ x)
    return power, float(x @ prober.residual.psi) - 0.5 * power


def shown_where(prober: Prober, values: FloatArray) -> tuple[FloatArray, float]:
    """Return the centre (x, y) [m] of the spot where an explanation shows most in the drives so far, and the log odds
    that it holds only within `SPOT` of it.

    prober : of the base robot; values : (R, p) parameters of the explanation. The centre is that of the whitened power
    of what it changes, the base re-fitted.
    """
    told = project(prober.residual, prober.columns(values))[:, 0] ** 2
    whiteners = prober.residual.whiteners
    places = np.concatenate([w.prepared.reference[np.nonzero(w.prepared.scored)[0], :2] for w in whiteners])
    centre = told @ places / max(float(told.sum()), 1e-300)
    outside = np.hypot(*(places - centre).T) > SPOT
    return centre, -0.5 * float(told[outside].sum()) / TEMPER
