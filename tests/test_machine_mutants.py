"""Every slip in the declarations is found by the tests by transition or by the partition of the guards.

The mutants run on the real machine against the hand-written cases; a slip that no case can see because the
library takes the first row that fits (a dropped `unless`) must break the partition.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from machine_case import LIMITS, Case
from machine_cases import CASES
from machine_mutants import Mutant, flat, mutants

from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.guards import EXCLUSIVE
from fsm_calib.machines.supervisor import PHASES, SUPERVISOR
from fsm_calib.statechart.machinery import ancestors
from fsm_calib.statechart.partition import enabled, families, vectors
from fsm_calib.statechart.probe import Probe
from fsm_calib.statechart.spec import Transition

ROWS = tuple(SUPERVISOR.all_transitions())
DESTS = tuple(path for path in CALIBRATION.leaves)
PARTS = (*PHASES, "between")


def around(row: Transition) -> tuple[Transition, ...]:
    """The rows that share the source and the trigger: the only ones a slip in `row` can disturb."""
    return tuple(other for other in ROWS if (other.source, other.trigger) == (row.source, row.trigger))


def cases_of(row: Transition) -> list[Case]:
    """The hand-written cases in leaves that the row's source holds, for its trigger."""
    return [case for case in CASES if case.trigger == row.trigger and row.source in ancestors(case.leaf)]


def breaks_the_partition(rows: tuple[Transition, ...]) -> bool:
    return not rows or any(len(enabled(rows, answers)) != 1 for answers in vectors(rows, EXCLUSIVE))


def fails_a_case(rows: tuple[Transition, ...], cases: list[Case]) -> bool:
    """Whether one of `cases` does not hold on the real machine made of `rows`."""
    rig = Probe(replace(CALIBRATION, root=flat(SUPERVISOR, rows)), LIMITS)
    return any(not holds(rig, case) for case in cases)


def holds(rig: Probe, case: Case) -> bool:
    rig.put(case.leaf, case.before)
    if not rig.fire(case.trigger, case.evidence) or rig.state != case.reached:
        return False
    expected = {**Books(**case.before).to_dict(), "lost_frames": 0, "ticks": 1} | dict(case.after)
    return rig.model.books.to_dict() == expected


def killer(mutant: Mutant) -> str:
    """What finds the mutant: "partition", "case", or nothing."""
    family = around(mutant.row)
    rows = tuple(new for row in family for new in (mutant.rows if row == mutant.row else (row,)))
    if breaks_the_partition(rows):
        return "partition"
    return "case" if fails_a_case(rows, cases_of(mutant.row)) else ""


def part_of(row: Transition) -> str:
    return row.source.split("/")[0]


@pytest.mark.parametrize("part", PARTS)
def test_every_mutant_of_the_declarations_is_killed(part: str, capsys) -> None:
    found = {mutant: killer(mutant) for mutant in mutants(SUPERVISOR, DESTS) if part_of(mutant.row) == part}
    alive = [f"{mutant.slip} in {mutant.row.ident}" for mutant, by in found.items() if not by]
    by_partition = sum(by == "partition" for by in found.values())
    with capsys.disabled():
        print(
            f"\nmutants of {part}: {len(found)}, killed {len(found) - len(alive)} (partition {by_partition})"
        )
    assert found
    assert alive == []


@pytest.mark.parametrize("part", PARTS)
def test_unchanged_table_passes_what_kills_the_mutants(part: str) -> None:
    for (source, trigger), rows in families(ROWS).items():
        if source.split("/")[0] == part:
            cases = [case for case in CASES if case.trigger == trigger and source in ancestors(case.leaf)]
            assert cases
            assert not breaks_the_partition(tuple(rows))
            assert not fails_a_case(tuple(rows), cases)
