r"""Is it the robot, or the floor that it was driven on? A place that holds what was visited, in an effect's stead.

A robot that was driven on one mat tells nothing of its own friction: the mat resists wherever it went. Such a place has
no name, since it was hardly left (`candidates/plausible.py`), and where its edge was crossed nowhere its outline is
told by nothing. But a drive that leaves it would tell. So it is fitted from the box that holds all that was visited,
and believed in by

    log odds = log odds of an effect with the numbers that the drives tell - a / a_0 - b / b_0

a, b [m] its half sizes, a_0, b_0 [m] those that are typical; a number that the fit leaves where it began costs nothing.
Assumes that half sizes fall off exponentially, independent of each other, with the typical ones as their means.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, declared_starts
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scan_areas import Area
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.types import FloatArray
from fsm_calib.world2d.dynamics import AXLE
from fsm_calib.world2d.effects import Closure, Effect
from fsm_calib.world2d.parameters import parameter_table

LEAST_PRIOR = -8.0  # log odds: a place that must be larger than that is not asked for
MARGIN = 0.05  # m beyond the last contact that was seen: poses err, and the robot goes on between two of them
ENOUGH = 0.2  # of what the effect adds, which a place must promise before it is moved to where it does best


@dataclass(frozen=True, eq=False)
class FloorHere:
    """A place fitted in an effect's stead, its strengths alone free; with the evidence of all numbers that are told,
    and the log odds that a place is so large.
    """

    found: Ranked
    evidence: float
    prior: float


def floor_instead(engine: Engine, without: Fit, added: float, asked: Sequence[Effect]) -> Iterator[FloorHere]:
    """Yield places that hold what was visited and explain what an effect adds.

    without : the model without the effect; added : the evidence that the effect adds; asked : whose places are tried.
    """
    area = visited(engine, without)
    places = [e for e in asked if e.where == "area" and e.when == "always" and not e.jumps]
    near = [e for e in places if area is not None and prior_of(e, area.half_x, area.half_y) > LEAST_PRIOR]
    if area is None or not near:
        return
    bank = Bank.on(engine, without)
    for effect in near:
        for closure in effect.competing:
            yield from _fitted(bank, effect, closure, area, ENOUGH * added)


def visited(engine: Engine, fit: Fit) -> Area | None:
    """Return the smallest box that holds both ends of the axle wherever it was; None where poses have no places.

    Poses stand for the axle's middle; half of the axle and a margin are added on every side.
    """
    poses = [s.prepared.poses for s in engine.simulators]
    if not all(p.placed for p in poses):
        return None
    path = np.concatenate([np.column_stack([p.x, p.y]) for p in poses])
    low, high = path.min(axis=0), path.max(axis=0)
    x, y = (0.5 * (low + high)).tolist()
    half_x, half_y = (0.5 * (high - low + fit.values[0, AXLE]) + MARGIN).tolist()
    return Area(x, y, half_x, half_y, spread=1.0, roundness=0.0)


def prior_of(effect: Effect, half_x: float, half_y: float) -> float:
    """Return the log odds that a place of an effect is as large as these half sizes [m]."""
    return -half_x / effect.parameter("half_x").typical - half_y / effect.parameter("half_y").typical


def _fitted(bank: Bank, effect: Effect, closure: Closure, area: Area, least: float) -> Iterator[FloorHere]:
    """Yield a place as it is or moved to where it does best, its strengths fitted; nothing where it promises little."""
    felt = {"spread": area.spread, "roundness": area.roundness}
    own = {f"{effect.name}.{p.name}": felt[p.name] for p in effect.parameters if p.name in felt}
    where = {**area.numbers(effect), **own}
    whole = Hypothesis(effect.name, closure.frees, ALL_RUNS, 0.0, closure.name)
    choices = [{**start, **where} for start in declared_starts(whole, where)]
    (start,) = bank.prober.best_starts(whole, choices, 1)
    if 2.0 * start.promise < least:
        return
    strengths = tuple(name for name in closure.frees if effect.parameter(name).strength)
    alone = Hypothesis(effect.name, strengths, ALL_RUNS, 0.0, closure.name)
    here, moved = bank.fit(alone, start), bank.fit(whole, start)
    began, ended = (_outline(effect, values) for values in (start.values, moved.fit.values))
    evidence = moved.evidence + float(np.sum(began == ended)) * math.log(bank.engine.count)
    if evidence > here.evidence:
        found = bank.fit(alone, Start(moved.fit.values, 0.0))
        yield FloorHere(found, evidence, prior_of(effect, *ended[2:]))
    else:
        yield FloorHere(here, here.evidence, prior_of(effect, *began[2:]))


def _outline(effect: Effect, values: FloatArray) -> FloatArray:
    """Return centre and half sizes (4,) [m] of a place with parameters (R, p)."""
    table = parameter_table()
    return values[0, [table.place(f"{effect.name}.{name}") for name in ("x", "y", "half_x", "half_y")]]
