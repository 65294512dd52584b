"""From what speaks for a name to how sure it is, and from there to the answer: each number and each way through."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import EXACT, Ranked
from fsm_calib.diagnosis.proof.gap import LOGISTIC, TOLD_APART, Gap
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Adequacy
from fsm_calib.diagnosis.shapes.score_tests import ALPHA, LeftOver
from fsm_calib.diagnosis.verdict import decide
from fsm_calib.diagnosis.verdict.decide import Decision, Judge
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import (
    ANOTHER,
    DOUBT,
    LARGEST_LOG_ODDS,
    SURE,
    Belief,
    belief_of,
    shape_probability,
)
from fsm_calib.diagnosis.verdict.support import SLIGHT, RivalGap, Support
from fsm_calib.world2d.parameters import parameter_table

NEVER = 1e9  # evidence that settles a question
FORMS = {
    "jump": -math.inf,
    "instead": -100.0,
    "beside": 0.0,
    "instead_quantities": ("speed",),
    "beside_quantities": ("turn",),
}


def support(
    name: str = "motor_deadband", *, added: float = NEVER, spread: float = 0.0, share: float = 1.0,
    rivals: dict[str, float] | None = None, moved: float = 0.0, chance: float = 0.0, others: float = 0.0,
    **forms: object,
) -> Support:  # fmt: skip
    """A support of an effect, with the gaps in evidence to its rivals and what un-named forms do."""
    gaps = tuple(RivalGap(n, Gap(gap, 0.0, 60), None) for n, gap in (rivals or {}).items())  # type: ignore[arg-type]
    effect = SimpleNamespace(name=name, hypothesis=SimpleNamespace(chance=chance, closure="both alike"))
    law = SimpleNamespace(moved=moved)
    said = FORMS | forms
    contest = SimpleNamespace(stand_in=said["instead"], **said)
    return Support(effect, None, Gap(added, spread, 60), share, gaps, law, contest, others)  # type: ignore[arg-type]


def odds(probability: float) -> float:
    return math.log(probability / (1.0 - probability))


def evidence_of(probability: float) -> float:
    """The gap in evidence that is so probable."""
    return float(norm.ppf(probability)) * LOGISTIC


def test_a_name_that_leaves_nothing_is_as_sure_as_names_are() -> None:
    assert odds(shape_probability(support())) == pytest.approx(SURE)


def test_what_forms_explain_beside_a_name_counts_by_how_far_they_could_stand_for_it() -> None:
    left = support(added=100.0, beside=20.0, instead=-50.0)
    assert odds(shape_probability(left)) == pytest.approx(SURE - DOUBT * math.log1p(0.2 * 0.5 / SLIGHT))


def test_forms_that_do_better_in_the_name_s_place_count_against_it() -> None:
    replaced = support(added=100.0, beside=0.0, instead=40.0)
    assert odds(shape_probability(replaced)) == pytest.approx(SURE - ANOTHER * 0.4)


def test_a_law_that_is_another_one_in_each_drive_counts_against_it() -> None:
    assert odds(shape_probability(support(moved=0.3))) == pytest.approx(SURE - ANOTHER * 0.3)


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_uneven_evidence_beside_stronger_effects_counts_against_a_name(share: float) -> None:
    uneven = support(added=100.0, spread=50.0, share=share)
    patchy = (1.0 - share) * math.log1p(0.5 / SLIGHT)
    assert odds(shape_probability(uneven)) == pytest.approx(SURE - DOUBT * patchy)


def test_a_moment_is_uneven_by_nature() -> None:
    push = support("external_push", added=100.0, spread=95.0, share=0.1, chance=1e-3)
    assert push.alone == Gap(100.0, 0.0, 60)
    assert push.patchy == 0.0


@pytest.mark.parametrize("name", ["external_push", "motor_fault"])
def test_an_event_of_a_hundredth_of_what_others_explain_is_within_what_their_equations_leave(
    name: str,
) -> None:
    small, large = (
        support(name, added=100.0, spread=3.0, share=0.1, chance=1e-6, others=others)
        for others in (1e4, 500.0)
    )
    assert large.alone == Gap(100.0, pytest.approx(EXACT * 500.0), 60)
    assert belief_of(small).probability < 0.6 < 0.9 < belief_of(large).probability


def test_a_moment_that_jolts_the_robot_anyway_costs_an_event_its_log_odds() -> None:
    quiet = support("external_push")
    assert odds(shape_probability(replace(quiet, jolted=1.5))) == pytest.approx(
        odds(shape_probability(quiet)) - 1.5
    )


def test_a_moment_that_chance_equals_is_not_believed() -> None:
    stands_out, does_not = (
        belief_of(support("external_push", added=100.0, spread=95.0, share=0.1, chance=p)).probability
        for p in (1e-4, 0.05)
    )
    assert stands_out > 0.9
    assert does_not < 0.6


def test_what_stands_alone_is_no_patch_however_uneven() -> None:
    assert support(added=100.0, spread=100.0, share=1.0).patchy == 0.0


@pytest.mark.parametrize("name", ["payload_offset", "wheel_eccentricity"])
def test_what_every_robot_has_or_keeps_time_with_its_wheels_is_no_patch(name: str) -> None:
    assert support(name, added=100.0, spread=100.0, share=0.01).patchy == 0.0


@pytest.mark.parametrize("moved", [-0.3, math.nan])
def test_what_speaks_for_one_law_or_cannot_be_asked_adds_nothing(moved: float) -> None:
    assert odds(shape_probability(support(moved=moved))) == pytest.approx(SURE)


def test_no_argument_makes_a_name_impossible() -> None:
    assert odds(shape_probability(support(moved=1e6))) == pytest.approx(-LARGEST_LOG_ODDS)


def test_a_name_is_as_probable_as_that_it_adds_anything() -> None:
    belief = belief_of(support(added=evidence_of(0.998), instead=-1e9))
    assert belief.probability == pytest.approx(0.998 * shape_probability(support()))


def test_what_keeps_time_with_the_wheels_may_show_in_few_seconds() -> None:
    assert support(added=65.0, spread=26.0).is_sparse
    assert not support("wheel_eccentricity", added=65.0, spread=26.0).is_sparse


def test_a_name_whose_evidence_chance_may_bring_is_even_odds() -> None:
    belief = belief_of(support(added=evidence_of(0.99), instead=-1e9))
    assert belief.probability == pytest.approx(0.5 * 0.99 * shape_probability(support()))


def test_a_rival_that_the_data_cannot_tell_stands_beside_the_name_and_takes_nothing() -> None:
    belief = belief_of(support(rivals={"caster_drag": evidence_of(TOLD_APART - 0.01)}))
    assert belief.among == ("motor_deadband", "caster_drag")
    assert belief.probability == pytest.approx(shape_probability(support()))


def test_a_rival_that_is_beaten_takes_its_odds() -> None:
    rivals = {"caster_drag": evidence_of(0.97), "payload_offset": evidence_of(0.96)}
    belief = belief_of(support(added=30.0, rivals=rivals))  # a hundredth of it is next to nothing
    assert belief.among == ("motor_deadband",)
    against = 0.03 / 0.97 + 0.04 / 0.96
    assert belief.probability == pytest.approx(shape_probability(support()) / (1.0 + against), rel=2e-3)


@pytest.mark.parametrize(("behind", "among"), [(0.01, True), (0.015, True), (0.018, False), (0.1, False)])
def test_a_rival_that_is_behind_by_a_hundredth_of_what_the_name_explains_stands_beside_it(
    behind, among
) -> None:
    belief = belief_of(support(added=10_000.0, rivals={"caster_drag": behind * 10_000.0}))
    assert ("caster_drag" in belief.among) == among


@pytest.mark.parametrize(("beside", "among"), [(0.0, False), (20.0, False), (120.0, True)])
def test_a_rival_that_what_is_left_could_bring_level_stands_beside_the_name(beside, among) -> None:
    weighed = support(added=1000.0, beside=beside, instead=-400.0, rivals={"caster_drag": 88.0})
    assert ("caster_drag" in belief_of(weighed).among) == among


def test_what_is_left_but_cannot_do_the_name_s_job_lets_no_rival_in() -> None:
    weighed = support(added=1000.0, beside=120.0, instead=-1000.0, rivals={"caster_drag": 88.0})
    assert belief_of(weighed).among == ("motor_deadband",)


@pytest.mark.parametrize(
    ("weighed", "said"),
    [
        (
            support(added=100.0, instead=40.0),
            "a plain dependence on speed does better (evidence 40 more)",
        ),
        (
            support(added=100.0, instead=10.0, beside=20.0),
            "leaves what depends on turn (20 % of what it explains)",
        ),
        (
            support(added=100.0, instead=40.0, instead_quantities=(), beside=20.0),
            "leaves what depends on turn",
        ),
        (
            support(added=100.0, spread=30.0, share=0.1, beside_quantities=()),
            "may only mend what is inexact in stronger effects",
        ),
        (support(added=100.0, spread=60.0), "a handful of seconds has its evidence (100 +- 60)"),
        (
            support(added=100.0, beside=20.0, beside_quantities=(), moved=0.25),
            "each drive asks for another size (25 % is lost)",
        ),
        (support(moved=0.25), "each drive asks for another size"),
        (
            support("external_push", added=100.0, instead=0.0, jump=-90.0),
            "a plain dependence on speed does as well",
        ),
        (
            support("external_push", added=100.0, jump=0.0),
            "a jump of the measured poses does as well",
        ),
        (support(), "nearest: motor_deadband or caster_drag, but not surely enough for a name"),
    ],
)
def test_why_a_name_is_not_given_is_said(weighed: Support, said: str) -> None:
    belief = Belief(weighed.effect, 0.5, ("motor_deadband", "caster_drag"))
    model = Model((), None, None, (), None, (weighed,), (belief,))  # type: ignore[arg-type]
    sentence = decide._complaint(model)
    assert said in sentence
    assert "motor_deadband or caster_drag" in sentence


def judge() -> Judge:
    engine = SimpleNamespace(simulators=("drive",))
    return Judge(engine, [], DEFAULT_GATES, lambda part: None, np.random.default_rng(0))  # type: ignore[arg-type]


def plain_model(**changes: object) -> Model:
    left = Adequacy(1.0, 0.0, 0.0, "turn:time")
    against = SimpleNamespace(loose=False, beside=0.0, beside_quantities=("speed", "turn"))
    return replace(Model((), "base fit", left, (), against), **changes)  # type: ignore[arg-type]


BARE = plain_model()


def answered(
    monkeypatch: pytest.MonkeyPatch,
    outcome: str,
    effects: int,
    named: int,
    in_poses: bool,
    denied: bool = False,
    affirmed: str = "",
    said: tuple[str, ...] = ("command_delay", "coulomb_friction"),
):
    """What the judge decides after this answer, where the poses alone show it or not; and how often they were asked."""
    asked: list[object] = []
    poses = SimpleNamespace(
        show=lambda effects: asked.append(effects) or in_poses,
        deny=lambda fit, name: denied,
        affirm=lambda fit, name: name == affirmed,
    )
    monkeypatch.setattr(decide, "InPoses", lambda simulators, gates: poses)
    monkeypatch.setattr(decide, "bare_model", lambda engine, base, location: BARE)
    model = plain_model(effects=tuple(range(effects)))
    names = tuple(SimpleNamespace(name=name) for name in said[:named])
    answer = Decision(outcome, "because.", None, (), None, model, names, (), None, None)  # type: ignore[arg-type]
    one = judge()
    monkeypatch.setattr(Judge, "_answer", lambda self: answer)
    return answer, one.decide(), len(asked)


def test_a_marker_among_the_names_is_not_asked_of_the_poses_since_no_encoder_sees_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said = ("coulomb_friction", "misplaced_marker")
    answer, decision, asked = answered(monkeypatch, "explained", 3, 2, False, said=said)
    assert decision is answer
    assert asked == 0
    denied = answered(monkeypatch, "explained", 3, 2, False, denied=True, said=said)[1]
    assert denied.outcome == "match"


@pytest.mark.parametrize(("outcome", "effects", "named"), [("match", 0, 0), ("explained", 1, 1)])
def test_a_match_and_one_sure_name_for_all_are_not_asked_of_the_poses(
    monkeypatch: pytest.MonkeyPatch, outcome: str, effects: int, named: int
) -> None:
    answer, decision, asked = answered(monkeypatch, outcome, effects, named, False)
    assert decision is answer
    assert asked == 0


@pytest.mark.parametrize(
    ("outcome", "effects", "named"),
    [("explained", 2, 1), ("explained", 2, 2), ("unexplained", 1, 0), ("unexplained", 0, 0)],
)
def test_any_other_answer_stands_where_the_poses_show_it(
    monkeypatch: pytest.MonkeyPatch, outcome: str, effects: int, named: int
) -> None:
    answer, decision, asked = answered(monkeypatch, outcome, effects, named, True)
    assert decision is answer
    assert asked == 1


def test_one_sure_name_that_the_poses_deny_and_that_they_do_not_show_is_a_match(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, decision, asked = answered(monkeypatch, "explained", 1, 1, False, denied=True)
    assert (decision.outcome, decision.named, asked) == ("match", (), 1)


def test_an_answer_stands_where_the_poses_speak_for_its_strongest_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answer, decision, asked = answered(monkeypatch, "explained", 2, 2, False, affirmed="command_delay")
    assert decision is answer
    assert asked == 0
    weaker = answered(monkeypatch, "explained", 2, 2, False, affirmed="coulomb_friction")[1]
    assert weaker.outcome == "match"


def test_what_the_encoders_alone_see_is_a_match_of_the_bare_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    _, decision, _ = answered(monkeypatch, "explained", 2, 2, False)
    assert (decision.outcome, decision.named, decision.model) == ("match", (), BARE)
    assert decision.reason.endswith("the encoders alone differ: because.")


def test_a_robot_without_effects_keeps_its_model_as_a_match(monkeypatch: pytest.MonkeyPatch) -> None:
    answer, decision, _ = answered(monkeypatch, "unexplained", 0, 0, False)
    assert (decision.outcome, decision.model) == ("match", answer.model)


def nameless(monkeypatch: pytest.MonkeyPatch, model: Model, p_value: float) -> Decision:
    monkeypatch.setattr(decide, "bare_model", lambda engine, base, location: model)
    return judge()._without_name(None, (), SimpleNamespace(p_value=p_value), None)  # type: ignore[arg-type]


LIMIT = -math.log10(ALPHA)  # of a single test


def left_with(surprise: float) -> Model:
    """A model that leaves one test so surprised."""
    test = LeftOver(SimpleNamespace(name="turn:time"), surprise, 9.0, np.zeros(1))  # type: ignore[arg-type]
    return plain_model(adequacy=Adequacy(surprise, 9.0, 1.0, "turn:time"), tests=(test,))


def test_nothing_left_is_a_match(monkeypatch: pytest.MonkeyPatch) -> None:
    assert nameless(monkeypatch, BARE, 0.0).outcome == "match"


def test_a_surprise_that_stays_significant_is_unexplained(monkeypatch: pytest.MonkeyPatch) -> None:
    decision = nameless(monkeypatch, left_with(LIMIT + 0.1), 0.5 * ALPHA)
    assert decision.outcome == "unexplained"
    assert "depends on turn:time" in decision.reason


@pytest.mark.parametrize(("surprise", "p_value"), [(LIMIT + 0.1, ALPHA), (LIMIT, 0.0)])
def test_a_surprise_that_chance_gives_is_a_match(
    monkeypatch: pytest.MonkeyPatch, surprise: float, p_value: float
) -> None:
    assert nameless(monkeypatch, left_with(surprise), p_value).outcome == "match"


@pytest.mark.parametrize(
    ("loose", "more", "outcome"), [(False, 1.0, "unexplained"), (False, 0.0, "match"), (True, 1.0, "match")]
)
def test_forms_without_a_name_that_are_surely_there_are_unexplained(
    monkeypatch: pytest.MonkeyPatch, loose: bool, more: float, outcome: str
) -> None:
    beside = DEFAULT_GATES.detect + more
    against = SimpleNamespace(loose=loose, beside=beside, beside_quantities=("speed", "turn"))
    decision = nameless(monkeypatch, plain_model(contest=against), 1.0)
    assert decision.outcome == outcome
    assert ("speed and turn (evidence 15)" in decision.reason) is (outcome == "unexplained")


def searched(
    monkeypatch: pytest.MonkeyPatch, evidence: float | None, *probabilities: float, implausible: str = ""
) -> Decision:
    """What is answered where the strongest effect has this evidence and the names of the model these probabilities."""
    ranking = [] if evidence is None else [SimpleNamespace(evidence=evidence)]
    selector = SimpleNamespace(
        base=SimpleNamespace(values=()),
        first_ranked=lambda: ("bank", ranking),
        best_grown=lambda ranking: "grown",
        spared=lambda selection: selection,
    )
    effects = [Ranked(Hypothesis(f"effect{i}", ()), None, 0.0, 0.0) for i in range(len(probabilities))]  # type: ignore[arg-type]
    beliefs = tuple(Belief(e, p, (e.name,)) for e, p in zip(effects, probabilities, strict=True))
    supports = tuple(support() for _ in beliefs)
    model = plain_model(effects=tuple(range(len(beliefs))), supports=supports, beliefs=beliefs)
    monkeypatch.setattr(decide, "fit_whole_base", lambda engine, effects, banks: SimpleNamespace(values=()))
    monkeypatch.setattr(decide, "situations_of", lambda simulators, values: ())
    monkeypatch.setattr(decide, "locate", lambda *given: SimpleNamespace(p_value=1.0))
    monkeypatch.setattr(decide, "Selector", lambda *given, **named: selector)
    monkeypatch.setattr(decide, "ranked_if_punctual", lambda *given: given)
    monkeypatch.setattr(decide, "ranked_if_bared", lambda *given: given)
    monkeypatch.setattr(decide, "likelier_if_punctual", lambda *given: given)
    monkeypatch.setattr(decide, "likelier_if_gripping", lambda *given: given)
    monkeypatch.setattr(decide, "likelier_in_two", lambda selector, given: given)
    monkeypatch.setattr(decide, "bare_model", lambda engine, base, location: BARE)
    monkeypatch.setattr(Judge, "_weighed", lambda self, selection: model)
    monkeypatch.setattr(decide, "refined", lambda engine, model, least: model)
    monkeypatch.setattr(decide, "simplified", lambda engine, model: model)
    monkeypatch.setattr(decide, "is_finding", lambda ranked, simulators: ranked.name != implausible)
    monkeypatch.setattr(decide, "placed", lambda engine, fit, effects, rng: "placed")
    monkeypatch.setattr(decide, "dated", lambda engine, fit, effects: (fit, "dated"))
    return judge()._answer()


@pytest.mark.parametrize("evidence", [None, DEFAULT_GATES.first - 0.1])
def test_without_a_detected_effect_there_is_no_name(
    monkeypatch: pytest.MonkeyPatch, evidence: float | None
) -> None:
    assert searched(monkeypatch, evidence, 0.9).model is BARE


def test_a_detected_effect_that_no_name_is_sure_for_is_unexplained(monkeypatch: pytest.MonkeyPatch) -> None:
    decision = searched(monkeypatch, DEFAULT_GATES.first, 0.5, 0.3)
    assert (decision.outcome, decision.named) == ("unexplained", ())
    assert decision.reason.startswith("nearest: effect0")


def test_a_sure_strongest_name_explains_with_its_place_and_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    decision = searched(monkeypatch, DEFAULT_GATES.first, DEFAULT_GATES.least_confidence, 0.3)
    assert (decision.outcome, decision.reason) == ("explained", "detected, adequate and useful")
    assert [belief.name for belief in decision.named] == ["effect0"]
    assert decision.model.fit == ("placed", "dated")


def test_a_sure_weaker_name_explains_a_part_and_the_stronger_is_complained_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    decision = searched(monkeypatch, DEFAULT_GATES.first, 0.5, 0.9)
    assert decision.reason.startswith("effect1 for a part of it; nearest: effect0")


def test_a_sure_strongest_name_that_is_no_longer_what_it_says_is_complained_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    decision = searched(monkeypatch, DEFAULT_GATES.first, 0.9, 0.8, implausible="effect0")
    assert [belief.name for belief in decision.named] == ["effect1"]
    assert decision.reason.startswith("effect1 for a part of it; nearest: effect0")


def test_each_long_part_of_an_answer_is_told_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    weigh, told = Judge._weighed, []
    searched(monkeypatch, None)
    ranking = [SimpleNamespace(evidence=DEFAULT_GATES.first)]
    fit, weighed = SimpleNamespace(values=()), support()
    grown = SimpleNamespace(fit=fit, effects=(weighed.effect,))
    selector = SimpleNamespace(
        base=SimpleNamespace(values=()),
        first_ranked=lambda: ("bank", ranking),
        best_grown=lambda ranking: grown,
        spared=lambda selection: selection,
    )
    monkeypatch.setattr(decide, "Selector", lambda *given, **named: selector)
    monkeypatch.setattr(Judge, "_weighed", weigh)
    monkeypatch.setattr(decide, "feature_groups", lambda situations: ())
    monkeypatch.setattr(decide, "left_over", lambda engine, fit, groups: ())
    monkeypatch.setattr(decide, "supports_of", lambda engine, selection, confidence: (weighed,))
    monkeypatch.setattr(decide, "adequacy", lambda tests, evidence: None)
    monkeypatch.setattr(decide, "sayable", lambda model, least, simulators: model.named(least))
    replace(judge(), progress=told.append)._answer()
    assert told == ["base robot", "what is left", "how sure", "place and moment"]


def test_the_seconds_of_a_part_are_added_up(monkeypatch: pytest.MonkeyPatch) -> None:
    clock: Iterator[float] = iter([10.0, 12.0, 20.0, 25.0])
    monkeypatch.setattr(decide, "perf_counter", lambda: next(clock))
    one = judge()
    for _ in range(2):
        with one.part("base"):
            pass
    assert one.seconds == {"base": 7.0}


@pytest.mark.parametrize(("curve_x", "probability"), [(0.03, 0.5), (0.0, 1.0)])
def test_a_name_that_something_beyond_the_catalogue_equals_is_even_odds(curve_x, probability) -> None:
    table, sure = parameter_table(), support("floor_tilt")
    curved = ("slope_x", "slope_y", "curve_x", "curve_y", "twist")
    values = table.null[None].copy()
    values[0, table.place("floor_tilt.curve_x")] = curve_x
    hypothesis = SimpleNamespace(closure="curved", names=curved, chance=0.0)
    effect = SimpleNamespace(name="floor_tilt", hypothesis=hypothesis, fit=SimpleNamespace(values=values))
    told = belief_of(replace(sure, effect=effect)).probability  # type: ignore[arg-type]
    assert told == pytest.approx(probability * shape_probability(sure), abs=1e-6)


@pytest.mark.parametrize(
    ("delay", "hold", "drag", "probability"),
    [(0.015, 0.0, 0.0, 1.0), (0.015, 4.0, 0.0, 0.5), (0.015, 0.0, 0.1, 0.5), (0.04, 4.0, 0.1, 1.0)],
)
def test_a_delay_that_a_controller_or_a_skid_may_have_is_even_odds(delay, hold, drag, probability) -> None:
    table, sure = parameter_table(), support("command_delay")
    values = table.null[None].copy()
    names = ("command_delay.delay", "speed_controller.hold", "caster_drag.drag")
    values[0, [table.place(name) for name in names]] = delay, hold, drag
    hypothesis = SimpleNamespace(closure="full", names=("delay",), chance=0.0)
    effect = SimpleNamespace(name="command_delay", hypothesis=hypothesis, fit=SimpleNamespace(values=values))
    told = belief_of(replace(sure, effect=effect)).probability  # type: ignore[arg-type]
    assert told == pytest.approx(probability * shape_probability(sure), abs=1e-6)
