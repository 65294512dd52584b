"""As many effects as the data carry: one is added at a time, and each stays only as long as it is missed.

Forward selection with backward elimination (Efroymson 1960; Miller, Subset Selection in Regression, 2nd ed. 2002,
sections 3.2 to 3.4) over the catalogue: on top of the model so far every effect is fitted, the one with the largest
evidence joins, earlier ones are asked again whether a rival does better beside it (what led alone may have stood in
for a sum) and whether they are still needed. It ends where neither the score tests nor forms without a name find
anything left, or where nothing in the catalogue has evidence enough. (None of 34 right models of two independent
generators leaves a surprise above 3.3 but for the edges of places, those that lack an effect leave 7 to 59; where the
noise was fitted with the remainder in it, forms see what the tests do not: right models leave them no evidence.) Places
and moments are sought again only where the tests of places or of time find something, or where they had evidence of
their own before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fsm_calib.diagnosis.candidates.asked import Distinct
from fsm_calib.diagnosis.candidates.from_the_leader import sought_again
from fsm_calib.diagnosis.candidates.from_the_sheet import is_bent, sought_from_the_sheet
from fsm_calib.diagnosis.candidates.hypotheses import is_event
from fsm_calib.diagnosis.candidates.jolts import happened
from fsm_calib.diagnosis.candidates.place_search import placed
from fsm_calib.diagnosis.candidates.plausible import is_crossed, is_plausible
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.rivals import Banks
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE, noise_names
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.side_by_side import side_by_side
from fsm_calib.diagnosis.fitting.values import taken_over
from fsm_calib.diagnosis.fitting.wald import strengths_of, wald
from fsm_calib.diagnosis.proof.gap import TOLD_APART, gap_between
from fsm_calib.diagnosis.verdict.either_order import the_other_way_round
from fsm_calib.diagnosis.verdict.every_recording import come_again, in_every_recording
from fsm_calib.diagnosis.verdict.in_its_place import in_the_others_company, on_its_own_ground
from fsm_calib.diagnosis.verdict.spared import spared
from fsm_calib.diagnosis.verdict.swapped import swapped
from fsm_calib.diagnosis.verdict.worth_asking import standing_out, worth_asking
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table

POLISHED = 6  # candidates that get fresh Jacobians and all noise levels
EVENT_SHARE = 0.3  # of the first's evidence: an event of one drive with less does not lead with all of them
POLISH_SHARE = 0.6  # of the first's evidence: below it no polish turns the order
BEAM = 2  # other first effects that are given company of their own
MOST_ROUNDS = 24  # six effects take some ten; growth ends even where what joins and what goes take turns
SURELY_NEEDED = 8.0  # times the evidence wanted, by its own deviation: an effect that is not taken out to see

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Selection:
    """The effects that a model has, strongest first, the fit of all, and each round's ranking.

    dropped : the fit without each effect, in the effects' order: what the others make of the drives without it.
    beside : other first effects that alone explained nearly as much, each with the fit of what was selected beside it.
    """

    effects: tuple[Ranked, ...]
    fit: Fit
    rankings: tuple[tuple[Ranked, ...], ...]
    dropped: tuple[Fit, ...] = ()
    beside: tuple[tuple[Ranked, Fit], ...] = ()


@dataclass(frozen=True, eq=False)
class Selector:
    """Selects effects for the recordings of one robot.

    needed : evidence that each effect must add to all the others; share : of what the first had alone that a further
    one must have; most : effects at most; goal : log-likelihood that a selection has to reach to be of any use;
    rng : for the searches over the floor; distinct : what the first round learns of the starts for the later ones;
    banks : what the fit that was asked last answered, the base robot while it was fitted.
    """

    engine: Engine
    base: Fit
    catalogue: Sequence[Effect]
    needed: float
    share: float
    most: int
    rng: np.random.Generator
    progress: Progress = field(default=lambda part: None)
    distinct: Distinct = field(default_factory=dict)
    banks: Banks = field(default_factory=Banks)
    goal: float = -np.inf

    def _told(self, found: list[Ranked], parent: Fit) -> list[Ranked]:
        """Return what was found on top of a parent, the leaders polished, implausible ones left out.

        An event counts with what happened of its kind in the other recordings: others explain all of them, too.
        """
        told = [r for r in self._polish(found, parent) if self.is_told(r)]
        least = max(self.needed, EVENT_SHARE * told[0].evidence) if told else 0.0
        whole = [
            in_every_recording(self.engine, r, self.needed, self.is_told) if r.evidence >= least else r
            for r in told
        ]
        return sorted(whole, key=lambda r: -r.evidence)

    def first_ranked(self) -> tuple[Bank, list[Ranked]]:
        """Return the effects on top of the base robot, the leader's rivals sought from where it has the base, too.

        With the bank that fitted them.
        """
        bank = self.banks.on(self.engine, self.base, self.distinct)
        found = bank.rank(self.catalogue, self.progress, self.needed)
        if is_bent(self.base):
            found = sought_from_the_sheet(self.engine, self.base, found, self.catalogue, self.distinct)
        ranking = self._told(found, self.base)
        if not ranking or ranking[0].evidence < self.needed:
            return bank, ranking
        again = sought_again(self.engine, self.base, ranking, self.catalogue)
        return bank, [r for r in again if r in ranking or self.is_told(r)]

    def is_told(self, ranked: Ranked) -> bool:
        """Return whether an effect is what its name says and, if it is an event, happened."""
        return is_plausible(ranked, self.engine.simulators) and happened(self.engine, ranked, self.needed)

    def grown(self, ranking: Sequence[Ranked]) -> Selection:
        """Return the selection that begins with the first of a ranking on top of the base robot."""
        return self._grown_on(Selection((ranking[0],), ranking[0].fit, (tuple(ranking),), (self.base,)))

    def grown_from(
        self, effects: tuple[Ranked, ...], fit: Fit, rankings: tuple[tuple[Ranked, ...], ...]
    ) -> Selection:
        """Return the selection that grows from effects that are fitted already, less those that are not missed.

        All others are asked, whatever is left for them: what they would explain may have been noise so far.
        """
        bare = self._pruned(effects, fit, rankings, self.needed)
        further = self.beside(bare.effects) if len(bare.effects) < self.most else []
        larger = self._with_one_more(bare, self._bank_on(bare), further)
        grown = self._grown_on(larger) if larger else self._come_again(bare) or bare
        return self.weighed(grown, self._wanted(grown))

    def _grown_on(self, selection: Selection) -> Selection:
        """Return the selection with further effects as long as any is worth it.

        Once one has gone as another came, what is left has been tried, but for what the one that went hid: then only
        what was seen beside it is asked, and moments.
        """
        while len(selection.effects) < self.most and len(selection.rankings) < MOST_ROUNDS:
            bank = self._bank_on(selection)
            one_went = len(selection.effects) < len(selection.rankings)
            further = (self._seen_before if one_went else self._worth_asking)(selection, bank)
            larger = self._with_one_more(selection, bank, further)
            if larger is None:
                break
            selection = larger
        return self._come_again(selection) or selection

    def _come_again(self, selection: Selection) -> Selection | None:
        """Return the selection with an event that came more often than was seen before; None where none did."""
        again = come_again(self.engine, selection.effects, selection.fit, self.needed, self.is_told)
        wanted = self._wanted(selection)
        return again and self._pruned(*again, selection.rankings, wanted, SURELY_NEEDED * wanted)

    def _seen_before(self, selection: Selection, bank: Bank) -> list[Effect]:
        """Return the further effects that had evidence in the last round, or of which a moment stands out."""
        beside = self.beside(selection.effects)
        seen = {r.name for r in selection.rankings[-1] if r.evidence > self.needed}
        seen |= standing_out(bank, beside, self.needed)
        return [e for e in beside if e.name in seen]

    def _bank_on(self, selection: Selection) -> Bank:
        """Return the bank that fits further effects on top of a selection."""
        return Bank.on(self.engine, selection.fit, self._wanted(selection), self.distinct)

    def best_grown(self, ranking: Sequence[Ranked]) -> Selection:
        """Return the best selection that begins with the first of a ranking, or with one that is hardly behind it.

        Two that cannot be told apart alone may be told apart only by what joined the first of them; so each of the
        nearest is given its own company before they are compared.
        """
        best = self.grown(ranking)
        if len(best.effects) == 1:
            # an effect too sure to be taken out to see may be what is left of two
            return self.weighed(best, 0.0)
        best = self.weighed(best, self._wanted(best))
        first, named = best.rankings[0][0], {e.name for e in best.effects}
        near = [
            r
            for r in ranking[1 : 1 + BEAM]
            if first.name in named
            and r.name not in named
            and gap_between(self.engine, ranking[0].fit, r.fit).probability < TOLD_APART
        ]
        others = [other for other in (self._led_by(best, r) for r in near) if other is not None]
        for i, other in enumerate(others):
            if evidence_of(other.fit, best.fit, self.engine.count) > 0.0:
                best, others[i] = other, best
        said, leader = {e.name for e in best.effects}, best.rankings[0][0].name
        rivals = [s for s in others if leader not in {e.name for e in s.effects}]
        found = [(s.rankings[0][0], s.fit) for s in rivals if s.rankings[0][0].name not in said]
        return replace(best, beside=tuple(found))

    def _led_by(self, best: Selection, rival: Ranked) -> Selection | None:
        """Return what grows from a selection with a rival in the place of the first that joined it.

        None where the rival has nothing to say beside the others. It grows on only where it is not beaten as it is, by
        as few effects: a real Duckiebot's caster with four others beat its dead zone with three (0.986), with four it
        did not (0.71).
        """
        first = best.rankings[0][0]
        kept = [e for e in best.effects if e.name != first.name]
        bank = Bank.on(self.engine, self.without(best.fit, first.name))
        tried = bank.best_of(registry()[rival.name])
        if tried is None or tried.gain <= 0.0:
            return None
        among = in_the_others_company(self, tried, best.fit, first.name)
        alone = on_its_own_ground(bank, rival, best.fit, first.name)
        tried = max(among, alone, key=lambda r: r.evidence)
        led = (rival, *(o for o in best.rankings[0] if o is not rival))
        rankings = (led, *best.rankings[1 : 1 + len(kept)])
        other = self._pruned(
            (replace(tried, evidence=rival.evidence), *kept), tried.fit, rankings, self.needed
        )
        fewer = len(other.effects) < len(best.effects)
        if not fewer and gap_between(self.engine, best.fit, other.fit).probability >= TOLD_APART:
            return other
        grown = self._grown_on(other)
        return grown if grown is other else self.weighed(grown, self._wanted(grown))

    def _with_one_more(self, selection: Selection, bank: Bank, further: Sequence[Effect]) -> Selection | None:
        """Return the selection with the best of further effects, less what it makes needless; None where none is."""
        if not further:
            return None
        wanted = self._wanted(selection)
        before = {r.name: i for i, r in enumerate(selection.rankings[-1])}
        in_order = sorted(further, key=lambda e: before.get(e.name, len(before)))
        found = self._told(bank.rank(in_order, self.progress, self.needed), selection.fit)
        rankings = (*selection.rankings, tuple(found))
        if len(selection.rankings) == 1 and (pair := the_other_way_round(self, selection.rankings[0], found)):
            both = self._pruned(pair, pair[0].fit, (*selection.rankings, (pair[1], *found)), wanted)
            if len(both.effects) == len(pair):  # else one does without the other: as found
                return both
        each = (self.goal - selection.fit.score) / (self.most - len(selection.effects))  # on average
        if not found or found[0].evidence < wanted or found[0].fit.score - selection.fit.score < each:
            return None
        if is_event(registry()[found[0].name]) and (again := self._come_again(selection)) is not None:
            return again
        effects, fit = swapped(self, (*selection.effects, found[0]), found[0].fit, rankings)
        return self._pruned(effects, fit, rankings, wanted, SURELY_NEEDED * wanted)

    def _wanted(self, selection: Selection) -> float:
        """Return the evidence that a further effect must have."""
        return max(self.needed, self.share * selection.rankings[0][0].evidence)

    def _worth_asking(self, selection: Selection, bank: Bank) -> list[Effect]:
        """Return the effects that what is left could be."""
        hinted = {r.name for ranking in selection.rankings for r in ranking if r.evidence > self.needed}
        return worth_asking(bank, self.beside(selection.effects), hinted, needed=self.needed)

    def beside(self, effects: Iterable[Ranked]) -> list[Effect]:
        """Return the effects of the catalogue that a robot may have beside some."""
        named = {e.name for e in effects}
        left_out = named.union(*(registry()[name].excludes for name in named))
        return [e for e in self.catalogue if e.name not in left_out]

    def _pruned(
        self,
        effects: tuple[Ranked, ...],
        fit: Fit,
        rankings: tuple[tuple[Ranked, ...], ...],
        wanted: float,
        sure_from: float = np.inf,
    ) -> Selection:
        """Take out, least missed first, what the others do without; the rest with what each adds to the others.

        sure_from : evidence by its own deviation (Wald) from which an effect is not taken out to see; that is its
        evidence then, and the whole fit stands in `dropped` for it.
        """
        while True:
            missing = partial(self._missed, effects, fit, sure_from)
            missed = side_by_side(self.engine, missing, effects, fit, self.base)
            least = int(np.argmin([evidence for evidence, _ in missed]))
            if len(effects) == 1 or missed[least][0] >= wanted:
                break
            effects, fit = effects[:least] + effects[least + 1 :], missed[least][1]
        order = np.argsort([evidence for evidence, _ in missed])[::-1]
        ranked = tuple(
            replace(effects[i], fit=fit, evidence=missed[i][0], gain=fit.score - missed[i][1].score)
            for i in order
        )
        return Selection(ranked, fit, rankings, tuple(missed[i][1] for i in order))

    def _missed(
        self, effects: Sequence[Ranked], fit: Fit, sure_from: float, effect: Ranked
    ) -> tuple[float, Fit]:
        """Return what an effect adds to the others, and the fit without it."""
        own = wald(fit, strengths_of(fit, effect.name)) if sure_from < np.inf else 0.0
        if own > sure_from:
            return own, fit
        less = self.without(fit, effect.name) if len(effects) > 1 else self.base
        return evidence_of(fit, less, self.engine.count), less

    def weighed(self, selection: Selection, wanted: float) -> Selection:
        """Return the selection with each effect taken out in turn, all others re-fitted."""
        return self._pruned(selection.effects, selection.fit, selection.rankings, wanted)

    def spared(self, selection: Selection) -> Selection:
        """Return the selection without effects that a neighbour does without by another of its equations."""
        while len(selection.effects) > 1:
            wanted = self._wanted(selection)
            effects, fit = spared(self, selection.effects, selection.fit, selection.dropped, wanted)
            if fit is selection.fit:
                break
            selection = self._pruned(effects, fit, selection.rankings, wanted)
        return selection

    def without(self, fit: Fit, name: str) -> Fit:
        """Return the fit without one of its effects, everything else and the noise fitted again from where it was.

        Its numbers are as the base robot has them, all of them: a closure that is asked again on top must not find
        what another closure had fitted (the knee of a soft limit, the arm of a caster) and hold it for nothing.
        """
        table, engine = parameter_table(), self.engine
        kept = [i for i, s in enumerate(fit.slots) if table.owner[s.place] != name]
        known = tuple(columns[:, :, kept] for columns in fit.columns)
        slots = [fit.slots[i] for i in kept]
        values = taken_over(fit.values, name, self.base.values)
        return self.with_noise(engine.fit(values, slots, fit.noise, known=known))

    def with_noise(self, fit: Fit) -> Fit:
        """Return a fit with its noise fitted again, and itself at that noise."""
        fit = self.engine.refit_noise(fit, SPEED_NOISE, 3)
        return self.engine.fit(fit.values, fit.slots, fit.noise, steps=6)

    def _polish(self, ranking: list[Ranked], parent: Fit) -> list[Ranked]:
        """Fit the leaders with fresh Jacobians, places where they are likeliest; sort again."""
        if not ranking:
            return ranking
        limit, engine = POLISH_SHARE * ranking[0].evidence, self.engine
        near = [self._where_likeliest(r) for r in ranking[:POLISHED] if r.evidence >= max(limit, 0.0)]
        names = noise_names(engine.simulators)
        leaders = side_by_side(engine, lambda ranked: polished(engine, ranked, parent, names), near, parent)
        return sorted(leaders + ranking[len(leaders) :], key=lambda r: -r.evidence)

    def _where_likeliest(self, ranked: Ranked) -> Ranked:
        """Return a leader with its place where it is likeliest and crossed: what it leaves would be said as a push."""
        sought = replace(ranked, fit=placed(self.engine, ranked.fit, [ranked], self.rng))
        return sought if is_crossed(sought, self.engine.simulators) else ranked
