"""From a ranking to an answer: polish, test what is left, try a second effect, and abstain where a gate is shut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Literal

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import catalogue, shown_by
from fsm_calib.diagnosis.candidates.place_search import placed
from fsm_calib.diagnosis.candidates.ranking import Bank, Ranked, polished
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.crossval import held_out_gains, is_global
from fsm_calib.diagnosis.proof.form_test import Contest, contest
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Gates, adequacy, indistinguishable
from fsm_calib.diagnosis.proof.heldout import error_left
from fsm_calib.diagnosis.proof.in_poses import shown_in_poses
from fsm_calib.diagnosis.proof.necessity import survivor
from fsm_calib.diagnosis.proof.plausible import is_plausible
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.features import feature_groups
from fsm_calib.diagnosis.shapes.locate import SIGNIFICANT, Location, locate
from fsm_calib.diagnosis.shapes.score_tests import left_over
from fsm_calib.diagnosis.verdict.event_times import dated
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import sureness
from fsm_calib.world2d.effects import Effect, registry

POLISHED = 6  # candidates that get fresh Jacobians and all noise levels
POLISH_SHARE = 0.6  # of the first's evidence: below it no polish turns the order
BETTER = 3.0  # log-likelihood units that make another optimum worth a look
SWAPS = 4  # other first effects tried beside a second
WORST_RECORDING = -4.0  # log density that one recording may lose by chance when fitted on the other

Progress = Callable[[str], None]
Outcome = Literal["match", "explained", "unexplained"]


@dataclass(frozen=True, eq=False)
class Decision:
    """What was found: outcome and reason; base fit, model, ranking of single effects, location, seconds by part."""

    outcome: Outcome
    reason: str
    engine: Engine
    base: Fit
    model: Model
    ranking: tuple[Ranked, ...]
    second_ranking: tuple[Ranked, ...]
    location: Location
    bank: Bank
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass
class Judge:
    """Decides for the recordings of one robot."""

    engine: Engine
    effects: list[Effect]
    gates: Gates
    progress: Progress
    rng: np.random.Generator
    seconds: dict[str, float] = field(default_factory=dict)

    def timed(self, part: str, since: float) -> None:
        """Charge the time since `since` [s] to a part."""
        self.seconds[part] = self.seconds.get(part, 0.0) + perf_counter() - since

    def decide(self) -> Decision:
        """Run the whole chain; what the encoders alone see without a name is a match."""
        decision = self._answer()
        began = perf_counter()
        confirmed = decision.outcome != "unexplained" or shown_in_poses(self.engine.simulators, self.gates)
        self.timed("poses alone", began)
        if confirmed:
            return decision
        model = decision.model
        if model.effects:
            model, _ = self._bare(decision.base, decision.location)
        reason = (
            f"the poses agree with the re-fitted base robot, the encoders alone differ: {decision.reason}"
        )
        return replace(decision, outcome="match", reason=reason, model=model, second_ranking=())

    def _answer(self) -> Decision:
        """Ask everything that was measured."""
        began = perf_counter()
        self.progress("base robot")
        base = fit_base(self.engine)
        self.timed("base", began)
        began = perf_counter()
        situations = situations_of(self.engine.simulators, base.values)
        location = locate(self.engine, base, situations, self.rng)
        self.timed("locate", began)
        began = perf_counter()
        bank = Bank.on(self.engine, base)
        ranking = self._polish(bank.rank(self.effects, self.progress), base)
        self.timed("catalogue", began)
        ranking = [r for r in ranking if is_plausible(r, self.engine.simulators) and self._stands_out(r)]
        if not ranking or ranking[0].evidence < self.gates.detect:
            return self._without_name(base, ranking, location, bank)
        first = self._model((ranking[0],), ranking[0].fit, base)
        second_ranking: tuple[Ranked, ...] = ()
        model = first
        if not (first.adequacy.surprise < self.gates.curious and first.sound(self.gates)):
            model, second_ranking = self._second(first, ranking, base)
        model = replace(model, error_left=error_left(self.engine.simulators, base, model.fit))
        outcome, reason = self._judge(model, ranking)
        if outcome == "explained":
            began = perf_counter()
            fit = placed(self.engine, model.fit, model.effects, self.rng)
            model = replace(model, fit=dated(self.engine, fit, model.effects))
            self.timed("place and moment", began)
        return Decision(
            outcome, reason, self.engine, base, model, tuple(ranking), second_ranking, location, bank, self.seconds
        )  # fmt: skip

    def _stands_out(self, ranked: Ranked) -> bool:
        """Return whether an event wins clearly more than other moments do; True where no moment was sought."""
        elsewhere = ranked.hypothesis.elsewhere
        return elsewhere <= 0.0 or ranked.evidence >= self.gates.detect + 2.0 * elsewhere

    def _polish(self, ranking: list[Ranked], base: Fit) -> list[Ranked]:
        """Fit the leaders with fresh Jacobians; sort again."""
        if not ranking:
            return ranking
        names = noise_names(self.engine.simulators)
        limit = POLISH_SHARE * ranking[0].evidence
        leaders = [
            polished(self.engine, r, base, names) for r in ranking[:POLISHED] if r.evidence >= max(limit, 0.0)
        ]
        return sorted(leaders + ranking[len(leaders) :], key=lambda r: -r.evidence)

    def _model(self, effects: tuple[Ranked, ...], fit: Fit, base: Fit) -> Model:
        """Test what a model leaves and what it predicts."""
        began = perf_counter()
        self.progress("what is left")
        situations = situations_of(self.engine.simulators, fit.values)
        tests = left_over(self.engine, fit, feature_groups(situations))
        self.timed("left over", began)
        began = perf_counter()
        gains: tuple[float, ...] = ()
        if all(is_global(e.hypothesis) for e in effects):
            gains = tuple(held_out_gains(self.engine, base, fit))
        self.timed("cross-validation", began)
        began = perf_counter()
        against = contest(self.engine, base, fit, [e.name for e in effects])
        self.timed("contest", began)
        return Model(effects, fit, adequacy(tests, fit.score - base.score), gains, tuple(tests), against)

    def _second(self, first: Model, ranking: Sequence[Ranked], base: Fit) -> tuple[Model, tuple[Ranked, ...]]:
        """Look for a second effect on top of the first; keep it only where it closes the gap."""
        began = perf_counter()
        wanted = max(self.gates.second, self.gates.second_share * first.effects[0].evidence)
        bank = Bank.on(self.engine, first.fit, wanted)
        others = [e for e in self.effects if e.name != first.effects[0].name]
        found = bank.rank(others, self.progress)
        found = [r for r in found if is_plausible(r, self.engine.simulators) and self._stands_out(r)]
        self.timed("second effect", began)
        if not found or found[0].evidence < wanted:
            return first, tuple(found)
        second = polished(self.engine, found[0], first.fit, noise_names(self.engine.simulators))
        lead = self._swap(first.effects[0], second, ranking, base)
        single = survivor(self.engine, lead[0], lead[1], base, wanted)
        if single is not None:
            better = single.fit.score > first.fit.score + BETTER
            return (self._model((single,), single.fit, base) if better else first), tuple(found)
        both = self._model(lead[0], lead[1], base)
        cured = both.adequacy.surprise < self.gates.surprise or (
            both.adequacy.surprise < 0.5 * first.adequacy.surprise and both.adequacy.passes(self.gates)
        )
        cured = cured and both.sound(self.gates)
        useful = not both.gains or not first.gains or sum(both.gains) > sum(first.gains)
        return (both if cured and useful else first), tuple(found)

    def _swap(
        self, first: Ranked, second: Ranked, ranking: Sequence[Ranked], base: Fit
    ) -> tuple[tuple[Ranked, ...], Fit]:
        """Try other first effects beside the second: what led alone may have stood in for a sum."""
        began = perf_counter()
        alone = next((r for r in ranking if r.name == second.name), None)
        best = ((first, second), second.fit)
        if alone is not None and alone.gain > 0:
            bank = Bank.on(self.engine, alone.fit)
            for rival in ranking[:SWAPS]:
                if rival.name in (first.name, second.name):
                    continue
                for hypothesis, starts in bank.plans(registry()[rival.name]):
                    for start in starts:
                        tried = bank.fit(hypothesis, start)
                        if tried.fit.score > best[1].score + BETTER:
                            best = ((tried, replace(second, fit=tried.fit)), tried.fit)
        self.timed("swaps", began)
        return best

    def _bare(self, base: Fit, location: Location) -> tuple[Model, Contest]:
        """Return the base robot alone with what it leaves, and how forms do beside it."""
        against = contest(self.engine, base, base, [])
        return Model((), base, adequacy(location.tests, 0.0), (), location.tests, against), against

    def _without_name(self, base: Fit, ranking: Sequence[Ranked], location: Location, bank: Bank) -> Decision:
        """No effect is detected: a match, or a mismatch that nothing in the catalogue resembles."""
        plain, against = self._bare(base, location)
        left = plain.adequacy
        outcome: Outcome = "match"
        reason = "the re-fitted base robot explains the recordings to within their noise"
        if left.surprise > self.gates.unexplained_surprise and location.p_value < SIGNIFICANT:
            outcome = "unexplained"
            reason = f"the residual depends on {left.group} (10^-{left.surprise:.0f} by chance), no effect explains it"
        elif not against.loose and against.beside > self.gates.nameless:
            outcome = "unexplained"
            reason = (
                f"the robot's speeds depend on {' and '.join(against.beside_quantities)} "
                f"(evidence {against.beside:.0f}), no effect explains it"
            )
        return Decision(
            outcome, reason, self.engine, base, plain, tuple(ranking), (), location, bank, self.seconds
        )

    def _judge(self, model: Model, ranking: Sequence[Ranked]) -> tuple[Outcome, str]:
        """Pass the model through the gates."""
        left, dominant = model.adequacy, model.error_left < self.gates.dominant
        if not left.passes(self.gates) and not dominant:
            return "unexplained", (
                f"the best explanation leaves structure in {left.group} (10^-{left.surprise:.0f} by chance, "
                f"{100 * left.share:.0f} % of what it explains)"
            )
        if not (model.sound(self.gates) or model.rules(self.gates)):
            return "unexplained", model.complaint(self.gates)
        if model.gains and (sum(model.gains) <= 0.0 or min(model.gains) < WORST_RECORDING):
            return (
                "unexplained",
                "the best explanation does not predict a recording that it was not fitted on",
            )
        if sureness(model, ranking, self.gates) < self.gates.least_confidence:
            said = [e.name for e in model.effects]
            nearest = said if len(said) > 1 else indistinguishable(ranking, self.gates)
            return "unexplained", f"nearest: {', '.join(nearest)}, but not surely enough for a name"
        if not left.passes(self.gates):
            return "explained", f"most of the error is explained; what is left depends on {left.group}"
        return "explained", "detected, adequate and useful"


def decide(
    simulators: Iterable[Simulator],
    *,
    without: Iterable[str] = (),
    gates: Gates = DEFAULT_GATES,
    progress: Progress = lambda part: None,
    seed: int = 0,
) -> Decision:
    """Decide what the recordings of one robot show; `without` leaves effects out of the catalogue."""
    engine = Engine(tuple(simulators))
    effects = shown_by(catalogue(without), engine.simulators)
    judge = Judge(engine, effects, gates, progress, np.random.default_rng(seed))
    return judge.decide()
