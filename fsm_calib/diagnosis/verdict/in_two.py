"""Would two neighbours do together what one effect stands in for? Then they take its place.

A round takes what wins it alone. An effect of several numbers may do the better part of what two of its neighbours do
together, and beside it neither has anything left to say. In MuJoCo wide rigid wheels resist a robot's turning, dry
friction of its drive train its driving: a caster whose two ways resist by themselves won 824 units of log-likelihood
where the scrub won 606 and the friction less, and both together are 139 above it. So each effect of two numbers or more
is held against its strongest neighbour in its place, with one more beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked, strongest
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.verdict.selection import Selection, Selector
from fsm_calib.diagnosis.verdict.spared import declare_each_other
from fsm_calib.diagnosis.verdict.swapped import bank_without, is_better, rounds_won
from fsm_calib.world2d.effects import registry

NUMBERS = 2  # that an effect has at least which stands in for two


def likelier_in_two(selector: Selector, selection: Selection) -> Selection:
    """Return the selection with two neighbours in an effect's place where that is likelier, grown on; else as it is."""
    for one, less in zip(selection.effects, selection.dropped, strict=True):
        pair = _two_instead(selector, selection, one, less)
        if pair:
            effects = (*(e for e in selection.effects if e is not one), *pair)
            return selector.grown_from(effects, pair[-1].fit, selection.rankings)
    return selection


def _two_instead(
    selector: Selector, selection: Selection, one: Ranked, less: Fit
) -> tuple[Ranked, Ranked] | None:
    """Return the neighbours of an effect that do better in its place; None where none do.

    less : the fit without the effect.
    """
    rest = [e for e in selection.effects if e is not one]
    near = _neighbours(selector, selection, one, rest)
    if len(one.hypothesis.names) < NUMBERS or len(near) < 2:
        return None
    engine, whole = selector.engine, selection.fit
    first = bank_without(engine, whole, less).best_of(registry()[near[0].name])
    if first is None or first.gain <= 0.0:
        return None
    bank, names = bank_without(engine, whole, first.fit), {r.name for r in near}
    further = [e for e in selector.beside((*rest, first)) if e.name in names]
    second = strongest(found for found in map(bank.best_of, further) if found)
    if second is None:
        return None
    fit = selector.with_noise(second.fit)
    if not is_better(engine, fit, whole):
        return None
    return replace(near[0], hypothesis=first.hypothesis, fit=fit), replace(second, fit=fit)


def _neighbours(
    selector: Selector, selection: Selection, one: Ranked, rest: Sequence[Ranked]
) -> list[Ranked]:
    """Return what declares an effect as its rival, or the other way, was detected where it won, and may join the rest,
    strongest first.
    """
    free = {e.name for e in selector.beside(rest)}
    rounds = rounds_won(one.name, selection.rankings) or selection.rankings[-1:]
    return [
        r
        for r in rounds[-1]
        if r.evidence > selector.needed and r.name in free and declare_each_other(one.name, r.name)
    ]
