"""What can be wrong with a declared machine, found before it runs.

The library finds a misspelt callback or destination only when it comes to it, and a misspelt source never; so
the tables are checked as a whole: names, levels, ends, reachability (every state can be entered, every state
can end) and the contract with the activities.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from string import Formatter

from fsm_calib.errors import InputError, ManyErrors, nearest_names
from fsm_calib.statechart.activity import OPERATOR
from fsm_calib.statechart.machinery import Machinery, ancestors, initial_leaf
from fsm_calib.statechart.spec import SEPARATOR, Chart, State, Transition

NAME = re.compile(r"[a-z]+(_[a-z]+)*")
GOOD_ENDS = ("done", "aborted")
"""The ends of every root chart beside its failures."""


def validate(machinery: Machinery) -> list[str]:
    """Return everything that is wrong with the tables of `machinery`, a sentence each; empty when they are sound."""
    states, edges = machinery.states, machinery.transitions
    problems = [
        *_names(machinery.root),
        *_edges(machinery),
        *_levels(states, edges),
        *_values(machinery),
    ]
    return problems or [*_contract(machinery), *_reach(machinery.root, states, edges), *_reasons(machinery)]


@cache
def check(machinery: Machinery) -> None:
    """Refuse a machinery whose tables are not sound.

    Raises
    ------
    ManyErrors
        With everything that is wrong, a sentence each.
    """
    where = f"machine {machinery.root.name}"
    if problems := validate(machinery):
        sentences = (problem.partition(". ") for problem in problems)
        raise ManyErrors(InputError(problem, where=where, cure=cure) for problem, _, cure in sentences)


def _names(chart: Chart) -> Iterator[str]:
    for path, count in Counter(path for path, _ in chart.walk()).items():
        if count > 1:
            yield f"state {path} is declared {count} times"
        if not NAME.fullmatch(path.rsplit(SEPARATOR, 1)[-1]):
            yield f"state {path}: a name is lower-case words joined by _"


def _edges(machinery: Machinery) -> Iterator[str]:
    states, edges = machinery.states, machinery.transitions
    for ident, count in Counter(edge.ident for edge in edges).items():
        if count > 1:
            yield f"transition {ident} is declared {count} times"
    for edge in edges:
        yield from _unknown(edge, "state", [end for end in (edge.source, edge.dest) if end], states)
        yield from _unknown(edge, "guard", edge.guards + edge.unless, machinery.guards)
        yield from _unknown(edge, "action", edge.actions, machinery.actions)
        source = states.get(edge.source)
        if source and not source.inside and not source.do:
            yield f"{edge.ident}: {edge.source} is an end and has no way out"


def _unknown(edge: Transition, kind: str, names: Iterable[str], known: Iterable[str]) -> Iterator[str]:
    for name in names:
        if name not in known:
            yield f"{edge.ident}: no {kind} {name}. {nearest_names(name, known)}"


def _levels(states: Mapping[str, State], edges: tuple[Transition, ...]) -> Iterator[str]:
    """The library asks the leaf first and the states around it next: one trigger at two levels would depend
    on it.
    """
    at = {(edge.source, edge.trigger) for edge in edges}
    for source, trigger in sorted(at):
        for outer in ancestors(source)[1:]:
            if (outer, trigger) in at:
                yield f"trigger {trigger} is declared both at {source} and around it, at {outer}"


def _values(machinery: Machinery) -> Iterator[str]:
    """Books, limits and what else the machinery names fit each other."""
    for kind, made in (("books", machinery.books), ("limits", machinery.limits)):
        if not is_dataclass(made):
            yield f"the {kind} {made.__name__} are no dataclass"
            return
    books = {item.name for item in fields(machinery.books)}
    limits = {item.name for item in fields(machinery.limits)}
    for name in sorted(set(machinery.streaks) - books):
        yield f"the books have no {name} to count in a row. {nearest_names(name, books)}"
    for name in sorted(set(machinery.briefed) - limits):
        yield f"activities are told of the limit {name}, and there is none. {nearest_names(name, limits)}"
    for name in GOOD_ENDS:
        end = machinery.states.get(name)
        if end is None or end.inside or end.do:
            yield f"the root has no end {name}"


def _contract(machinery: Machinery) -> Iterator[str]:
    contract = machinery.contract
    for path, state in machinery.leaves.items():
        if not state.do:
            continue
        if state.do not in contract:
            yield f"state {path}: no activity {state.do}. {nearest_names(state.do, contract)}"
            continue
        declared = set(machinery.declared(path))
        yield from (
            f"state {path}: {trigger} is not declared" for trigger in OPERATOR if trigger not in declared
        )
        declared -= set(OPERATOR)
        promised = set(contract[state.do].triggers)
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


def _reasons(machinery: Machinery) -> Iterator[str]:
    """The numbers in the reason of a failure are books or limits."""
    known = {item.name for made in (machinery.books, machinery.limits) for item in fields(made)}
    for path, state in machinery.leaves.items():
        try:
            named = {part for _, part, _, _ in Formatter().parse(state.reason) if part is not None}
        except ValueError as error:
            yield f"state {path}: the reason cannot be read: {error}"
            continue
        yield from (
            f"state {path}: the reason names {name}. {nearest_names(name, known)}"
            for name in sorted(named - known)
        )


def _closure(start: set[str], ways: Mapping[str, set[str]]) -> set[str]:
    found, fresh = set(start), list(start)
    while fresh:
        fresh_ways = ways[fresh.pop()] - found
        found |= fresh_ways
        fresh.extend(fresh_ways)
    return found
