"""What can be wrong with a declared machine, found before it runs.

The library finds a misspelt callback or destination only when it comes to it, and a misspelt source never; so
the tables are checked as a whole: names, levels, ends, reachability (every state can be entered, every state
can end) and the contract with the activities.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping

from fsm_calib.machines.activities import CONTRACT
from fsm_calib.machines.bookkeeping import ACTIONS
from fsm_calib.machines.guards import GUARDS
from fsm_calib.machines.spec import SEPARATOR, Chart, State, Transition

NAME = re.compile(r"[a-z]+(_[a-z]+)*")
OPERATOR = ("abort",)
"""Triggers that come from the operator and not from an activity."""


def validate(chart: Chart) -> list[str]:
    """Return everything that is wrong with the root chart `chart`, a sentence each; empty when it is
    sound.
    """
    states = dict(chart.walk())
    edges = tuple(chart.all_transitions())
    problems = [
        *_names(chart),
        *_edges(states, edges),
        *_levels(states, edges),
    ]
    return problems or [*_contract(states, edges), *_reach(chart, states, edges)]


def initial_leaf(states: Mapping[str, State], path: str) -> str:
    """Return the leaf that is entered when `path` is entered."""
    while states[path].inside:
        path += SEPARATOR + states[path].inside[0].name
    return path


def ancestors(path: str) -> tuple[str, ...]:
    """Return `path` and the paths of the states around it, innermost first."""
    parts = path.split(SEPARATOR)
    return tuple(SEPARATOR.join(parts[:n]) for n in range(len(parts), 0, -1))


def _names(chart: Chart) -> Iterator[str]:
    for path, count in Counter(path for path, _ in chart.walk()).items():
        if count > 1:
            yield f"state {path} is declared {count} times"
        if not NAME.fullmatch(path.rsplit(SEPARATOR, 1)[-1]):
            yield f"state {path}: a name is lower-case words joined by _"


def _edges(states: Mapping[str, State], edges: tuple[Transition, ...]) -> Iterator[str]:
    for ident, count in Counter(edge.ident for edge in edges).items():
        if count > 1:
            yield f"transition {ident} is declared {count} times"
    for edge in edges:
        yield from (
            f"{edge.ident}: no state {end}" for end in (edge.source, edge.dest) if end and end not in states
        )
        yield from (
            f"{edge.ident}: no guard {name}" for name in edge.guards + edge.unless if name not in GUARDS
        )
        yield from (f"{edge.ident}: no action {name}" for name in edge.actions if name not in ACTIONS)
        source = states.get(edge.source)
        if source and not source.inside and not source.do:
            yield f"{edge.ident}: {edge.source} is an end and has no way out"


def _levels(states: Mapping[str, State], edges: tuple[Transition, ...]) -> Iterator[str]:
    """The library asks the leaf first and the states around it next: one trigger at two levels would depend
    on it.
    """
    at = {(edge.source, edge.trigger) for edge in edges}
    for source, trigger in sorted(at):
        for outer in ancestors(source)[1:]:
            if (outer, trigger) in at:
                yield f"trigger {trigger} is declared both at {source} and around it, at {outer}"


def _contract(states: Mapping[str, State], edges: tuple[Transition, ...]) -> Iterator[str]:
    for path, state in states.items():
        if state.inside or not state.do:
            continue
        if state.do not in CONTRACT:
            yield f"state {path}: no activity {state.do}"
            continue
        declared = {edge.trigger for edge in edges if edge.source in ancestors(path)} - set(OPERATOR)
        promised = set(CONTRACT[state.do].triggers)
        for trigger in sorted(promised - declared):
            yield f"state {path}: {state.do} may return {trigger}, which is not declared"
        for trigger in sorted(declared - promised):
            yield f"state {path}: {trigger} is declared, but {state.do} never returns it"


def _reach(chart: Chart, states: Mapping[str, State], edges: tuple[Transition, ...]) -> Iterator[str]:
    """Every leaf can be entered from the start, and from every leaf an end can be reached."""
    leaves = [path for path, state in states.items() if not state.inside]
    ways: dict[str, set[str]] = {leaf: set() for leaf in leaves}
    for leaf in leaves:
        for edge in edges:
            if edge.dest and edge.source in ancestors(leaf):
                ways[leaf].add(initial_leaf(states, edge.dest))
    start = initial_leaf(states, chart.states[0].name)
    entered = _closure({start}, ways)
    yield from (f"state {leaf} is never entered" for leaf in leaves if leaf not in entered)
    ends = {leaf for leaf in leaves if not states[leaf].do}
    into = {leaf: {source for source in leaves if leaf in ways[source]} for leaf in leaves}
    ending = _closure(ends, into)
    yield from (f"state {leaf} leads to no end" for leaf in leaves if leaf not in ending)


def _closure(start: set[str], ways: Mapping[str, set[str]]) -> set[str]:
    found, fresh = set(start), list(start)
    while fresh:
        fresh_ways = ways[fresh.pop()] - found
        found |= fresh_ways
        fresh.extend(fresh_ways)
    return found
