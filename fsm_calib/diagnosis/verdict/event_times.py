"""When did an event begin and end? The likelihood along the clock, once the event is named.

The likelihood of an edge in time is no parabola: while the robot stands still, or drives without the failed motor,
every moment explains the recording alike, and a fit by derivatives stops at the first hollow. So each edge is moved
over a grid with all other numbers held, the fit goes on from the best, and the edge is told by the profile

    p(t) ~ exp((L(t) - max L) / T),    t = its median, sd = its standard deviation

L [1] log-likelihood of the recording, t [s], T a temper, since equations are inexact. Source: profile likelihood,
Pawitan, In All Likelihood, 2001, section 3.4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.ranking import Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit, simulate_all
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

REACH = 3.0  # s to either side that an edge is moved: two steps of the scan that found it
GRID = 0.1  # s
ROUNDS = 2
WORTH = 1.0  # log-likelihood units that a moved edge must win for the fit to go on from there
STEPS = 6
TEMPER = 3.0  # likelihoods along the clock are over-confident by so much (opened development robots)

Move = Callable[[float], FloatArray]


def dated(engine: Engine, fit: Fit, effects: Sequence[Ranked]) -> Fit:
    """Return the fit with the moments of its events at their profiles' medians, with the profiles' spreads."""
    for ranked in effects:
        if registry()[ranked.name].scan == "time":
            for run in fit.runs_of(ranked.name):
                there = replace(ranked, hypothesis=replace(ranked.hypothesis, run=run))
                fit = _told(engine, _sought(engine, fit, there), there)
    return fit


def _edges(ranked: Ranked) -> tuple[str, ...]:
    return tuple(name for name in ("start", "duration") if name in ranked.hypothesis.names)


def _moved(values: FloatArray, ranked: Ranked, edge: str) -> tuple[float, Move]:
    """Return where an edge stands [s] and how to put it elsewhere: the begin with the end held, or the end."""
    run, table = ranked.hypothesis.run, parameter_table()
    start, length = (table.place(f"{ranked.name}.{name}") for name in ("start", "duration"))
    begin, end = float(values[run, start]), float(values[run, start] + values[run, length])

    def move(moment: float) -> FloatArray:
        changed: FloatArray = values[run].copy()
        if edge == "start":
            changed[start] = moment
        if "duration" in ranked.hypothesis.names:
            changed[length] = end - moment if edge == "start" else moment - begin
        return changed

    return (begin if edge == "start" else end), move


def _profile(engine: Engine, fit: Fit, ranked: Ranked, edge: str) -> tuple[FloatArray, FloatArray]:
    """Return moments (m,) [s] of an edge and the log-likelihood of the recording with it there, (m,)."""
    run, table = ranked.hypothesis.run, parameter_table()
    now, move = _moved(fit.values, ranked, edge)
    moments = now + GRID * np.arange(-round(REACH / GRID), round(REACH / GRID) + 1)
    rows = np.array([move(float(moment)) for moment in moments])
    allowed = np.ones(len(rows), dtype=bool)
    for place in (table.place(f"{ranked.name}.{name}") for name in _edges(ranked)):
        entry = table.entries[place]
        allowed &= (rows[:, place] >= entry.low) & (rows[:, place] <= entry.high)
    likelihood = engine.of_recording(run, engine.whiteners(fit.noise), rows[allowed])
    return np.asarray(moments[allowed], dtype=float), likelihood


def _sought(engine: Engine, fit: Fit, ranked: Ranked) -> Fit:
    """Move the edges in turn to where the likelihood is largest, and go on fitting where that wins anything."""
    run, values, won = ranked.hypothesis.run, fit.values, 0.0
    for _ in range(ROUNDS):
        for edge in _edges(ranked):
            moments, likelihood = _profile(engine, replace(fit, values=values), ranked, edge)
            now, move = _moved(values, ranked, edge)
            best = int(np.argmax(likelihood))
            gain = float(likelihood[best] - likelihood[int(np.argmin(np.abs(moments - now)))])
            if gain > 0.0:
                values = values.copy()
                values[run] = move(float(moments[best]))
                won += gain
    if won < WORTH:
        return fit
    tried = engine.fit(values, fit.slots, fit.noise, steps=STEPS, refresh=True)
    return tried if tried.score > fit.score else fit


def _told(engine: Engine, fit: Fit, ranked: Ranked) -> Fit:
    """Put the edges at their profiles' medians and their spreads into the covariance."""
    run, table = ranked.hypothesis.run, parameter_table()
    values, covariance, variance = fit.values, fit.covariance.copy(), 0.0
    for edge in _edges(ranked):
        moments, likelihood = _profile(engine, fit, ranked, edge)
        weight = np.exp((likelihood - likelihood.max()) / TEMPER)
        weight /= weight.sum()
        median = float(np.interp(0.5, np.cumsum(weight) - 0.5 * weight, moments))
        variance += float(weight @ (moments - weight @ moments) ** 2) + GRID**2 / 12.0
        values = values.copy()
        values[run] = _moved(values, ranked, edge)[1](median)
        place = table.place(f"{ranked.name}.{edge}")
        j = next(j for j, s in enumerate(fit.slots) if s.place == place and s.run == run)
        covariance[j], covariance[:, j] = 0.0, 0.0
        covariance[j, j] = variance  # of a length: of begin and end together
    simulated = simulate_all(engine.simulators, values)
    value = engine.log_likelihood(engine.whiteners(fit.noise), simulated)
    return replace(fit, values=values, covariance=covariance, simulated=simulated, log_likelihood=value)
