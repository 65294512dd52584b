"""The check of the tables finds what can be wrong with them, and finds nothing wrong with ours."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.supervisor import MACHINES, SUPERVISOR
from fsm_calib.statechart.compile import compile_chart
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.spec import Chart, State, Transition, always, choose, otherwise, when
from fsm_calib.statechart.validate import validate

SOUND = Chart(
    "toy",
    "A toy.",
    (
        State("going", do="stop_wheels"),
        State("nest", children=(State("inner", do="hand_over"),)),
        State("done"),
        State("aborted"),
    ),
    (
        *always("wheels_stopped", "going", "nest"),
        *always("control_handed", "nest", "done"),
        *always("abort", ("going", "nest"), "aborted"),
    ),
)


def of(chart: Chart) -> Machinery:
    """The calibration's guards, actions and activities with another root."""
    return replace(CALIBRATION, root=chart)


def test_our_tables_are_sound() -> None:
    assert validate(CALIBRATION) == []


def test_sound_toy_is_sound() -> None:
    assert validate(of(SOUND)) == []


def with_edge(**changes) -> Chart:
    """The toy with its first transition changed."""
    first, *rest = SOUND.transitions
    return replace(SOUND, transitions=(replace(first, **changes), *rest))


def with_states(*states: State) -> Chart:
    return replace(SOUND, states=(*SOUND.states, *states))


@pytest.mark.parametrize(
    ("chart", "finding"),
    [
        (with_edge(dest="nset"), "no state nset"),
        (with_edge(source="gong"), "no state gong"),
        (with_edge(guards=("is_shrp",)), "no guard is_shrp"),
        (with_edge(unless=("is_shrp",)), "no guard is_shrp"),
        (with_edge(actions=("count_lok",)), "no action count_lok"),
        (with_edge(trigger="wheels_stoped"), "may return wheels_stopped, which is not declared"),
        (with_edge(trigger="wheels_stoped"), "wheels_stoped is declared, but stop_wheels never returns it"),
        (with_edge(dest="done"), "state nest/inner is never entered"),
        (with_states(State("done")), "declared 2 times"),
        (with_states(State("Dead_End")), "lower-case"),
        (with_states(State("idle", do="sleep")), "no activity sleep"),
        (replace(SOUND, transitions=SOUND.transitions * 2), "declared 2 times"),
        (
            replace(SOUND, transitions=(*SOUND.transitions, Transition("control_handed", "done", "going"))),
            "no way out",
        ),
        (
            replace(
                SOUND, transitions=(*SOUND.transitions, Transition("control_handed", "nest/inner", "done"))
            ),
            "both at nest/inner and around it, at nest",
        ),
        (
            replace(
                SOUND,
                transitions=(
                    SOUND.transitions[0],
                    Transition("control_handed", "nest", "going"),
                ),
            ),
            "leads to no end",
        ),
    ],
)
def test_slip_in_a_table_is_found(chart: Chart, finding: str) -> None:
    problems = validate(of(chart))
    assert any(finding in problem for problem in problems), problems


def test_running_machine_has_exactly_the_declared_transitions() -> None:
    machine = compile_chart(SUPERVISOR)
    running = {
        (source, trigger, edge.ident)
        for trigger, event in machine.events.items()
        for source, edges in event.transitions.items()
        for edge in edges
        if edge.ident
    }
    assert running == {(edge.source, edge.trigger, edge.ident) for edge in SUPERVISOR.all_transitions()}
    assert len(machine.get_transitions()) == len(running)


def test_running_machine_has_exactly_the_declared_states() -> None:
    assert sorted(compile_chart(SUPERVISOR).get_nested_state_names()) == sorted(dict(SUPERVISOR.walk()))


@pytest.mark.parametrize("chart", MACHINES, ids=lambda chart: chart.name)
def test_machine_reads_alone_and_leaves_only_to_the_supervisor(chart: Chart) -> None:
    own = dict(chart.walk())
    for edge in chart.transitions:
        assert edge.source in own
        assert edge.dest is None or edge.dest in own or edge.dest.startswith("/")


def test_choice_is_exclusive_whatever_its_order() -> None:
    rows = choose("t", ("a", "b"), when("g", "x"), when("h", "y", "act"), otherwise(None))
    assert [(row.source, row.condition, row.dest, row.actions) for row in rows[:3]] == [
        ("a", "g", "x", ()),
        ("a", "h & !g", "y", ("act",)),
        ("a", "!g & !h", None, ()),
    ]
    assert [row.source for row in rows] == ["a"] * 3 + ["b"] * 3
