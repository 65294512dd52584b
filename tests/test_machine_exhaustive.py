"""The real machine in every configuration: no dead end, always an end, every row fires, failure near."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from graphlib import TopologicalSorter

import pytest

from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.check import small_limits
from fsm_calib.machines.supervisor import PHASES, SUPERVISOR
from fsm_calib.statechart.exhaustive import check_exhaustively
from fsm_calib.statechart.explore import Config, Explored, counted, explore

NAMES = counted(CALIBRATION)


@dataclass(frozen=True)
class Setting:
    """Boards, misses before lost, published bound check, passes, budget of everything else, phases."""

    boards: int
    misses: int = 2
    late: bool = False
    passes: int = 1
    budget: int = 2
    plan: tuple[str, ...] = ("scan",)


SETTINGS = [
    *(Setting(boards) for boards in range(1, 7)),
    *(Setting(boards, misses=1, late=True) for boards in range(1, 7)),
    Setting(2, misses=1, passes=2, budget=1),
    Setting(2, misses=3, passes=2, budget=1),
    Setting(2, misses=1, passes=2, late=True),
    Setting(2, plan=PHASES),
]


@cache
def graph(setting: Setting) -> Explored:
    limits = small_limits(
        setting.boards,
        late=setting.late,
        passes=setting.passes,
        budget=setting.budget,
        misses=setting.misses,
    )
    return explore(CALIBRATION, limits, list(setting.plan))


def book(config: Config, name: str):
    return config[1][NAMES.index(name)]


@pytest.mark.parametrize("setting", SETTINGS, ids=str)
def test_every_run_ends_because_no_configuration_comes_back(setting: Setting) -> None:
    ways = graph(setting).ways
    order = TopologicalSorter({config: set(steps.values()) for config, steps in ways.items()})
    assert len(list(order.static_order())) == len(ways)


@pytest.mark.parametrize("setting", SETTINGS, ids=str)
def test_only_ends_have_no_way_on(setting: Setting) -> None:
    stuck = [config for config, steps in graph(setting).ways.items() if not steps]
    assert {CALIBRATION.leaves[leaf].do for leaf, _ in stuck} == {""}


@pytest.mark.parametrize("setting", SETTINGS, ids=str)
def test_success_can_be_reached_from_the_start_and_abort_from_everywhere(setting: Setting) -> None:
    explored = graph(setting)
    done = [config for config in explored.ends if config[0] == "done"]
    assert next(iter(explored.ways)) in explored.reaching(done)
    for steps in explored.ways.values():
        assert not steps or steps["abort", ()][0] == "aborted"


@pytest.mark.parametrize("setting", SETTINGS, ids=str)
def test_a_named_failure_can_be_reached_from_wherever_the_robot_still_has_to_look_or_drive(
    setting: Setting,
) -> None:
    explored = graph(setting)
    failing = explored.reaching(config for config in explored.ends if config[0].startswith("failed/"))
    safe = {config for config, steps in explored.ways.items() if steps and config not in failing}
    assert {leaf for leaf, _ in safe} - {"lane/judging"} == {"between"}
    assert all(book(config, "plan") == () for config in safe)


@pytest.mark.parametrize("setting", SETTINGS, ids=str)
def test_the_board_stays_in_its_row_or_one_step_beside_it_as_published(setting: Setting) -> None:
    seen = {book(config, "board") for config in graph(setting).ways if config[0].startswith("scan/")}
    assert seen == set(range(-1, setting.boards + 1) if setting.late else range(setting.boards))


def test_every_row_of_the_table_is_taken_and_every_failure_happens() -> None:
    taken = set().union(*(graph(setting).taken for setting in SETTINGS))
    assert {edge.ident for edge in SUPERVISOR.all_transitions()} == taken
    ends = {leaf for setting in SETTINGS for leaf, _ in graph(setting).ends}
    assert ends == {path for path, state in CALIBRATION.leaves.items() if not state.do}


def test_the_check_of_the_whole_calibration_finds_nothing() -> None:
    findings = check_exhaustively(CALIBRATION)
    assert findings.problems == ()
    assert findings.configurations > 1_000


def test_numbers_of_the_exhaustive_check(capsys) -> None:
    configurations = sum(len(graph(setting).ways) for setting in SETTINGS)
    fired = sum(len(steps) for setting in SETTINGS for steps in graph(setting).ways.values())
    with capsys.disabled():
        print(
            f"\nexhaustive check: {configurations} configurations, {fired} outcomes fired on the real machine"
        )
    assert configurations > 10_000
    assert fired > 40_000
