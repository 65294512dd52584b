"""From a ranking to an answer: select effects, weigh each name, and abstain where nothing is sure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Literal

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import catalogue, shown_by
from fsm_calib.diagnosis.candidates.place_search import placed
from fsm_calib.diagnosis.candidates.plausible import is_finding
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.rivals import Banks
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.gap import TOLD_APART
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Gates, adequacy
from fsm_calib.diagnosis.proof.in_poses import InPoses
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.features import feature_groups
from fsm_calib.diagnosis.shapes.locate import Location, locate
from fsm_calib.diagnosis.shapes.score_tests import ALPHA, left_over, surprising
from fsm_calib.diagnosis.verdict.bared import ranked_if_bared
from fsm_calib.diagnosis.verdict.cross_examined import supports_of
from fsm_calib.diagnosis.verdict.event_times import dated
from fsm_calib.diagnosis.verdict.gripping import likelier_if_gripping
from fsm_calib.diagnosis.verdict.in_two import likelier_in_two
from fsm_calib.diagnosis.verdict.model import Model, bare_model
from fsm_calib.diagnosis.verdict.posterior import Belief, belief_of
from fsm_calib.diagnosis.verdict.punctual import likelier_if_punctual, ranked_if_punctual
from fsm_calib.diagnosis.verdict.recalled import Finding, likelier_if_recalled
from fsm_calib.diagnosis.verdict.refined import refined
from fsm_calib.diagnosis.verdict.selection import Selection, Selector
from fsm_calib.diagnosis.verdict.shares import worth_saying
from fsm_calib.diagnosis.verdict.simplified import simplified
from fsm_calib.diagnosis.verdict.support import law_of
from fsm_calib.world2d.effects import Effect, registry

Progress = Callable[[str], None]
Outcome = Literal["match", "explained", "unexplained"]


@dataclass(frozen=True, eq=False)
class Decision:
    """What was found: outcome and reason; base fit, model, ranking of single effects, location, seconds by part.

    asked : the effects of the catalogue that were considered, those that these recordings can show.
    named : the effects whose names are sure enough to be said, strongest first; the model may have more.
    """

    outcome: Outcome
    reason: str
    engine: Engine
    asked: tuple[Effect, ...]
    base: Fit
    model: Model
    named: tuple[Belief, ...]
    ranking: tuple[Ranked, ...]
    location: Location
    bank: Bank
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass
class Judge:
    """Decides for the recordings of one robot; earlier : what an answer to fewer of them had found."""

    engine: Engine
    effects: list[Effect]
    gates: Gates
    progress: Progress
    rng: np.random.Generator
    earlier: Sequence[Finding] = ()
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Charge the time inside to a part."""
        began = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - began

    def decide(self) -> Decision:
        """Run the whole chain; what the encoders alone see is a match, unless one name explains all of it, one that
        only poses can show is among the names, or poses speak for the strongest by themselves.
        """
        decision = self._answer()
        model = decision.model
        witness = _witness(decision)
        with self.part("poses alone"):
            poses = InPoses(self.engine.simulators, self.gates)
            allowed = decision.outcome == "match" or (
                witness is not None and not poses.deny(model.fit, witness)
            )
            strongest = [belief.name for belief in decision.named[:1]]
            confirmed = (
                allowed
                or any(poses.affirm(model.fit, name) for name in strongest)
                or poses.show(self.effects)
            )
        if confirmed:
            return decision
        if model.effects:
            model = bare_model(self.engine, decision.base, decision.location)
        reason = (
            f"the poses agree with the re-fitted base robot, the encoders alone differ: {decision.reason}"
        )
        return replace(decision, outcome="match", reason=reason, model=model, named=())

    def _answer(self) -> Decision:
        """Ask everything that was measured."""
        self.progress("base robot")
        with self.part("base"):
            banks = Banks()
            base = fit_whole_base(self.engine, self.effects, banks)
        with self.part("locate"):
            situations = situations_of(self.engine.simulators, base.values)
            location = locate(self.engine, base, situations, self.rng)
        gates = self.gates
        selector = Selector(
            self.engine,
            base,
            self.effects,
            gates.detect,
            gates.further_share,
            gates.most,
            self.rng,
            self.progress,
            banks=banks,
        )
        with self.part("catalogue"):
            bank, ranking = selector.first_ranked()
            selector, bank, ranking = ranked_if_punctual(selector, bank, ranking)
            selector, bank, ranking = ranked_if_bared(selector, bank, ranking)
        selection: Selection | None = None
        with self.part("further effects"):
            if ranking and ranking[0].evidence >= gates.first:
                selector, selection = likelier_if_punctual(selector, selector.best_grown(ranking))
                selector, selection = likelier_if_gripping(selector, selection)
            selection = likelier_if_recalled(selector, self.earlier, ranking, selection)
            selection = selection and selector.spared(likelier_in_two(selector, selection))
        if selection is None:
            return self._without_name(selector.base, tuple(ranking), location, bank)
        found = (selector.base, tuple(ranking), location, bank)
        model = self._weighed(selection)
        with self.part("refinements"):
            model = simplified(self.engine, refined(self.engine, model, gates.detect))
        named = sayable(model, gates.least_confidence, self.engine.simulators)
        if not named:
            return self._decision("unexplained", _complaint(model), model, (), *found)
        named = worth_saying(self.engine, selector.base, model, named)
        if model.beliefs[0].name in {belief.name for belief in named}:
            reason = "detected, adequate and useful"
        else:
            reason = f"{', '.join(b.name for b in named)} for a part of it; {_complaint(model)}"
        self.progress("place and moment")
        with self.part("place and moment"):
            fit = placed(self.engine, model.fit, model.effects, self.rng)
            model = replace(model, fit=dated(self.engine, fit, model.effects))
        return self._decision("explained", reason, model, named, *found)

    def _weighed(self, selection: Selection) -> Model:
        """Test what a selection leaves, and how sure each of its names is."""
        fit = selection.fit
        self.progress("what is left")
        with self.part("left over"):
            groups = feature_groups(situations_of(self.engine.simulators, fit.values))
            tests = tuple(left_over(self.engine, fit, groups))
        self.progress("how sure")
        with self.part("support"):
            supports = supports_of(self.engine, selection, self.gates.least_confidence)
        left = adequacy(tests, max(s.added.evidence for s in supports))
        beliefs = tuple(map(belief_of, supports))
        return Model(selection.effects, fit, left, tests, supports[0].forms, supports, beliefs)

    def _without_name(
        self, base: Fit, ranking: tuple[Ranked, ...], location: Location, bank: Bank
    ) -> Decision:
        """No effect is detected: a match, or a mismatch that nothing in the catalogue resembles."""
        with self.part("left over"):
            plain = bare_model(self.engine, base, location)
        left, against = plain.adequacy, plain.contest
        outcome: Outcome = "match"
        reason = "the re-fitted base robot explains the recordings to within their noise"
        if surprising(plain.tests) and location.p_value < ALPHA:
            outcome = "unexplained"
            reason = f"the residual depends on {left.group} (10^-{left.surprise:.0f} by chance), no effect explains it"
        elif not against.loose and against.beside > self.gates.detect:
            outcome = "unexplained"
            reason = (
                f"the robot's speeds depend on {' and '.join(against.beside_quantities)} "
                f"(evidence {against.beside:.0f}), no effect explains it"
            )
        return self._decision(outcome, reason, plain, (), base, ranking, location, bank)

    def _decision(
        self,
        outcome: Outcome,
        reason: str,
        model: Model,
        named: tuple[Belief, ...],
        base: Fit,
        ranking: tuple[Ranked, ...],
        location: Location,
        bank: Bank,
    ) -> Decision:
        asked = tuple(self.effects)
        return Decision(
            outcome, reason, self.engine, asked, base, model, named, ranking, location, bank, self.seconds
        )


