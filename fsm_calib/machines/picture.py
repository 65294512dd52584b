"""What a diagram of a machine shows, before it is written as Mermaid or DOT.

A statechart with every transition as an arrow is unreadable: most arrows only lead to the failures. So a
transition that stays in its leaf, and one that ends the run, is a row inside the leaf's box, as the internal
transitions of UML are; only the ways between states are arrows. Nothing is left out: each declared transition
is a row or a label.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fsm_calib.machines.spec import SEPARATOR, Chart, State, Transition

FAILED = "failed"
EVERY = "every"
"""Name of the box that holds the rows of a composite: they hold in each of its states."""


@dataclass(frozen=True, slots=True)
class Label:
    """One transition as a diagram says it: the trigger, its condition, the bookkeeping, and a failure it ends
    in.
    """

    trigger: str
    condition: str
    actions: str
    end: str = ""

    @property
    def text(self) -> str:
        """The label on one line: ``trigger [guards] / actions`` and, for an end, ``=> failed: name``."""
        parts = [self.trigger]
        parts += [f"[{self.condition}]"] if self.condition else []
        parts += [f"/ {self.actions}"] if self.actions else []
        parts += [f"=> failed: {self.end}"] if self.end else []
        return " ".join(parts)


@dataclass(frozen=True, slots=True)
class Box:
    """A state in a diagram: `path` names it, `rows` stay or end in it, `inside` are the boxes of a composite.

    kind : "leaf" (has an activity), "composite", "end" (a good end), "failure", "every" (the rows of a
    composite), or "outside" (a state of the chart around this one).
    """

    path: str
    title: str
    about: str
    kind: str
    do: str = ""
    rows: tuple[Label, ...] = ()
    inside: tuple[Box, ...] = ()


@dataclass(frozen=True, slots=True)
class Arrow:
    """All transitions from one box to another."""

    source: str
    dest: str
    labels: tuple[Label, ...]


@dataclass(frozen=True, slots=True)
class Picture:
    """A diagram: boxes, arrows between them, and where it begins (the path of a leaf)."""

    name: str
    about: str
    boxes: tuple[Box, ...]
    arrows: tuple[Arrow, ...]
    start: str


def picture(chart: Chart, *, folded: bool = False) -> Picture:
    """Return what a diagram of `chart` shows; `folded` shows machines inside it as single boxes."""
    edges = chart.transitions if folded else tuple(chart.all_transitions())
    boxes = tuple(_boxes(chart.states, "", edges, folded))
    outside = {edge.dest for edge in edges if edge.dest and edge.dest.startswith(SEPARATOR)}
    boxes += tuple(_outside(path) for path in sorted(outside) if not _is_failure(path))
    return Picture(chart.name, chart.about, boxes, _arrows(edges), _start(chart, folded))


def _boxes(
    states: tuple[State, ...], prefix: str, edges: tuple[Transition, ...], folded: bool
) -> Iterator[Box]:
    for state in states:
        path = prefix + state.name
        inner = () if folded and state.chart else state.inside
        inside = tuple(_boxes(inner, path + SEPARATOR, edges, folded))
        rows = tuple(_label(edge) for edge in edges if edge.source == path and _is_row(edge))
        if inside and rows:
            inside += (Box(f"{path}/{EVERY}", "in every state here", "", "every", rows=rows),)
            rows = ()
        yield Box(path, state.name, state.about, _kind(state, folded), state.do, rows, inside)


def _kind(state: State, folded: bool) -> str:
    if state.reason:
        return "failure"
    if state.inside and not (folded and state.chart):
        return "composite"
    return "leaf" if state.do or state.chart else "end"


def _outside(path: str) -> Box:
    name = path.removeprefix(SEPARATOR)
    return Box(path, name, "the supervisor goes on", "outside")


def _is_failure(path: str | None) -> bool:
    return path is not None and path.removeprefix(SEPARATOR).startswith(FAILED + SEPARATOR)


def _is_row(edge: Transition) -> bool:
    return edge.dest is None or edge.dest == edge.source or _is_failure(edge.dest)


def _label(edge: Transition) -> Label:
    end = edge.dest.rsplit(SEPARATOR, 1)[-1] if edge.dest and _is_failure(edge.dest) else ""
    return Label(edge.trigger, edge.condition, ", ".join(edge.actions), end)


def _arrows(edges: tuple[Transition, ...]) -> tuple[Arrow, ...]:
    ways: dict[tuple[str, str], list[Label]] = {}
    for edge in edges:
        if edge.dest is not None and not _is_row(edge):
            ways.setdefault((edge.source, edge.dest), []).append(_label(edge))
    return tuple(Arrow(source, dest, tuple(labels)) for (source, dest), labels in ways.items())


def _start(chart: Chart, folded: bool) -> str:
    state, path = chart.states[0], chart.states[0].name
    while state.inside and not (folded and state.chart):
        state = state.inside[0]
        path += SEPARATOR + state.name
    return path
