"""The exhaustive check of a machine: what it fires, what it refuses and in which words; rows of a table as text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from fsm_calib.errors import InputError
from fsm_calib.statechart.activity import OPERATOR, Activity, Returned, contract_of
from fsm_calib.statechart.books import Books
from fsm_calib.statechart.exhaustive import check_exhaustively
from fsm_calib.statechart.explore import Sampled, counted, explore, outcomes
from fsm_calib.statechart.machinery import Machinery, NoLimits, Small
from fsm_calib.statechart.partition import undecided
from fsm_calib.statechart.spec import Chart, State, Transition, always, choose, otherwise, when


@dataclass(slots=True)
class Steps(Books):
    """Books with one count."""

    steps: int = 0


def has_steps_left(books: Steps, limits: object, evidence: Mapping[str, Any]) -> bool:
    return books.steps < 2


def is_far(books: Steps, limits: object, evidence: Mapping[str, Any]) -> bool:
    return bool(evidence["way"] > 1.0)


def count_step(books: Steps, limits: object, evidence: Mapping[str, Any]) -> None:
    books.steps += 1


WALK = Activity(
    "walk",
    "Walks.",
    (Returned("walked", "One step.", ("way: m, its length", "tired: bool, whether it was the last")),),
)
CHART = Chart(
    "walker",
    "Walks.",
    (State("walking", do="walk"), State("done"), State("aborted")),
    (
        *choose("walked", "walking", when("has_steps_left", None, "count_step"), otherwise("done")),
        *always("abort", "walking", "aborted"),
    ),
)
WALKER = Machinery(
    CHART,
    guards={"has_steps_left": has_steps_left, "is_far": is_far},
    actions={"count_step": count_step},
    contract=contract_of(WALK),
    books=Steps,
    samples={"way": (0.5, 2.0)},
)


def rewired(*rows: Transition, states: tuple[State, ...] = CHART.states, **changes: object) -> Machinery:
    """The walker with other rows, and a way to end it."""
    chart = replace(CHART, states=states, transitions=(*rows, *always("abort", "walking", "aborted")))
    return replace(WALKER, root=chart, **changes)  # type: ignore[arg-type]


def test_a_row_is_shown_with_its_trigger_its_condition_and_its_actions() -> None:
    row = Transition("walked", "walking", None, ("a",), ("b",), ("count_step", "rest"))
    assert row.label == "walked [a & !b] / count_step, rest"
    assert replace(row, actions=()).label == "walked [a & !b]"
    assert Transition("walked", "walking", "done").label == "walked"


def test_the_keys_of_evidence_are_what_stands_before_their_explanations() -> None:
    assert WALK.returns[0].keys == ("way", "tired")


def test_a_sound_machine_is_visited_whole_without_a_problem() -> None:
    findings = check_exhaustively(WALKER)
    assert findings.problems == ()
    assert findings.configurations == 3 + 1 + 3  # walking by its steps, done after two, aborted after any
    assert findings.outcomes == 3 * (4 + 1)


def test_every_outcome_is_fired_with_all_samples_and_truth_values_and_so_is_the_operators() -> None:
    fired = [(trigger, dict(evidence)) for trigger, evidence in outcomes(WALKER, "walking")]
    ways = [{"way": way, "tired": tired} for way in (0.5, 2.0) for tired in (True, False)]
    assert fired == [*(("walked", evidence) for evidence in ways), *((trigger, {}) for trigger in OPERATOR)]


def test_books_that_only_count_outcomes_tell_no_configurations_apart() -> None:
    assert counted(WALKER) == ("plan", "phase", "steps")


def test_evidence_without_samples_is_refused_however_it_is_asked_for() -> None:
    evidence = Sampled({"tired": True}.items(), frozenset({"way"}))
    assert (evidence["tired"], evidence.get("tired"), evidence.get("other", 3)) == (True, True, 3)
    for ask in (evidence.__getitem__, evidence.get):
        with pytest.raises(InputError, match=r"no samples of the evidence way.*both sides"):
            ask("way")


def test_a_guard_that_reads_evidence_without_samples_is_named() -> None:
    rows = choose("walked", "walking", when("is_far", "done"), otherwise("aborted"))
    (problem,) = check_exhaustively(rewired(*rows, samples={})).problems
    assert "no samples of the evidence way" in problem


def test_an_outcome_that_no_row_takes_is_a_dead_end_with_its_evidence() -> None:
    rows = (Transition("walked", "walking", "done", guards=("is_far",)),)
    with pytest.raises(
        InputError, match=r"state walking: dead end: walked with \{'way': 0.5, 'tired': True\} is not"
    ):
        explore(rewired(*rows), NoLimits(), ())


def test_an_outcome_without_evidence_that_no_row_takes_is_named_alone() -> None:
    contract = contract_of(replace(WALK, returns=(Returned("stood", "No step."),)))
    rows = (Transition("stood", "walking", "done", unless=("has_steps_left",)),)
    with pytest.raises(InputError, match="dead end: stood is not taken"):
        explore(rewired(*rows, contract=contract), NoLimits(), ())


def test_a_guard_that_fails_is_told_with_its_error() -> None:
    rows = choose("walked", "walking", when("is_far", "done"), otherwise("aborted"))
    with pytest.raises(InputError, match="on walked a guard or an action fails with TypeError"):
        explore(rewired(*rows, samples={"way": ("far",)}), NoLimits(), ())


def test_a_machine_with_more_configurations_than_allowed_is_refused() -> None:
    assert len(explore(WALKER, NoLimits(), (), ceiling=7).ways) == 7
    with pytest.raises(InputError, match="more than 6 configurations"):
        explore(WALKER, NoLimits(), (), ceiling=6)


def test_a_way_back_that_spends_nothing_may_go_on_for_ever() -> None:
    rows = choose("walked", "walking", when("is_far", "resting"), otherwise("done"))
    back = always("walked", "resting", "walking")
    abort = always("abort", "resting", "aborted")
    states = (*CHART.states, State("resting", do="walk"))
    problems = check_exhaustively(rewired(*rows, *back, *abort, states=states)).problems
    assert problems == ("a run may go on for ever through walking, resting: no budget is spent on the way",)


def test_success_that_no_run_comes_to_is_told() -> None:
    rows = choose("walked", "walking", when("has_steps_left", None, "count_step"), otherwise("aborted"))
    assert "done cannot be reached from the start" in check_exhaustively(rewired(*rows)).problems


def test_an_abort_that_leads_elsewhere_is_told() -> None:
    chart = replace(CHART, transitions=(*CHART.transitions[:-1], *always("abort", "walking", "done")))
    problems = check_exhaustively(replace(WALKER, root=chart)).problems
    assert "state walking: abort does not lead to aborted" in problems


def test_rows_that_no_run_takes_and_ends_that_no_run_comes_to_are_told() -> None:
    states = (*CHART.states, State("lost"))
    rows = choose(
        "walked",
        "walking",
        when("has_steps_left", None, "count_step"),
        when("is_far", "done"),
        otherwise("lost"),
    )
    problems = check_exhaustively(rewired(*rows, states=states, samples={"way": (2.0,)})).problems
    assert problems == (
        "transition walking--walked[!has_steps_left & !is_far]->lost is never taken",
        "state lost is never reached",
    )


def test_each_of_the_small_limits_is_visited() -> None:
    twice = replace(WALKER, small=(Small(NoLimits(), ()), Small(NoLimits(), ())))
    once = check_exhaustively(WALKER)
    assert check_exhaustively(twice).configurations == 2 * once.configurations


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ((Transition("walked", "walking", "done", ("is_far",)),), "0 transitions are enabled when !is_far"),
        (
            (Transition("walked", "walking", "done", ("is_far",)), Transition("walked", "walking", None)),
            "2 transitions are enabled when is_far",
        ),
        ((Transition("walked", "walking", "done"),) * 2, "2 transitions are enabled when no guard"),
    ],
)
def test_guards_that_leave_no_choice_or_more_than_one_are_told(
    rows: tuple[Transition, ...], said: str
) -> None:
    (problem,) = undecided(rewired(*rows))
    assert problem == f"state walking: on walked, {said}"
