"""The investigation's machine: every configuration, every row, and that the diagrams show it."""

from __future__ import annotations

from pathlib import Path

import pytest

from fsm_calib.machines.investigate import INVESTIGATE
from fsm_calib.machines.investigate_books import InvestigateBooks, InvestigateLimits
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.diagrams import stale_diagrams
from fsm_calib.statechart.exhaustive import check_exhaustively
from fsm_calib.statechart.runtime import Machine
from fsm_calib.statechart.validate import validate

DIAGRAMS = Path(__file__).parent.parent / "diagrams" / "investigate"
LIMITS = InvestigateLimits(drives=2, returns=2, misses=2, places=2)


def after(state: str, trigger: str, books: dict | None = None, **evidence: object) -> Machine:
    """The machine after one outcome in `state` with `books`."""
    machine = Machine(INVESTIGATE, LIMITS, books=InvestigateBooks(**(books or {})), state=state)
    machine.fire(Outcome(trigger, evidence))
    return machine


def test_tables_are_sound() -> None:
    assert validate(INVESTIGATE) == []


def test_every_configuration_is_decided_and_ends() -> None:
    assert check_exhaustively(INVESTIGATE).problems == ()


def test_diagrams_are_current() -> None:
    assert stale_diagrams(INVESTIGATE, DIAGRAMS) == []


@pytest.mark.parametrize(
    ("state", "trigger", "evidence", "books", "dest"),
    [
        ("localising", "localised", {"roomy": True}, {}, "designing"),
        ("localising", "localised", {"roomy": False}, {}, "returning"),
        ("localising", "localised", {"roomy": False}, {"returns": 2}, "failed/not_returning"),
        ("localising", "pose_missing", {}, {}, "searching"),
        ("searching", "moved", {}, {}, "localising"),
        ("localising", "pose_missing", {}, {"misses": 1}, "failed/out_of_sight"),
        ("returning", "moved", {}, {}, "localising"),
        ("designing", "drive_designed", {}, {}, "driving"),
        ("designing", "nothing_to_learn", {"sure": True}, {}, "done"),
        ("designing", "nothing_to_learn", {"sure": False, "cramped": False}, {}, "given_up/nothing_to_learn"),
        ("designing", "nothing_to_learn", {"sure": False, "cramped": True}, {}, "returning"),
        (
            "designing",
            "nothing_to_learn",
            {"sure": False, "cramped": True},
            {"places": 1},
            "given_up/nothing_to_learn",
        ),
        ("designing", "no_room", {}, {}, "returning"),
        ("designing", "no_room", {}, {"places": 1}, "given_up/no_room"),
        ("driving", "drive_finished", {}, {}, "diagnosing"),
        ("driving", "drive_cut", {}, {}, "diagnosing"),
        ("driving", "pose_missing", {}, {}, "localising"),
        ("diagnosing", "diagnosed", {}, {}, "judging"),
        ("diagnosing", "drives_refused", {}, {"drives": 1}, "localising"),
        ("diagnosing", "drives_refused", {}, {"drives": 2}, "failed/unreadable"),
        ("judging", "answer_judged", {"sure": True, "time_left": False}, {}, "done"),
        ("judging", "answer_judged", {"sure": False, "time_left": True}, {"drives": 1}, "localising"),
        (
            "judging",
            "answer_judged",
            {"sure": False, "time_left": True},
            {"drives": 2},
            "given_up/budget_spent",
        ),
        ("judging", "answer_judged", {"sure": False, "time_left": False}, {}, "given_up/budget_spent"),
    ],
)
def test_outcome_leads_where_it_should(state, trigger, evidence, books, dest) -> None:
    assert after(state, trigger, books, **evidence).state == dest


def test_every_drive_is_counted() -> None:
    assert after("designing", "drive_designed").books.drives == 1


def test_a_drive_forgives_the_places_that_had_none() -> None:
    assert after("designing", "drive_designed", {"places": 1}).books.places == 0


def test_seeing_the_robot_where_there_is_room_forgives_returns_and_misses() -> None:
    books = after("localising", "localised", {"returns": 1, "misses": 1}, roomy=True).books
    assert (books.returns, books.misses) == (0, 0)


def test_budget_that_is_spent_is_told_with_its_numbers() -> None:
    machine = after("judging", "answer_judged", {"drives": 2}, sure=False, time_left=True)
    assert "after 2 drives" in machine.failure.reason
    assert "--from" in machine.failure.cure
