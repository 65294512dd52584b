"""The few candidates that matter are fitted to the end: fresh Jacobians, all noise levels, the highest hill."""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.commuted import commuted
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ridge import beyond_the_ridge
from fsm_calib.diagnosis.fitting.climb import LAST_STEPS, climbed
from fsm_calib.diagnosis.fitting.fit import Engine, Fit

POLISH_ROUNDS = 4  # fits and noise in turn
POLISHED_ENOUGH = 3.0  # log-likelihood units that another round must have won to be followed by one more


def polished(engine: Engine, ranked: Ranked, parent: Fit, noise_names: Sequence[int]) -> Ranked:
    """Fit once more with every Jacobian column fresh and all noise levels free, on the highest hill: for the few that
    matter.
    """
    fit = _settled(engine, ranked.fit, noise_names)
    for hill in (beyond_the_ridge(engine, fit, ranked.name), commuted(fit, ranked.name)):
        if hill is not None:
            there = engine.fit(hill, fit.slots, fit.noise, steps=LAST_STEPS)
            fit = max(fit, _settled(engine, there, noise_names), key=lambda found: found.score)
    fit = engine.fit(fit.values, fit.slots, fit.noise, steps=LAST_STEPS, refresh=True)
    if fit.score < ranked.fit.score:
        fit = engine.fit(ranked.fit.values, ranked.fit.slots, ranked.fit.noise, steps=0)
    return Ranked(ranked.hypothesis, fit, evidence_of(fit, parent, engine.count), fit.score - parent.score)


def _settled(engine: Engine, fit: Fit, noise_names: Sequence[int]) -> Fit:
    """Return a fit and its noise, fitted in turn until neither wins any more."""
    for _ in range(POLISH_ROUNDS):  # one suffices unless the effect carried the base robot far
        before = fit.score
        fit = engine.refit_noise(climbed(engine, fit), noise_names, 4)
        if fit.score < before + POLISHED_ENOUGH:
            break
    return fit
