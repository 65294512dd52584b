"""Guards are complete and exclusive: whatever they answer, exactly one transition is enabled."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import pytest

from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.guards import EXCLUSIVE, GUARDS
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.statechart.partition import enabled, families, vectors


@pytest.mark.parametrize(("source", "trigger"), sorted(families(CALIBRATION.transitions)))
def test_exactly_one_transition_is_enabled_for_every_answer_of_the_guards(source: str, trigger: str) -> None:
    edges = families(CALIBRATION.transitions)[source, trigger]
    for answers in vectors(edges, EXCLUSIVE):
        assert len(enabled(edges, answers)) == 1, answers


def plans() -> Iterator[list[str]]:
    for chosen in product((False, True), repeat=len(PHASES)):
        yield [phase for phase, wanted in zip(PHASES, chosen, strict=True) if wanted]


@pytest.mark.parametrize("family", EXCLUSIVE)
def test_exactly_one_guard_of_an_exclusive_family_holds_for_every_plan(family: tuple[str, ...]) -> None:
    for plan in plans():
        assert sum(GUARDS[name](Books(plan=plan), Limits(), {}) for name in family) == 1, plan
