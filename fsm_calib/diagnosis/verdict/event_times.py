"""When did an event begin and end? The likelihood along the clock, once the event is named.

The likelihood of an edge in time is no parabola: while the robot stands still, or drives without the failed motor,
every moment explains the recording alike, and a fit by derivatives stops at the first hollow. So each edge is moved
over a grid with all other numbers held, the fit goes on from the best, and the edge is told by the profile

    p(t) ~ exp((L(t) - max L) / T),    t = its median, sd = its standard deviation

L [1] log-likelihood of the recording, t [s], T a temper, since equations are inexact. Source: profile likelihood,
Pawitan, In All Likelihood, 2001, section 3.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit, simulate_all
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.numbered import length_of, starts_in
from fsm_calib.world2d.parameters import parameter_table

REACH = 3.0  # s to either side that an edge is moved: two steps of the scan that found it
GRID = 0.1  # s
ROUNDS = 2
WORTH = 1.0  # log-likelihood units that a moved edge must win for the fit to go on from there
STEPS = 6
TEMPER = 3.0  # likelihoods along the clock are over-confident by so much (opened development robots)


@dataclass(frozen=True, slots=True)
class Edge:
    """Begin or end of an event in one recording: where its begin and its length stand in the parameters.

    lasts : whether the length is free, so that the other edge stays where it is; is_end : which edge this is.
    """

    run: int
    start: int
    length: int
    lasts: bool
    is_end: bool

    @property
    def place(self) -> int:
        """Where the number that tells this edge stands."""
        return self.length if self.is_end else self.start

    def of(self, values: FloatArray) -> float:
        """Return when the edge is [s] by parameters (R, p)."""
        row = values[self.run]
        return float(row[self.start] + row[self.length] if self.is_end else row[self.start])

    def at(self, values: FloatArray, moment: float) -> FloatArray:
        """Return the recording's parameters (p,) with the edge at a moment [s], the other edge where it is."""
        changed: FloatArray = values[self.run].copy()
        end = float(changed[self.start] + changed[self.length])
        if self.is_end:
            changed[self.length] = moment - changed[self.start]
            return changed
        changed[self.start] = moment
        if self.lasts:
            changed[self.length] = end - moment
        return changed


def dated(engine: Engine, fit: Fit, effects: Sequence[Ranked]) -> Fit:
    """Return the fit with the moments of its events at their profiles' medians, with the profiles' spreads."""
    for name in (ranked.name for ranked in effects if registry()[ranked.name].scan == "time"):
        for run in fit.runs_of(name):
            edges = list(edges_of(fit, name, run))
            fit = _told(engine, _sought(engine, fit, edges), edges)
    return fit


def timed(engine: Engine, fit: Fit, name: str) -> Fit:
    """Return the fit with begins and ends of an event moved along the clock to where each recording is likeliest."""
    for run in fit.runs_of(name):
        fit = _sought(engine, fit, list(edges_of(fit, name, run)))
    return fit


def edges_of(fit: Fit, name: str, run: int) -> Iterator[Edge]:
    """Yield the free edges of an event of one recording, of each time that it happened there."""
    table = parameter_table()
    free = {slot.place for slot in fit.slots if slot.run == run}
    for begin in starts_in(p.name for p in registry()[name].parameters):
        start, length = (table.place(f"{name}.{n}") for n in (begin, length_of(begin)))
        if start in free:
            yield Edge(run, start, length, length in free, is_end=False)
        if length in free:
            yield Edge(run, start, length, lasts=True, is_end=True)


def _profile(engine: Engine, fit: Fit, edge: Edge) -> tuple[FloatArray, FloatArray]:
    """Return moments (m,) [s] of an edge and the log-likelihood of the recording with it there, (m,)."""
    table = parameter_table()
    moments = edge.of(fit.values) + GRID * np.arange(-round(REACH / GRID), round(REACH / GRID) + 1)
    rows = np.array([edge.at(fit.values, float(moment)) for moment in moments])
    allowed = np.ones(len(rows), dtype=bool)
    for place in (edge.start, edge.length) if edge.lasts else (edge.start,):
        entry = table.entries[place]
        allowed &= (rows[:, place] >= entry.low) & (rows[:, place] <= entry.high)
    likelihood = engine.of_recording(edge.run, engine.whiteners(fit.noise), rows[allowed])
    return np.asarray(moments[allowed], dtype=float), likelihood


def _sought(engine: Engine, fit: Fit, edges: Sequence[Edge]) -> Fit:
    """Move the edges in turn to where the likelihood is largest, and go on fitting where that wins anything."""
    values, won = fit.values, 0.0
    for _ in range(ROUNDS):
        for edge in edges:
            moments, likelihood = _profile(engine, replace(fit, values=values), edge)
            best = int(np.argmax(likelihood))
            gain = float(likelihood[best] - likelihood[int(np.argmin(np.abs(moments - edge.of(values))))])
            if gain > 0.0:
                row, values = edge.at(values, float(moments[best])), values.copy()
                values[edge.run] = row
                won += gain
    if won < WORTH:
        return fit
    tried = engine.fit(values, fit.slots, fit.noise, steps=STEPS, refresh=True)
    return tried if tried.score > fit.score else fit


def _told(engine: Engine, fit: Fit, edges: Sequence[Edge]) -> Fit:
    """Put the edges at their profiles' medians and their spreads into the covariance."""
    values, covariance = fit.values, fit.covariance.copy()
    spread: dict[int, float] = {}
    for edge in edges:
        moments, likelihood = _profile(engine, fit, edge)
        weight = np.exp((likelihood - likelihood.max()) / TEMPER)
        weight /= weight.sum()
        median = float(np.interp(0.5, np.cumsum(weight) - 0.5 * weight, moments))
        variance = float(weight @ (moments - weight @ moments) ** 2) + GRID**2 / 12.0
        spread[edge.place] = variance + (spread.get(edge.start, 0.0) if edge.is_end else 0.0)
        row, values = edge.at(values, median), values.copy()
        values[edge.run] = row
        j = next(j for j, s in enumerate(fit.slots) if (s.place, s.run) == (edge.place, edge.run))
        covariance[j], covariance[:, j] = 0.0, 0.0
        covariance[j, j] = spread[edge.place]  # of a length: of begin and end together
    simulated = simulate_all(engine.simulators, values)
    value = engine.log_likelihood(engine.whiteners(fit.noise), simulated)
    return replace(fit, values=values, covariance=covariance, simulated=simulated, log_likelihood=value)