def sayable(model: Model, least: float, simulators: Sequence[Simulator]) -> tuple[Belief, ...]:
    """Return the beliefs in names that are at least so probable and in the whole model still what they say.

    An effect was plausible as it joined; what joined it may have moved its numbers to where they are none: a supply
    that ended at full command, and at 1.2 of it beside a dead zone, which is how robots are built.
    """
    return tuple(
        belief
        for belief in model.named(least)
        if is_finding(replace(belief.effect, fit=model.fit), simulators)
    )


def _witness(decision: Decision) -> str | None:
    """Return the name that poses may speak for alone: the only one, or one of a map's, which no encoder sees."""
    names = [belief.name for belief in decision.named]
    if len(names) == len(decision.model.effects) == 1:
        return names[0]
    return next((name for name in names if registry()[name].acts_on == "pose"), None)


def _complaint(model: Model) -> str:
    """Return in words why the strongest effect is not named."""
    belief, support = model.beliefs[0], model.supports[0]
    nearest = " or ".join(belief.among)
    forms = support.forms
    twin = min(support.twins, key=lambda twin: twin.gap.probability, default=None)
    if twin is not None and twin.gap.probability < TOLD_APART:
        return f"{nearest} comes nearest, but {twin.what} does as well"
    if support.is_sparse:
        added = f"{support.added.evidence:.0f} +- {support.added.spread:.0f}"
        return f"{nearest} comes nearest, but a handful of seconds has its evidence ({added})"
    if support.replaced > 0.0 and forms.instead_quantities:
        return (
            f"{nearest} comes nearest, but {law_of(forms.instead_quantities)} "
            f"does better (evidence {forms.instead:.0f} more)"
        )
    if forms.beside > 0.0 and forms.beside_quantities:
        return (
            f"{nearest} comes nearest, but leaves what depends on {' and '.join(forms.beside_quantities)} "
            f"({100 * support.left:.0f} % of what it explains)"
        )
    if support.moved > 0.0:
        return f"{nearest} comes nearest, but each drive asks for another size ({100 * support.moved:.0f} % is lost)"
    if support.patchy > 0.5:
        return f"{nearest} comes nearest, but may only mend what is inexact in stronger effects"
    return f"nearest: {nearest}, but not surely enough for a name"


def decide(
    simulators: Iterable[Simulator],
    *,
    without: Iterable[str] = (),
    gates: Gates = DEFAULT_GATES,
    progress: Progress = lambda part: None,
    seed: int = 0,
    earlier: Sequence[Finding] = (),
) -> Decision:
    """Decide what the recordings of one robot show; `without` leaves effects out of the catalogue, `earlier` is what an
    answer to fewer of them had found.
    """
    engine = Engine(tuple(simulators))
    effects = shown_by(catalogue(without), engine.simulators)
    judge = Judge(engine, effects, gates, progress, np.random.default_rng(seed), earlier)
    return judge.decide()
