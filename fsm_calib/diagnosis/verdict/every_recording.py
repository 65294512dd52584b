"""An event of one recording counts with what happened of its kind in the others: others explain all of them, too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.verdict.event_times import timed


def in_every_recording(
    engine: Engine, ranked: Ranked, needed: float, is_told: Callable[[Ranked], bool]
) -> Ranked:
    """Return an event with what happened of its kind in the other recordings, begins and ends sought along the clock.

    needed : evidence that each must have; is_told : whether one is what its name says. Other effects are returned as
    they are.
    """
    event = ranked.hypothesis
    if event.run == ALL_RUNS:
        return ranked
    for run in range(len(engine.simulators)):
        if run != event.run:
            found = Bank.on(engine, ranked.fit).again(event, run)
            if found is not None and found.evidence >= needed and is_told(found):
                ranked = _with(ranked, found.evidence, found.gain, found)
    found = replace(ranked, fit=timed(engine, ranked.fit, ranked.name))
    won = found.fit.score - ranked.fit.score
    return _with(ranked, 2.0 * won, won, found) if won > 0.0 and is_told(found) else ranked


def _with(ranked: Ranked, evidence: float, gain: float, found: Ranked) -> Ranked:
    """Return an event with the fit of what was found besides, and what that wins."""
    return replace(ranked, fit=found.fit, evidence=ranked.evidence + evidence, gain=ranked.gain + gain)
