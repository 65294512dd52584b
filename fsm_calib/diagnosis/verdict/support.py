"""What speaks for a named effect and against it, given everything else that the model has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.hypotheses import Start, is_event
from fsm_calib.diagnosis.candidates.ranking import Bank, Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.form_test import Contest, contest
from fsm_calib.diagnosis.proof.gap import Gap, gap_between
from fsm_calib.diagnosis.proof.one_law import OneLaw, one_law
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

HOPELESS = (
    1.0  # times what an effect adds that forms explain beside it: no name comes of it, and no rival is asked
)
TRIED_AGAIN = 3  # names that are fitted in an effect's place beside the others
WORTH_ASKING = 0.3  # of the effect's evidence: a name that had less of it alone is no rival


@dataclass(frozen=True, slots=True)
class RivalGap:
    """Another name in an effect's place: how much evidence it lacks, and the fit with it."""

    name: str
    gap: Gap
    fit: Fit


@dataclass(frozen=True, eq=False)
class Support:
    """What is known about one effect of a model.

    effect : as it stands in the model; without : the model without it, re-fitted; added : evidence over that; rivals :
    names fitted in its place, nearest first; law : is it one in all drives; forms : un-named forms in its place, and
    beside the whole model.
    """

    effect: Ranked
    without: Fit
    added: Gap
    rivals: tuple[RivalGap, ...]
    law: OneLaw
    forms: Contest

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    @property
    def left(self) -> float:
        """What un-named forms beside the whole model explain, as a share of what the effect adds."""
        return max(self.forms.beside, 0.0) / max(self.added.evidence, 1.0)

    @property
    def replaced(self) -> float:
        """How much better forms do in the effect's place than the effect, as a share of it; what they add to it is
        no argument.
        """
        return (self.forms.instead - max(self.forms.beside, 0.0)) / max(self.added.evidence, 1.0)

    @property
    def interchangeable(self) -> float:
        """How much of the effect's own job un-named forms could do, 0 to 1.

        What is left is held against a name as far as the forms that explain it could stand for the name: a remainder
        of another kind says that something is missing, not that this name is wrong. An event is no job: whatever is
        missing may show most in one second.
        """
        share = 1.0 + self.forms.instead / max(self.added.evidence, 1.0)
        return 1.0 if is_event(registry()[self.name]) else min(max(share, 0.0), 1.0)

    @property
    def moved(self) -> float:
        """The share of the effect that is another one in each drive, 0 where that cannot be asked."""
        return self.law.moved if math.isfinite(self.law.moved) else 0.0


def supports_of(engine: Engine, selection: Selection) -> tuple[Support, ...]:
    """Return the support of every effect of a selection, in its order."""
    return tuple(
        _support(engine, selection, effect, less)
        for effect, less in zip(selection.effects, selection.dropped, strict=True)
    )


def _support(engine: Engine, selection: Selection, effect: Ranked, less: Fit) -> Support:
    fit = selection.fit
    added, forms = gap_between(engine, fit, less), contest(engine, less, fit, [effect.name])
    if len(selection.effects) > 1 and forms.beside > HOPELESS * max(added.evidence, 1.0):
        return Support(effect, less, added, (), OneLaw(math.nan, ()), forms)
    first = effect.name == _led_by(selection)
    company = {
        r.name: RivalGap(r.name, gap_between(engine, fit, other), other) for r, other in selection.beside
    }
    rivals = [
        RivalGap(r.name, gap_between(engine, fit, r.fit), r.fit)
        for r in _in_its_place(engine, selection, effect, less)
    ]
    if first:
        rivals = [r for r in rivals if r.name not in company] + list(company.values())
    return Support(
        effect,
        less,
        added,
        tuple(sorted(rivals, key=lambda rival: rival.gap.evidence)),
        one_law(engine, less, fit, effect.name),
        forms,
    )


def _led_by(selection: Selection) -> str:
    """Return the name of the effect that led the first ranking, or of the strongest where that one has gone."""
    names = [e.name for e in selection.effects]
    led = selection.rankings[0][0].name
    return led if led in names else names[0]


def _in_its_place(engine: Engine, selection: Selection, effect: Ranked, less: Fit) -> Sequence[Ranked]:
    """Return other names fitted on top of the model without the effect, from scratch and from where each was alone."""
    named = {e.name for e in selection.effects}
    if len(selection.effects) == 1:
        return [r for r in selection.rankings[0] if r.name not in named and r.evidence > 0.0]
    worth = WORTH_ASKING * min(effect.evidence, selection.rankings[0][0].evidence)
    best: dict[str, Ranked] = {}
    for ranked in (r for ranking in selection.rankings for r in ranking if r.name not in named):
        if ranked.name not in best or ranked.evidence > best[ranked.name].evidence:
            best[ranked.name] = ranked
    asked = sorted((r for r in best.values() if r.evidence > worth), key=lambda r: -r.evidence)[:TRIED_AGAIN]
    bank, tried = Bank.on(engine, less), []
    for rival in asked:
        found = [bank.fit(rival.hypothesis, Start(_moved_in(less, rival), 0.0))]
        if not registry()[rival.name].scan:  # a place or a moment is known from where it was alone
            found += [r for r in [bank.best_of(registry()[rival.name])] if r is not None]
        tried.append(max(found, key=lambda r: r.fit.score))
    return [r for r in tried if r.evidence > 0.0]


def _moved_in(less: Fit, rival: Ranked) -> FloatArray:
    """Return the parameters (R, p) of a model with a rival's own numbers as another fit has them."""
    table, values = parameter_table(), less.values.copy()
    own = list(table.of_effect(rival.name))
    values[:, own] = rival.fit.values[:, own]
    return values
