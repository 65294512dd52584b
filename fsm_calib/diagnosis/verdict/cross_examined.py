"""Every effect of a model is cross-examined: forms in its place, rivals beside the others, one law in all drives.

What forms say of an effect comes first. Where that alone leaves too little for a name, nothing else is asked: rivals
and drives could only take more of it away. The strongest effect is always asked, since a verdict without a name still
says what comes nearest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from fsm_calib.diagnosis.candidates.jolts import against_patch
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.base import noise_names, settled
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.side_by_side import side_by_side
from fsm_calib.diagnosis.fitting.values import taken_over
from fsm_calib.diagnosis.proof.form_test import Remainder, contest
from fsm_calib.diagnosis.proof.gap import gap_between, gap_where_it_acts
from fsm_calib.diagnosis.proof.one_law import OneLaw, one_law
from fsm_calib.diagnosis.verdict.in_its_place import among_the_others, on_its_own_ground
from fsm_calib.diagnosis.verdict.posterior import belief_of
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.diagnosis.verdict.support import RivalGap, Support
from fsm_calib.diagnosis.verdict.turned_about import turned_about
from fsm_calib.world2d.effects import registry

TRIED_AGAIN = 3  # names that are fitted in an effect's place beside the others
OUT_OF_REACH = 0.9999  # probability with which an effect beats a rival that is not fitted to its end
MUCH = 100.0  # log-likelihood units that an effect explains: what is left without it has another noise
WORTH_ASKING = 0.3  # of the effect's evidence: a name that had less of it alone is no rival


def supports_of(engine: Engine, selection: Selection, least: float) -> tuple[Support, ...]:
    """Return the support of every effect of a selection, in its order.

    least : probability that a name must have to be said.
    """
    remainder = Remainder.of(engine, selection.fit)
    ended = [_to_its_end(engine, selection.fit, less) for less in selection.dropped]
    gaps = [
        (gap_where_it_acts if registry()[effect.name].scan else gap_between)(engine, selection.fit, less)
        for effect, less in zip(selection.effects, ended, strict=True)
    ]
    adds = [max(gap.evidence, 0.0) for gap in gaps]
    special = [not registry()[effect.name].universal for effect in selection.effects]
    found: list[Support] = []
    for i, (effect, less, added) in enumerate(zip(selection.effects, ended, gaps, strict=True)):
        share = adds[i] / max(sum(adds), 1.0)
        others = sum(adds[k] for k in range(len(adds)) if k != i and special[k])
        forms = contest(remainder, less, [effect.name])
        jolted = against_patch(engine, selection.fit, [effect.name])
        support = Support(effect, less, added, share, (), OneLaw(math.nan, ()), forms, others, jolted)
        if not found or belief_of(support).probability >= least:
            support = _examined(engine, selection, support, selection.dropped[i])
        found.append(support)
    return tuple(found)


def _to_its_end(engine: Engine, whole: Fit, less: Fit) -> Fit:
    """Return the fit without an effect, begun anew at a wide noise where much is missed.

    At the whole model's noise all that a strong effect leaves is an outlier, outliers weigh nothing, and no step leads
    on: own robots without their only effect ended 13,000 to 48,000 below the base robot that they are then.
    """
    if less.score > whole.score - MUCH:
        return less
    anew = settled(engine, less)
    return anew if anew.score > less.score else less


def _examined(engine: Engine, selection: Selection, support: Support, less: Fit) -> Support:
    """Return the support with its rivals, and with how much of it is one law; less : the fit without the effect, at
    the noise of the whole, where rivals are fitted.
    """
    fit, effect = selection.fit, support.effect
    beside = selection.beside if effect.name == _led_by(selection) else ()
    company = [RivalGap(r.name, gap_between(engine, fit, other), other) for r, other in beside]
    said = {r.name for r in company}
    found = [r for r in _in_its_place(engine, selection, effect, less) if r.name not in said]
    rivals = side_by_side(engine, partial(_rival, engine, fit, less), found, fit, less)
    ordered = tuple(sorted([*rivals, *company], key=lambda rival: rival.gap.evidence))
    law, turned = one_law(engine, less, fit, effect.name), turned_about(engine, less, fit, effect.name)
    return replace(support, rivals=ordered, law=law, turned=turned)


def _led_by(selection: Selection) -> str:
    """Return the name of the effect that led the first ranking, or of the strongest where that one has gone."""
    names = [e.name for e in selection.effects]
    led = selection.rankings[0][0].name
    return led if led in names else names[0]


def _in_its_place(engine: Engine, selection: Selection, effect: Ranked, less: Fit) -> Sequence[Ranked]:
    """Return other names fitted on top of the model without the effect.

    Each from where it was alone with all others as they are beside the effect, and from scratch; a place or a moment
    from where it was alone. The nearest neighbour that the effect declares is asked whatever it had alone: a slope
    beside dry friction had a third of what a carpet's nap had, which does the job of both.
    """
    named = {e.name for e in selection.effects}
    if len(selection.effects) == 1:
        return [r for r in selection.rankings[0] if r.name not in named and r.evidence > 0.0]
    worth = WORTH_ASKING * min(effect.evidence, selection.rankings[0][0].evidence)
    best: dict[str, Ranked] = {}
    for ranked in (r for ranking in selection.rankings for r in ranking if r.name not in named):
        if ranked.name not in best or ranked.evidence > best[ranked.name].evidence:
            best[ranked.name] = ranked
    nearest = registry()[effect.name].rivals[:1]
    asked = sorted(
        (r for r in best.values() if r.evidence > (0.0 if r.name in nearest else worth)),
        key=lambda r: (r.name not in nearest, -r.evidence),
    )[:TRIED_AGAIN]
    bank = Bank.on(engine, less)
    tried = bank.side_by_side(partial(_tried, bank, selection.fit, effect.name), asked)
    return [r for r in tried if r.evidence > 0.0]


def _rival(engine: Engine, whole: Fit, less: Fit, rival: Ranked) -> RivalGap:
    """Return how much a rival lacks; one that may come near the whole is fitted to its end as that was, all noise
    with it.
    """
    gap = gap_between(engine, whole, rival.fit)
    if gap.probability > OUT_OF_REACH:
        return RivalGap(rival.name, gap, rival.fit)
    ended = polished(engine, rival, less, noise_names(engine.simulators)).fit
    return RivalGap(rival.name, gap_between(engine, whole, ended), ended)


def _tried(bank: Bank, whole: Fit, name: str, rival: Ranked) -> Ranked:
    """Return a rival in the place of the effect `name` as it fits best: with all others as they are in the whole, with
    the robot as it was where the rival was alone, and from scratch.
    """
    found = [bank.fit(rival.hypothesis, Start(among_the_others(whole, name, rival), 0.0))]
    if registry()[rival.name].scan:
        alone = taken_over(bank.parent.values, rival.name, rival.fit.values)
        found.append(bank.fit(rival.hypothesis, Start(alone, 0.0)))
    else:
        found.append(on_its_own_ground(bank, rival, whole, name))
        found += [r for r in [bank.best_of(registry()[rival.name])] if r is not None]
    return max(found, key=lambda r: r.fit.score)
