"""Rivals of the effect that leads a ranking, sought again from where it has the base robot.

A base robot that lacks a strong effect bends: its gains come apart, its lags grow, its grip rests at a bound. The fits
of all effects start there, and one that would explain as much as the leader may not find its way back. (Laps of a real
Duckiebot: scrubbing tyres had 555, an overcompensated dead zone 15 from the bent base, and 575 from the leader's.)
Assumes that what stands for one effect in its rivals stands for it best beside nearly the same base.
"""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.diagnosis.candidates.plausible import plausible_of
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import noise_names
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.world2d.effects import Effect, registry

NEAR = 0.9  # of the leader's evidence: a rival that has so much has found its way


def sought_again(
    engine: Engine, base: Fit, ranking: Sequence[Ranked], effects: Sequence[Effect]
) -> list[Ranked]:
    """Return a ranking on top of the base, sorted again, with its leader's rivals where they do best.

    effects : the catalogue that may be asked.
    """
    leader = ranking[0]
    near = {r.name for r in ranking if r.evidence > NEAR * leader.evidence}
    asked = [
        e for e in effects if e.name in registry()[leader.name].rivals and not e.scan and e.name not in near
    ]
    values = switched_off(leader.fit.values, [leader.name])
    bare = engine.fit(values, base.slots, leader.fit.noise, steps=0)
    bank = Bank.on(engine, bare)
    return with_better(engine, ranking, ended_on(bank, base, bank.rank(asked)))


def ended_on(bank: Bank, base: Fit, found: Sequence[Ranked]) -> list[Ranked]:
    """Return what a bank has found fitted to its end, with its evidence over the base."""
    names = noise_names(bank.engine.simulators)
    return bank.side_by_side(lambda ranked: polished(bank.engine, ranked, base, names), found)


def with_better(
    engine: Engine, ranking: Sequence[Ranked], found: Sequence[Ranked], by: float = 0.0
) -> list[Ranked]:
    """Return a ranking, sorted again, with what was found in the place of what has less evidence `by` so much.

    What is no finding takes the place of none that is one.
    """
    had = {ranked.name: ranked for ranked in ranking}
    for ranked in found:
        known = had.setdefault(ranked.name, ranked)
        forms = plausible_of([known, ranked], engine.simulators)
        if ranked in forms and (known not in forms or ranked.evidence > known.evidence + by):
            had[ranked.name] = ranked
    return sorted(had.values(), key=lambda ranked: -ranked.evidence)
