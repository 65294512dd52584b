"""An event counts with all that happened of its kind, in its recording and the others: others explain all of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fsm_calib.diagnosis.candidates.each_its_own import each_its_own
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.verdict.event_times import timed


def in_every_recording(
    engine: Engine, ranked: Ranked, needed: float, is_told: Callable[[Ranked], bool]
) -> Ranked:
    """Return an event with all that happened of its kind in any recording, begins and ends sought along the clock.

    needed : evidence that each must have; is_told : whether one is what its name says. One that came alike in every
    recording has numbers of its own in each where these tell more. Other effects are returned as they are.
    """
    if ranked.hypothesis.run == ALL_RUNS:
        own = each_its_own(engine, ranked)
        return own if own is not None and is_told(own) else ranked
    bank = Bank.on(engine, ranked.fit)  # one scan tells of all recordings until something is found
    for run in range(len(engine.simulators)):
        while (more := _again(bank, ranked, run, needed, is_told)) is not None:
            ranked, bank = more, Bank.on(engine, more.fit)
    found = replace(ranked, fit=timed(engine, ranked.fit, ranked.name))
    won = found.fit.score - ranked.fit.score
    return _with(ranked, 2.0 * won, won, found) if won > 0.0 and is_told(found) else ranked


def come_again(
    engine: Engine,
    effects: tuple[Ranked, ...],
    fit: Fit,
    needed: float,
    is_told: Callable[[Ranked], bool],
) -> tuple[tuple[Ranked, ...], Fit] | None:
    """Return the effects of a model and its fit with an event that came more often; None where none did.

    What the other effects hid when the event was found shows beside them: before a further kind of event is taken in,
    it is asked whether it is one of those that are known.
    """
    for i, effect in enumerate(effects):
        whole = in_every_recording(engine, replace(effect, fit=fit), needed, is_told)
        if whole.evidence >= effect.evidence + needed:
            return (*effects[:i], whole, *effects[i + 1 :]), whole.fit
    return None


def _again(
    bank: Bank, ranked: Ranked, run: int, needed: float, is_told: Callable[[Ranked], bool]
) -> Ranked | None:
    """Return an event with what happened of its kind in a recording besides; None where nothing did.

    bank : on top of the event's fit.
    """
    event = ranked.hypothesis
    found = bank.again(event, run)
    if found is None or found.evidence < needed or not is_told(found):
        return None
    if run == event.run:
        ranked = replace(ranked, hypothesis=replace(found.hypothesis, chance=event.chance))
    return _with(ranked, found.evidence, found.gain, found)


def _with(ranked: Ranked, evidence: float, gain: float, found: Ranked) -> Ranked:
    """Return an event with the fit of what was found besides, and what that wins."""
    return replace(ranked, fit=found.fit, evidence=ranked.evidence + evidence, gain=ranked.gain + gain)
