"""The exhaustive check of a machine: every configuration is visited, and what must hold in each is asked.

That is: guards leave exactly one transition enabled; every outcome is taken; no configuration comes back, so that
every run ends; success can be reached; `abort` leads to `aborted` from everywhere; every row of the table is taken,
and every end happens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

from fsm_calib.errors import InputError
from fsm_calib.statechart.explore import Explored, explore
from fsm_calib.statechart.machinery import Machinery, Small
from fsm_calib.statechart.partition import undecided

DONE, ABORTED = "done", "aborted"


@dataclass(frozen=True, slots=True)
class Findings:
    """What the check did and found: configurations visited, outcomes fired, and what is wrong, a sentence each."""

    configurations: int
    outcomes: int
    problems: tuple[str, ...]


def check_exhaustively(machinery: Machinery) -> Findings:
    """Visit every configuration of a sound machinery under each of its `small` limits."""
    graphs: list[Explored] = []
    problems = list(undecided(machinery))
    try:
        for small in machinery.small or (Small(machinery.limits()),):
            plan = machinery.phases if small.plan is None else small.plan
            graphs.append(explore(machinery, small.limits, plan))
            problems += _endless(graphs[-1])
            problems += _goals(graphs[-1])
        problems += _unused(machinery, graphs)
    except InputError as error:
        problems.append(str(error))
    configurations = sum(len(graph.ways) for graph in graphs)
    fired = sum(len(steps) for graph in graphs for steps in graph.ways.values())
    return Findings(configurations, fired, tuple(dict.fromkeys(problems)))


def _endless(graph: Explored) -> Iterator[str]:
    """Yield a sentence when a configuration comes back: nothing was spent on the way, so that it may go on for ever."""
    order = TopologicalSorter({config: set(steps.values()) for config, steps in graph.ways.items()})
    try:
        order.prepare()
    except CycleError as error:
        leaves = dict.fromkeys(leaf for leaf, _ in reversed(error.args[1]))
        yield f"a run may go on for ever through {', '.join(leaves)}: no budget is spent on the way"


def _goals(graph: Explored) -> Iterator[str]:
    start = next(iter(graph.ways))
    if start not in graph.reaching([config for config in graph.ends if config[0] == DONE]):
        yield f"{DONE} cannot be reached from the start"
    for (leaf, _), steps in graph.ways.items():
        if steps and steps["abort", ()][0] != ABORTED:
            yield f"state {leaf}: abort does not lead to {ABORTED}"


def _unused(machinery: Machinery, graphs: list[Explored]) -> Iterator[str]:
    taken = set().union(*(graph.taken for graph in graphs))
    for edge in machinery.transitions:
        if edge.ident not in taken:
            yield f"transition {edge.ident} is never taken"
    happened = {leaf for graph in graphs for leaf, _ in graph.ends}
    for path, state in machinery.leaves.items():
        if not state.do and path not in happened:
            yield f"state {path} is never reached"
