"""Mutants of the declarations: what a slip of the hand could make of each row of the table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from fsm_calib.statechart.spec import Chart, State, Transition

SET = ("begin_", "end_")
"""Actions that set the books to a value: doing them twice is no slip."""


@dataclass(frozen=True)
class Mutant:
    """A table with one slip: what was done to which row, and the rows that come of it."""

    slip: str
    row: Transition
    rows: tuple[Transition, ...]


def mutants(chart: Chart, dests: tuple[str, ...]) -> Iterator[Mutant]:
    """Drop and redirect each row; drop and negate each of its guards; drop and double its actions."""
    for row in chart.all_transitions():
        yield Mutant("drop", row, ())
        for dest in _elsewhere(row, dests):
            yield Mutant(f"redirect to {dest}", row, (replace(row, dest=dest),))
        for name in row.guards:
            rest = tuple(other for other in row.guards if other != name)
            yield Mutant(f"drop guard {name}", row, (replace(row, guards=rest),))
            yield Mutant(
                f"negate guard {name}", row, (replace(row, guards=rest, unless=(*row.unless, name)),)
            )
        for name in row.unless:
            rest = tuple(other for other in row.unless if other != name)
            yield Mutant(f"drop unless {name}", row, (replace(row, unless=rest),))
            yield Mutant(
                f"negate unless {name}", row, (replace(row, unless=rest, guards=(*row.guards, name)),)
            )
        for name in row.actions:
            rest = tuple(other for other in row.actions if other != name)
            yield Mutant(f"drop action {name}", row, (replace(row, actions=rest),))
            if not name.startswith(SET):
                yield Mutant(f"double action {name}", row, (replace(row, actions=(*row.actions, name)),))


def _elsewhere(row: Transition, dests: tuple[str, ...]) -> Iterator[str]:
    """Two other destinations: one of the list of leaves, and an end; a row that stays in its leaf leads there."""
    others = [dest for dest in dests if dest != (row.dest or row.source)]
    near = others[hash_of(row.ident) % len(others)]
    yield near
    if "aborted" not in (row.dest, near):
        yield "aborted"


def hash_of(text: str) -> int:
    """A number that depends on the text alone, the same in every run."""
    return sum((index + 1) * ord(letter) for index, letter in enumerate(text))


def flat(chart: Chart, rows: tuple[Transition, ...]) -> Chart:
    """The same states with `rows` as the only transitions, all declared at the root."""
    return Chart(chart.name, chart.about, tuple(_bare(state) for state in chart.states), rows)


def _bare(state: State) -> State:
    return replace(state, chart=None, children=tuple(_bare(child) for child in state.inside))
