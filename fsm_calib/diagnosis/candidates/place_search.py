"""Where exactly is a patch? A search over the floor by simulation, once the place effect is named.

A slide is chaotic, so that the likelihood of a slippery patch is rugged in its centre and size, and a fit by
derivatives stays in the first hollow (tens of log-likelihood units below the best, measured). Centres and sizes are
drawn about the fit, judged by simulation with all other numbers held, drawn again closer and closer about the best,
and the fit goes on from the very best: the cross-entropy method (Rubinstein & Kroese, The Cross-Entropy Method, 2004,
chapter 5) in three rounds. The result is never worse than what it starts from.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.replay.robot_size import robot_size
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SPREADS = (0.12, 0.03, 0.01)  # m, standard deviations of a small robot's centres, round by round
SIZE_PER_METRE = 2.5  # standard deviation of a size's logarithm for each metre of that of the centre [1/m]
DRAWN, ELITE = 144, 6  # candidates of a round, and how many of all so far the next is drawn about
STEPS = 8


def placed(engine: Engine, fit: Fit, effects: Sequence[Ranked], rng: np.random.Generator) -> Fit:
    """Return the fit with each place effect where the likelihood is largest."""
    for ranked in effects:
        if registry()[ranked.name].scan == "place":
            fit = _searched(engine, fit, ranked, rng)
    return fit


def _searched(engine: Engine, fit: Fit, ranked: Ranked, rng: np.random.Generator) -> Fit:
    drawn, likelihood = fit.values[:1], np.array([fit.log_likelihood])
    size = robot_size(float(engine.simulators[0].prepared.geometry[0]))
    for spread in SPREADS:
        best = drawn[np.argsort(-likelihood)[:ELITE]]
        more = _drawn(best, ranked, spread, DRAWN // len(best), rng, size)
        drawn = np.concatenate([drawn, more])
        likelihood = np.append(likelihood, _judged(engine, fit, more))
    winner = drawn[int(np.argmax(likelihood))]
    if float(likelihood.max()) <= fit.log_likelihood:
        return fit
    values = np.where(_own_places(ranked), winner, fit.values)
    tried = engine.fit(values, fit.slots, fit.noise, steps=STEPS, refresh=True)
    return tried if tried.score > fit.score else fit


def _own_places(ranked: Ranked) -> np.ndarray:
    """Return which numbers (p,) the search moves: the free centre and sizes of the effect."""
    table, effect = parameter_table(), registry()[ranked.name]
    moved = np.zeros(len(table.names), dtype=bool)
    for name in ranked.hypothesis.names:
        p = effect.parameter(name)
        moved[table.place(f"{ranked.name}.{name}")] = not p.strength and p.unit == "m"
    return moved


def _drawn(
    about: FloatArray,
    ranked: Ranked,
    spread: float,
    count: int,
    rng: np.random.Generator,
    size: float,
) -> FloatArray:
    """Return `count` vectors about each of `about` (k, p): centres moved by `size` times `spread` [m], sizes by a
    factor; size : of the robot, as `robot_size` tells it.
    """
    table = parameter_table()
    drawn = np.repeat(about, count, axis=0)
    for place in np.flatnonzero(_own_places(ranked)):
        entry, noise = table.entries[place], rng.normal(size=len(drawn))
        if entry.name in ("x", "y"):
            drawn[:, place] += size * spread * noise
        else:
            drawn[:, place] *= np.exp(SIZE_PER_METRE * spread * noise)
        drawn[:, place] = np.clip(drawn[:, place], entry.low, entry.high)
    return drawn


def _judged(engine: Engine, fit: Fit, drawn: FloatArray) -> FloatArray:
    """Return the log-likelihood (m,) of all recordings with the places `drawn` (m, p); phases stay their own."""
    whiteners, total = engine.whiteners(fit.noise), np.zeros(len(drawn))
    shared = np.all(fit.values == fit.values[:1], axis=0)
    for run, own in enumerate(fit.values):
        total += engine.of_recording(run, whiteners, np.where(shared, drawn, own))
    return total
