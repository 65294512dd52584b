"""A belief from how much each of a few straight drives turned: too little for a diagnosis, enough to plan one.

Each effect is rolled out under the commands of the run; what it turns the robot by in drive i is g_i. The turns y are
then Gaussian,

    y_i = c s_i + a g_i + e_i,    c ~ N(0, RATIO / L),  a ~ N(0, 1),  e_i ~ N(0, sd_i^2 + OWN_TURN^2),

with s_i the way: a wrong wheel ratio turns every drive alike, and no effect is named for what one number can mend. An
effect's evidence is the mean over its declared starts and phases, tempered as a diagnosis' is. What happens at one
place or moment turns one drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, hypotheses_of
from fsm_calib.diagnosis.design.belief import Belief, kept
from fsm_calib.diagnosis.design.belief_of import prior_belief
from fsm_calib.diagnosis.design.odds import TEMPER
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive, simulate_many

OWN_TURN = 0.004
"""What a drive of 0.13 m turns by that no later one repeats [rad]: robots without an effect scatter by so much."""
RATIO = 0.05
"""By so much a k may be wrong before it is looked at [1]."""
ROLL_OUT = 0.5
"""How long after its stop a drive still turns [s]."""
ONCE = "once"
"""The explanation by something that happened at one place or moment: a push, a spot on the floor, a turned marker."""
TRUST = 0.8
"""How far a handful of numbers is trusted when a drive is planned [1]; the rest is what was believed before."""
PLANNED = 8
"""Explanations that a drive is planned to tell apart."""


@dataclass(frozen=True, eq=False)
class Straights:
    """Straight drives: when each began and stopped (n,) [s], its way [m], how far it turned, and the error [rad]."""

    begin: FloatArray
    stop: FloatArray
    way: FloatArray
    turned: FloatArray
    sd: FloatArray


@dataclass(frozen=True, eq=False)
class TurnBelief:
    """What straights tell: probabilities by name, the likeliest first ("" nothing, `ONCE`, effects); and the belief in
    what a drive can tell apart, without `ONCE`.
    """

    probabilities: tuple[tuple[str, float], ...]
    belief: Belief


def belief_of_turns(straights: Straights, commands: Drive, facts: RobotFacts, ratio: float) -> TurnBelief:
    """Return what straights tell of a robot that drives about straight with wheel ratio `ratio`.

    commands : all since the run began. facts : the robot's axle and speed.
    """
    prior = prior_belief(robot=facts)
    plain = _driving_straight(prior.plain, ratio)
    tried = [("", [plain]), *((e.name, _variants(e, plain)) for e in _effects(prior))]
    rows = np.array([row for _, group in tried for row in group])
    turns = _turns(rows, commands, straights)
    evidence, first = dict[str, float](), 0
    for name, group in tried:
        shapes = turns[first : first + len(group)] - turns[0]
        evidence[name] = _mean([_log_evidence(straights, facts, shape) for shape in shapes])
        first += len(group)
    singles = np.eye(len(straights.turned)) * np.abs(straights.turned).max()
    evidence[ONCE] = _mean([_log_evidence(straights, facts, shape) for shape in singles])
    weights = {h.label if h.names else "": h.probability for h in prior.hypotheses}
    weights[ONCE] = float(np.mean([p for name, p in weights.items() if name]))
    return _weighed(prior, evidence, weights)


def _weighed(prior: Belief, evidence: dict[str, float], weights: dict[str, float]) -> TurnBelief:
    """Return the posterior of evidence and prior weights; the belief to plan with trusts it by `TRUST`."""
    top = max(evidence.values())
    p = {name: weights[name] * math.exp((evidence[name] - top) / TEMPER) for name in evidence}
    total = sum(p.values())
    found = tuple(sorted(((name, value / total) for name, value in p.items()), key=lambda row: -row[1]))
    shares = dict(found)
    hypotheses = [
        replace(h, probability=TRUST * shares["".join(h.names)] + (1.0 - TRUST) * h.probability)
        for h in prior.hypotheses
    ]
    return TurnBelief(found, replace(prior, hypotheses=kept(hypotheses, PLANNED)))


def _effects(prior: Belief) -> list[Effect]:
    return [registry()[h.names[0]] for h in prior.hypotheses if h.names]


def _variants(effect: Effect, plain: FloatArray) -> list[FloatArray]:
    """Return the robot with the effect at each of its declared starts."""
    starts = [start for h in hypotheses_of(effect, 1) for start in declared_starts(h)]
    return [with_values(plain[None], start)[0] for start in starts]


def _driving_straight(plain: FloatArray, ratio: float) -> FloatArray:
    """Return the robot with gains that `ratio` makes equal."""
    table, values = parameter_table(), plain.copy()
    values[table.place("gain_left")] *= math.sqrt(ratio)
    values[table.place("gain_right")] /= math.sqrt(ratio)
    return values


def _turns(rows: FloatArray, commands: Drive, straights: Straights) -> FloatArray:
    """Return how far each robot (k, p) turns in each drive, shape (k, n) [rad]."""
    grid = np.unique(np.concatenate([commands.time[:1], straights.begin, straights.stop + ROLL_OUT]))
    heading = simulate_many(rows, commands, grid, (0.0, 0.0, 0.0))[:, :, 2]
    begin, end = (np.searchsorted(grid, times) for times in (straights.begin, straights.stop + ROLL_OUT))
    return np.asarray(heading[:, end] - heading[:, begin])


def _log_evidence(straights: Straights, facts: RobotFacts, shape: FloatArray) -> float:
    """Return the log density of the turns when an effect's shape (n,) [rad] has any size about its own."""
    way = straights.way * RATIO / (facts.axle_length or 0.1)
    covariance = np.diag(straights.sd**2 + OWN_TURN**2) + np.outer(way, way) + np.outer(shape, shape)
    root = np.linalg.cholesky(covariance)
    white = np.linalg.solve(root, straights.turned)
    return float(-0.5 * white @ white - np.log(np.diag(root)).sum())


def _mean(logs: list[float]) -> float:
    """Return the log of the mean of likelihoods."""
    top = max(logs)
    return top + math.log(float(np.mean(np.exp(np.array(logs) - top))))
