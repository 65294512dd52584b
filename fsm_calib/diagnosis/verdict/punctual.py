"""Would an effect do what a jitter of the commands does? Then the commands are punctual, and the effect is there.

A slippery spot shows where the commands change, and a noise of lateness takes a good part of it: one on a Drake robot
was lost to a jitter of 7 ms, though with punctual commands it explains 41 units of log-likelihood more. So a selection
whose commands have a clear jitter is grown once more without, and the likelier of the two stands. A jitter that is one
does the job of several effects, none of which does its own: rounds end where the strongest that would join wins less
than what each would have to win on average to reach what the jitter does.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.jitter import is_clear, without_jitter
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.verdict.selection import Selection, Selector


def likelier_if_punctual(selector: Selector, selection: Selection) -> tuple[Selector, Selection]:
    """Return the selection grown on without a jitter where that is likelier, with its selector; else both as given."""
    if not is_clear(selection.fit):
        return selector, selection
    engine, punctual = selector.engine, _for_punctual(selector)
    bare = without_jitter(engine, selection.fit)
    reaching = replace(punctual, goal=selection.fit.score)
    other = reaching.grown_from(selection.effects, bare, selection.rankings)
    likelier = evidence_of(other.fit, selection.fit, engine.count) > 0.0
    return (punctual, other) if likelier else (selector, selection)


def ranked_if_punctual(
    selector: Selector, bank: Bank, ranking: list[Ranked]
) -> tuple[Selector, Bank, list[Ranked]]:
    """Return selector, bank and ranking without a jitter where its first effect does more; else all three as given.

    Asked where nothing is detected beside the jitter.
    """
    if not is_clear(selector.base) or (ranking and ranking[0].evidence >= selector.needed):
        return selector, bank, ranking
    engine, punctual = selector.engine, _for_punctual(selector)
    other, found = punctual.first_ranked()
    if found and evidence_of(found[0].fit, selector.base, engine.count) > 0.0:
        return punctual, other, found
    return selector, bank, ranking


def _for_punctual(selector: Selector) -> Selector:
    """Return the selector on the base robot whose commands are punctual."""
    return replace(selector, base=without_jitter(selector.engine, selector.base))
