"""Every declared transition does what its hand-written case says, and there is a case for each of them."""

from __future__ import annotations

from collections import Counter

import pytest
from machine_case import LIMITS, Case
from machine_cases import CASES

from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.supervisor import SUPERVISOR
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.probe import Probe
from fsm_calib.statechart.runtime import Machine

DECLARED = Counter(edge.ident for edge in SUPERVISOR.all_transitions())


@pytest.fixture(scope="module")
def rig() -> Probe:
    return Probe(CALIBRATION, LIMITS)


def marked(case: Case):
    name = f"{case.leaf}--{case.trigger}[{case.condition}]->{case.reached}"
    return pytest.param(case, id=name, marks=pytest.mark.covers(case.covers))


@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_transition_leads_where_it_should_and_keeps_the_books(rig: Probe, case: Case) -> None:
    books = Books(**{**case.before, "plan": list(case.before.get("plan", ()))})
    machine = Machine(CALIBRATION, LIMITS, books=books, state=case.leaf)
    fired = machine.fire(Outcome(case.trigger, case.evidence))
    assert fired.transition == case.covers
    assert (fired.source, machine.state) == (case.leaf, case.reached)
    expected = {**Books(**case.before).to_dict(), "lost_frames": 0, "ticks": 1} | dict(case.after)
    assert books.to_dict() | {"failure": {}} == expected


@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_guards_of_the_transition_are_asked_and_recorded(rig: Probe, case: Case) -> None:
    rig.put(case.leaf, case.before)
    assert rig.fire(case.trigger, case.evidence)
    names = [name for name in case.condition.split(" & ") if name]
    wanted = {name.removeprefix("!"): not name.startswith("!") for name in names}
    assert {name: rig.model.answers[name] for name in wanted} == wanted


def test_declared_transitions_and_tested_transitions_are_the_same() -> None:
    tested = {case.covers for case in CASES}
    assert sorted(set(DECLARED) - tested) == [], "declared, but without a test"
    assert sorted(tested - set(DECLARED)) == [], "tested, but not declared"
    assert set(DECLARED.values()) == {1}


def test_every_leaf_is_tested_with_every_outcome_that_it_declares() -> None:
    tested = {(case.leaf, case.trigger) for case in CASES}
    wanted = {(leaf, trigger) for leaf in CALIBRATION.leaves for trigger in CALIBRATION.declared(leaf)}
    assert wanted - tested == set()
