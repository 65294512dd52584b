"""Rivals of the effect that leads a ranking, sought again from where it has the base robot.

A base robot that lacks a strong effect bends: its gains come apart, its lags grow, its grip rests at a bound. The fits
of all effects start there, and one that would explain as much as the leader may not find its way back. (Laps of a real
Duckiebot: scrubbing tyres had 555, an overcompensated dead zone 15 from the bent base, and 575 from the leader's.)
Assumes that what stands for one effect in its rivals stands for it best beside nearly the same base.
"""

from __future__ import annotations

from collections.abc import Sequence

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
    had = {r.name: r for r in ranking}
    near = {n for n, r in had.items() if r.evidence > NEAR * leader.evidence}
    asked = [
        e for e in effects if e.name in registry()[leader.name].rivals and not e.scan and e.name not in near
    ]
    values = switched_off(leader.fit.values, [leader.name])
    bare = engine.fit(values, base.slots, leader.fit.noise, steps=0)
    bank, names = Bank.on(engine, bare), noise_names(engine.simulators)
    for told in bank.side_by_side(lambda found: polished(engine, found, base, names), bank.rank(asked)):
        if told.name not in had or told.evidence > had[told.name].evidence:
            had[told.name] = told
    return sorted(had.values(), key=lambda r: -r.evidence)
