"""The bank: every hypothesis of the catalogue fitted on the same recordings, ranked by evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from fsm_calib.diagnosis.candidates.approached import Approached, worth_following
from fsm_calib.diagnosis.candidates.asked import Answers, Asked, Distinct
from fsm_calib.diagnosis.candidates.best_choice import with_best_choice
from fsm_calib.diagnosis.candidates.contained import stuck_above
from fsm_calib.diagnosis.candidates.extended import beyond
from fsm_calib.diagnosis.candidates.hypotheses import (
    Hypothesis,
    alike_in,
    declared_starts,
    hypotheses_of,
    single_steps,
    slots_of,
    starts_move_all,
)
from fsm_calib.diagnosis.candidates.jolts import is_quiet
from fsm_calib.diagnosis.candidates.once_more import once_more
from fsm_calib.diagnosis.candidates.plausible import plausible_of
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of, simplest, strongest
from fsm_calib.diagnosis.candidates.scan import Scanner, scan_of
from fsm_calib.diagnosis.candidates.scanned import Plan, Plans, scanned
from fsm_calib.diagnosis.candidates.searched import likeliest_values
from fsm_calib.diagnosis.candidates.starts import Prober, Start, distinct_of
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE
from fsm_calib.diagnosis.fitting.begins import begins_of
from fsm_calib.diagnosis.fitting.climb import last_steps, to_its_end
from fsm_calib.diagnosis.fitting.fit import OPTIMISM, Engine, Fit, jacobian
from fsm_calib.diagnosis.fitting.nested import nothing_found
from fsm_calib.diagnosis.fitting.side_by_side import Result, Thing, side_by_side
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.score_tests import residual_of
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table

FIRST_STEPS = 6  # Gauss-Newton steps before the noise is fitted again
HOPELESS = 2.0  # log-likelihood units: below, the noise is not fitted again and a fit is given up early
FAR_BELOW = 0.3  # of the evidence that counts: a fit at its parent's noise that has less is not finished
NEAR_ENOUGH = 40.0  # evidence below the best within which every fit is finished: rivals are told by their gap
FAR = 20.0  # log-likelihood units won: the base has moved, and its columns are computed again
NESTING_SLACK = 1e-6
AHEAD = 4  # effects a process that are asked at a time

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Bank:
    """Fits hypotheses on top of a parent fit (the base robot, or a model that already has an effect).

    distinct : which declared starts of a form change the drives in a way of their own. Found where the form is first
    tried; it hangs on the drives and hardly on the model, so it serves for later ones, too.
    On the base robot no answer hangs on what else is asked: each is kept, and given again.
    """

    engine: Engine
    parent: Fit
    prober: Prober
    scanner: Scanner
    distinct: Distinct
    answers: Answers = field(default_factory=Answers)

    @classmethod
    def on(cls, engine: Engine, parent: Fit, wanted: float = 0.0, distinct: Distinct | None = None) -> Bank:
        """Prepare probing and scanning; what stays far below the evidence `wanted` is not fitted to the end."""
        residual, worth = residual_of(engine, parent), 0.5 * FAR_BELOW * wanted
        situations = situations_of(engine.simulators, parent.values)
        return cls(
            engine,
            parent,
            Prober(engine.simulators, parent, residual),
            Scanner(engine.simulators, situations, parent, residual, worth),
            {} if distinct is None else distinct,
        )

    @property
    def _worth(self) -> float:
        """The log-likelihood that a fit must win before it is worth more time."""
        return max(HOPELESS, self.scanner.worth)

    def rank(
        self, effects: Iterable[Effect], progress: Progress = lambda name: None, noticed: float = 0.0
    ) -> list[Ranked]:
        """Fit all effects in all their forms; return the best plausible form of each, largest evidence first.

        Where a model already has effects, only the best joins it in this round: what stays far below the best so far
        is given up early, and asked again in the next. On the base robot all are fitted where one has more evidence
        than `noticed`; where none has, a form that promises nothing has won nothing.
        """
        asked = self._each_asked(list(effects), progress)
        begun = {answer.name: list(answer.begun) for answer in asked}
        if not self.scanner.worth:
            if any(ranked.evidence > noticed for found in begun.values() for ranked in found):
                again = self._each(self._asked_again, asked, self.answers.again)
            else:
                again = [self._without_gain(answer) for answer in asked]
            for answer, more in zip(asked, again, strict=True):
                begun[answer.name] += more
        kept = [kept for found in begun.values() for kept in self._kept(found)]
        near = {ranked.name for ranked in self._near(kept)}
        done = self._finished([ranked for ranked in kept if ranked.name in near])
        whole = [*done, *(ranked for ranked in kept if ranked.name not in near)]
        names = dict.fromkeys(ranked.name for ranked in whole)
        best = [simplest(self._plausible(r for r in whole if r.name == name)) for name in names]
        return sorted(best, key=lambda ranked: -ranked.evidence)

    def _plausible(self, forms: Iterable[Ranked]) -> Sequence[Ranked]:
        """Return `plausible_of` some forms of an effect in these recordings, of an event's those that may be said."""
        asked = list(forms)
        quiet = [ranked for ranked in asked if is_quiet(self.engine, ranked)]
        return plausible_of(quiet or asked, self.engine.simulators)

    def _each_asked(self, effects: Sequence[Effect], progress: Progress) -> list[Asked]:
        """Return what each effect begins; on the base robot, where none hangs on the others, what it began before."""
        if self.scanner.worth:
            return self._all_asked(effects, progress)
        new = [effect for effect in effects if effect.name not in self.answers.begun]
        self.answers.begun.update((answer.name, answer) for answer in self._all_asked(new, progress))
        return [self.answers.begun[effect.name] for effect in effects]

    def _each(
        self, work: Callable[[Thing], Result], things: Sequence[Thing], known: dict[Thing, Result]
    ) -> list[Result]:
        """Return what comes of every thing, side by side; what is known is not worked out again."""
        new = [thing for thing in things if thing not in known]
        known.update(zip(new, self.side_by_side(work, new), strict=True))
        return [known[thing] for thing in things]

    def _all_asked(self, effects: Sequence[Effect], progress: Progress) -> list[Asked]:
        """Return what each effect begins, each with the hope that those before it leave.

        Several are asked side by side as if none of them won more than those before; where one does, those after it are
        asked again, so that the answers are those of one after the other.
        """
        processes, asked, many = self.engine.processes, list[Asked](), 1
        active = parameter_table().active_effects(self.parent.values[0])
        self.scanner.look_for([effect for effect in effects if effect.name not in active])
        while len(asked) < len(effects):
            hope, some = self._hope(asked), effects[len(asked) : len(asked) + many]
            for answer in self.side_by_side(partial(self._asked, hope), some):
                if self._hope(asked) != hope:
                    break
                progress(answer.name)
                asked.append(answer)
                self.distinct.update(answer.distinct)
            many = min(2 * many, AHEAD * processes) if processes > 1 else 1
        return asked

    def _hope(self, asked: Sequence[Asked]) -> float:
        """Return the gain that the next effect must come near, once others have been asked."""
        if not self.scanner.worth:
            return self._worth
        return max(
            self._worth, FAR_BELOW * max((ranked.gain for a in asked for ranked in a.begun), default=0.0)
        )

    def _asked(self, hope: float, effect: Effect) -> Asked:
        """Return what an effect begins; forms that are far from winning `hope` are left."""
        plans = self.plans(effect, hope)
        begun = self._all_begun(effect, plans, hope)
        left = tuple(form for form, starts in plans if not starts)
        learned = {form: self.distinct[form] for form, _ in plans if form in self.distinct}
        return Asked(effect.name, tuple(begun), left, learned)

    def side_by_side(self, work: Callable[[Thing], Result], things: Iterable[Thing]) -> list[Result]:
        """Return what comes of every thing; results hold the parent's large parts, not copies."""
        return side_by_side(self.engine, work, things, self.parent)

    def _all_begun(self, effect: Effect, plans: Plans, hope: float) -> list[Ranked]:
        """Return the forms of an effect begun from their starts, and the closures that extend those which win."""
        begun = [self._begun(form, start, hope) for form, starts in plans for start in starts]
        return begun + self._extended(effect, begun)

    def _asked_again(self, answer: Asked) -> list[Ranked]:
        """Return the forms of an effect that promise nothing, begun all the same."""
        plans = [(form, self._starts(form, -np.inf)) for form in answer.left]
        return self._all_begun(registry()[answer.name], plans, self._worth)

    def _without_gain(self, answer: Asked) -> list[Ranked]:
        """Return the first of the forms that promise nothing, if any, as one that has won nothing."""
        return [
            self._ranked(form, nothing_found(self.parent, self._slots_with(form))) for form in answer.left[:1]
        ]

    def _kept(self, begun: Sequence[Ranked]) -> list[Ranked]:
        """Return the best form of an effect and the others that are worth more time."""
        in_order = sorted(begun, key=lambda ranked: -ranked.evidence)
        return in_order[:1] + [ranked for ranked in in_order[1:] if ranked.gain > self._worth]

    @staticmethod
    def _near(tried: Sequence[Ranked]) -> list[Ranked]:
        """Return the fits that come near enough to the best to be worth finishing."""
        top = max((ranked.evidence for ranked in tried), default=0.0)
        least = min(FAR_BELOW * top, top - NEAR_ENOUGH)
        return [ranked for ranked in tried if ranked.evidence >= least]

    def plans(self, effect: Effect, hope: float = -np.inf) -> Plans:
        """Return the forms of an effect with their starts; those that are far from winning `hope` have none."""
        forms = self._forms(effect)
        return [(form, self._starts(form, hope) if starts is None else starts) for form, starts in forms]

    def _forms(self, effect: Effect) -> list[Plan]:
        """Return the forms of an effect, with their starts where these need not be sought."""
        runs = len(self.engine.simulators)
        if effect.name in parameter_table().active_effects(self.parent.values[0]):
            start = Start(self.parent.values, 0.0)  # the parent has it: would other numbers be better?
            return [(hypothesis, [start]) for hypothesis in hypotheses_of(effect, runs)]
        if scan_of(effect) is not None:
            return [*scanned(self.prober, self.scanner, effect)]
        return [(hypothesis, None) for hypothesis in hypotheses_of(effect, runs)]

    def _starts(self, hypothesis: Hypothesis, hope: float) -> list[Start]:
        """Return where to start a form; nowhere if no start wins `hope`, nor all they may change, to first order."""
        effect = registry()[hypothesis.effect]
        given = self._measured(effect) | likeliest_values(self.prober, hypothesis)
        choices = declared_starts(hypothesis, given)
        few = self.distinct.get(hypothesis, range(len(choices)))
        first = [choices[i] for i in few]
        probes = dict(zip(few, self.prober.probes(hypothesis, first), strict=True))
        if hypothesis not in self.distinct:
            self.distinct[hypothesis] = distinct_of(list(probes.values()))
        unmoved = self.prober.probes(hypothesis, single_steps(hypothesis, choices))
        declared = [probe.declared.promise for probe in probes.values()]
        held_back = self.prober.held_back(hypothesis, first, max([0.0, *declared]))
        promised = [OPTIMISM * self.prober.reach(list(probes.values()), unmoved), *declared]
        promised += [start.promise for start in held_back]
        if max(promised) < hope and (self.scanner.worth or starts_move_all(hypothesis)):
            return []
        if not hypothesis.held and not any(effect.parameter(n).starts for n in hypothesis.names):
            return [Start(self.parent.values, 0.0), *held_back]  # linear at its null value
        rest = [i for i in range(len(choices)) if i not in probes]
        probes |= zip(rest, self.prober.probes(hypothesis, [choices[i] for i in rest]), strict=True)
        in_order = [probes[i] for i in range(len(choices))]
        return [*self.prober.best_starts(hypothesis, choices, 1, in_order), *held_back]

    def fit(self, hypothesis: Hypothesis, start: Start) -> Ranked:
        """Fit one hypothesis from one start; the result is never worse than the parent."""
        return self._finished([self._begun(hypothesis, start)])[0]

    def best_of(self, effect: Effect) -> Ranked | None:
        """Return the best form of one effect, fitted from all its starts; None where there is none to try."""
        tried = self._fitted(self._forms(effect))
        return strongest(self._plausible([*tried, *self._finished(self._extended(effect, tried))]))

    def again(self, event: Hypothesis, run: int) -> Ranked | None:
        """Return the best event of its kind in a recording; once more where the parent has it there, else once or
        several times; None where none is seen.
        """
        effect = registry()[event.effect]
        alike, times = alike_in(effect, event.closure), len(begins_of(self.parent, effect.name, run))
        if times:
            seen, values = self.scanner.candidates(effect), self.parent.values
            return strongest(self._fitted(once_more(effect, alike, (run, times), seen, values)))
        plans = scanned(self.prober, self.scanner, effect)
        return strongest(self._fitted(p for p in plans if p[0].run == run and p[0].closure in alike))

    def _fitted(self, plans: Iterable[Plan]) -> list[Ranked]:
        """Return the forms, each from all its starts; those that begin far below the best are not fitted to the end."""
        begun = [ranked for found in self.side_by_side(self._each_begun, plans) for ranked in found]
        return self._finished(self._near(begun))

    def _each_begun(self, plan: Plan) -> list[Ranked]:
        """Return a form begun from each of its starts, which are sought where there are none yet."""
        form, starts = plan
        return [self._begun(form, s) for s in (self._starts(form, -np.inf) if starts is None else starts)]

    def _begun(self, hypothesis: Hypothesis, start: Start, worth: float = 0.0) -> Ranked:
        """Fit one hypothesis at the parent's noise; what does not get near the gain `worth` is given up early."""
        slots, known, noise = self._slots_with(hypothesis), self.parent.columns, self.parent.noise
        hope = self.parent.score + max(self._worth, worth)
        linear = start.values is self.parent.values
        fit = self.engine.fit(
            start.values, slots, noise, known=known, steps=FIRST_STEPS, hope=hope, linear=linear
        )
        if fit.score < self.parent.score:  # too bold a start: creep away from the parent's point instead
            values = switched_off(start.values, (hypothesis.effect,))
            fit = self.engine.fit(
                values, slots, noise, known=known, steps=FIRST_STEPS, hope=hope, linear=True
            )
        return self._ranked(hypothesis, fit)

    def _slots_with(self, hypothesis: Hypothesis) -> tuple[Slot, ...]:
        """Return the numbers of the parent and those that a form has besides."""
        taken = {(slot.place, slot.run) for slot in self.parent.slots}
        simulators = self.engine.simulators
        free = slots_of(hypothesis, len(simulators), scale_of(simulators[0]))
        return (*self.parent.slots, *(s for s in free if (s.place, s.run) not in taken))

    def _extended(self, effect: Effect, begun: Sequence[Ranked]) -> list[Ranked]:
        """Begin forms again that won less than one they contain, and the closures that extend one which has won
        something, here or in the parent, each from the best.
        """
        larger, least = [self._begun(form, start) for form, start in stuck_above(begun)], self._worth
        if effect.name in parameter_table().active_effects(self.parent.values[0]):
            least = -np.inf
        for closure in effect.extending:
            won = [r for r in begun if r.hypothesis.closure in closure.extends and r.gain > least]
            if won:
                best = max(won, key=lambda r: r.gain)
                form, start = beyond(self.prober, effect, closure, best.hypothesis, best.fit.values)
                larger.append(self._begun(form, start))
        return larger

    def _finished(self, begun: Sequence[Ranked]) -> list[Ranked]:
        """Return fits at their end; of an effect's forms those that cannot pass its best end near it."""
        near = self._each(self._approached, begun, self.answers.approached)
        along = worth_following(near)
        followed = dict(zip(along, self._each(self._followed, along, self.answers.followed), strict=True))
        return [followed.get(found, found.ranked) for found in near]

    def _approached(self, ranked: Ranked) -> Approached:
        """Fit the noise again, and the hypothesis at that noise; what has won nothing stays as it is."""
        if ranked.gain <= self._worth:
            return Approached(ranked, 0.0)
        given = self._measured(registry()[ranked.name])
        ranked = with_best_choice(ranked, self.prober, given, self._begun)
        fit, known = self.engine.refit_noise(ranked.fit, SPEED_NOISE, 2), self.parent.columns
        if fit.score > self.parent.score + FAR:
            known = jacobian(self.engine.simulators, fit.values, self.parent.slots, fit.simulated)
        found = last_steps(self.engine, fit, known)
        return Approached(self._ranked(ranked.hypothesis, found), found.score - fit.score)

    def _followed(self, found: Approached) -> Ranked:
        """Return a fit where its valley ends."""
        return self._ranked(found.ranked.hypothesis, to_its_end(self.engine, found.ranked.fit))

    def _measured(self, effect: Effect) -> dict[str, float]:
        """Return the choices of an effect that wheels leave no room for, measured or not: full names, values."""
        measured = all(s.prepared.has_encoders for s in self.engine.simulators)
        settled = [p for p in effect.choices if (p.without_encoders if measured else p.with_encoders)]
        return {f"{effect.name}.{p.name}": p.null for p in settled}

    def _ranked(self, hypothesis: Hypothesis, fit: Fit) -> Ranked:
        """Return the fit with its evidence, at the parent's point where it came out worse."""
        if fit.score < self.parent.score - NESTING_SLACK:
            fit = nothing_found(self.parent, fit.slots)
        gain = fit.score - self.parent.score
        return Ranked(hypothesis, fit, evidence_of(fit, self.parent, self.engine.count), gain)
