"""What is not declared does not happen: an undeclared pair of leaf and outcome raises and moves nothing."""

from __future__ import annotations

import pytest
from machine_case import LIMITS

from fsm_calib.errors import UnknownNameError
from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.supervisor import SUPERVISOR
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.machinery import ancestors
from fsm_calib.statechart.runtime import Machine, UndeclaredOutcomeError

EVIDENCE = {"sharp": True, "quiet": True, "heading": 0.0, "turned": 0.0}
TRIGGERS = sorted({edge.trigger for edge in SUPERVISOR.all_transitions()})
TABLE = {(edge.source, edge.trigger) for edge in SUPERVISOR.all_transitions()}


def undeclared(leaf: str) -> list[str]:
    """The outcomes without a row for the leaf or a state around it, read off the table itself."""
    return [name for name in TRIGGERS if not any((state, name) in TABLE for state in ancestors(leaf))]


@pytest.mark.parametrize("leaf", sorted(CALIBRATION.leaves))
def test_undeclared_outcome_raises_and_moves_nothing(leaf: str) -> None:
    machine = Machine(CALIBRATION, LIMITS, books=Books(plan=["wheels"], board=1, misses=1), state=leaf)
    before = machine.books.to_dict()
    for trigger in [*undeclared(leaf), "never_heard_of"]:
        with pytest.raises(UndeclaredOutcomeError, match=trigger):
            machine.fire(Outcome(trigger, EVIDENCE))
        assert (machine.state, machine.books.to_dict()) == (leaf, before)


def test_there_are_undeclared_pairs_in_every_leaf() -> None:
    assert min(len(undeclared(leaf)) for leaf in CALIBRATION.leaves) >= len(TRIGGERS) // 2


@pytest.mark.parametrize("leaf", [leaf for leaf, state in CALIBRATION.leaves.items() if not state.do])
def test_ends_have_no_way_out(leaf: str) -> None:
    assert undeclared(leaf) == TRIGGERS
    assert Machine(CALIBRATION, state=leaf).is_terminal


def test_missing_evidence_is_the_action_s_fault_and_moves_nothing() -> None:
    machine = Machine(CALIBRATION, LIMITS, books=Books(), state="wheels/updating")
    with pytest.raises(KeyError, match="quiet"):
        machine.fire(Outcome("ratio_updated"))
    assert (machine.state, machine.books.to_dict()) == ("wheels/updating", Books().to_dict())


def test_unknown_state_and_unknown_phase_are_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match="wheels/forward"):
        Machine(CALIBRATION, state="wheels/foward")
    with pytest.raises(UnknownNameError, match="orientation"):
        Machine(CALIBRATION, plan=["orientatoin"])
