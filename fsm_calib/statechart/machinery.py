"""A machine as a value: its chart with everything that the chart names."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fsm_calib.statechart.activity import Activity
from fsm_calib.statechart.books import Books
from fsm_calib.statechart.spec import SEPARATOR, Chart, State, Transition

Evidence = Mapping[str, Any]
"""The numbers of one outcome, by name."""
Guard = Callable[[Any, Any, Evidence], bool]
"""``(books, limits, evidence)`` to an answer; without side effects."""
Action = Callable[[Any, Any, Evidence], None]
"""``(books, limits, evidence)``; changes only the books and cannot fail."""


@dataclass(frozen=True, slots=True)
class NoLimits:
    """The limits of a machine that has none."""


@dataclass(frozen=True, slots=True)
class Small:
    """What the exhaustive check visits at a time: limits with small budgets, and the phases (all when None)."""

    limits: Any
    plan: tuple[str, ...] | None = None


@dataclass(frozen=True, eq=False)
class Machinery:
    """A machine with all that it needs to be run, checked, drawn and described.

    Parameters
    ----------
    root : Chart
        The outermost chart. Its states that hold a chart are the phases. A run ends in its states `done` and
        `aborted`, and in the states under `failed`; every leaf with an activity takes the operator's `abort`.
    guards, actions : mapping of str to callable
        What the transitions name; each takes (books, limits, evidence).
    contract : mapping of str to Activity
        The do-activities that the leaves name, with the outcomes that each may return.
    books, limits : type
        Dataclasses: what is counted, and what the guards compare it with.
    does : mapping of str to callable
        Functions that carry out activities, in place of, or beside, those of whoever runs the machine.
    exclusive : tuple of tuple of str
        Families of guards of which exactly one holds at any time, whatever the books.
    streaks : mapping of str to str
        Books that count events in a row: by book the action that counts; any other event sets it to zero.
    briefed : tuple of str
        Limits that activities are told of, beside the books.
    published : mapping of str to mapping
        Named sets of limits, by name, that a scenario can switch on.
    samples : mapping of str to tuple
        For the exhaustive check: values of each evidence on both sides of every threshold of `small`; truth values
        need none.
    small : tuple of Small
        For the exhaustive check: limits so small that every configuration can be visited.
    shared : tuple of str
        Parts that several machines share: closed boxes in the pictures of those.
    home, limits_home : str
        Where the tables and the limits are declared, for the page that describes them.
    drawn : Path or None
        A folder with pictures that are already drawn, for places without Graphviz.
    """

    root: Chart
    guards: Mapping[str, Guard]
    actions: Mapping[str, Action]
    contract: Mapping[str, Activity]
    books: type[Books] = Books
    limits: type[Any] = NoLimits
    does: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    exclusive: tuple[tuple[str, ...], ...] = ()
    streaks: Mapping[str, str] = field(default_factory=dict)
    briefed: tuple[str, ...] = ()
    published: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    samples: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    small: tuple[Small, ...] = ()
    shared: tuple[str, ...] = ()
    home: str = ""
    limits_home: str = ""
    drawn: Path | None = None

    @property
    def machines(self) -> tuple[Chart, ...]:
        """The charts inside the root's states, in order."""
        return tuple(state.chart for state in self.root.states if state.chart)

    @property
    def phases(self) -> tuple[str, ...]:
        """The names of the root's states that hold a chart, in order."""
        return tuple(state.name for state in self.root.states if state.chart)

    @cached_property
    def states(self) -> dict[str, State]:
        """Every state of the whole machine by its path."""
        return dict(self.root.walk())

    @cached_property
    def leaves(self) -> dict[str, State]:
        """Every leaf of the whole machine by its path."""
        return {path: state for path, state in self.states.items() if not state.inside}

    @cached_property
    def transitions(self) -> tuple[Transition, ...]:
        """Every transition of the whole machine."""
        return tuple(self.root.all_transitions())

    @cached_property
    def digest(self) -> str:
        """A text that another table has not: SHA-256 of its name, its states with what is done, and its rows."""
        rows = [f"{path} {state.do}" for path, state in self.states.items()]
        rows += [f"{edge.ident} / {', '.join(edge.actions)}" for edge in self.transitions]
        return hashlib.sha256("\n".join([self.root.name, *rows]).encode()).hexdigest()

    def declared(self, state: str) -> tuple[str, ...]:
        """Return the outcomes declared for the leaf `state`, those of the states around it included, sorted."""
        if state not in self._declared:
            around = set(ancestors(state))
            taken = {edge.trigger for edge in self.transitions if edge.source in around}
            self._declared[state] = tuple(sorted(taken))
        return self._declared[state]

    @cached_property
    def _declared(self) -> dict[str, tuple[str, ...]]:
        return {}


def ancestors(path: str) -> tuple[str, ...]:
    """Return `path` and the paths of the states around it, innermost first."""
    parts = path.split(SEPARATOR)
    return tuple(SEPARATOR.join(parts[:n]) for n in range(len(parts), 0, -1))


def initial_leaf(states: Mapping[str, State], path: str) -> str:
    """Return the leaf that is entered when `path` is entered."""
    while states[path].inside:
        path += SEPARATOR + states[path].inside[0].name
    return path
