"""What speaks for a named effect and against it, given everything else that the model has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranking import Bank, Ranked
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.form_test import Contest, contest
from fsm_calib.diagnosis.proof.gap import Gap, gap_between
from fsm_calib.diagnosis.proof.one_law import OneLaw, one_law
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.world2d.effects import registry

TRIED_AGAIN = 4  # names that are fitted in an effect's place beside the others
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
    rivals = [
        RivalGap(r.name, gap_between(engine, fit, r.fit), r.fit)
        for r in _in_its_place(engine, selection, effect, less)
    ]
    return Support(
        effect,
        less,
        gap_between(engine, fit, less),
        tuple(sorted(rivals, key=lambda rival: rival.gap.evidence)),
        one_law(engine, less, fit, effect.name),
        contest(engine, less, fit, [effect.name]),
    )


def _in_its_place(engine: Engine, selection: Selection, effect: Ranked, less: Fit) -> Sequence[Ranked]:
    """Return other names fitted on top of the model without the effect."""
    named = {e.name for e in selection.effects}
    if len(selection.effects) == 1:
        return [r for r in selection.rankings[0] if r.name not in named and r.evidence > 0.0]
    worth = WORTH_ASKING * min(effect.evidence, selection.rankings[0][0].evidence)
    best = {
        r.name: r.evidence for ranking in selection.rankings for r in reversed(ranking) if r.name not in named
    }
    names = sorted((n for n in best if best[n] > worth), key=lambda n: -best[n])[:TRIED_AGAIN]
    bank = Bank.on(engine, less, effect.evidence)
    tried = (bank.best_of(registry()[name]) for name in names)
    return [r for r in tried if r is not None and r.evidence > 0.0]
