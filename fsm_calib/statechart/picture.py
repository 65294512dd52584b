"""What a diagram of a machine shows, before it is written as Mermaid or DOT.

A statechart with every transition as an arrow is unreadable: most arrows only lead to the failures. So a
transition that stays in its leaf, and one that ends the run, is a row inside the leaf's box, as the internal
transitions of UML are; only the ways between states are arrows. Nothing is left out: each declared transition
is a row or a label.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from fsm_calib.statechart.spec import SEPARATOR, Chart, State, Transition

FAILED, ABORTED = "failed", "aborted"
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
        """The label on one line: ``trigger [guards] / actions`` and, for an end, ``⇒ name``."""
        parts = [self.trigger] if self.trigger else []
        parts += [f"[{self.condition}]"] if self.condition else []
        parts += [f"/ {self.actions}"] if self.actions else []
        parts += [f"⇒ {self.end}"] if self.end else []
        return " ".join(parts)


@dataclass(frozen=True, slots=True)
class Box:
    """A state in a diagram: `path` names it, `rows` stay or end in it, `inside` are the boxes of a composite.

    kind : "leaf" (has an activity), "composite", "closed" (a composite seen from outside), "end" (a good
    end), "failure", "every" (the rows of a composite), "outside" (a state of the chart around this one, or
    the abort).
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


def picture(chart: Chart, *, closed: tuple[str, ...] = ()) -> Picture:
    """Return what a diagram of `chart` shows; the states in `closed` are single boxes, seen from outside."""
    edges = tuple(_seen_from_outside(edge, closed) for edge in chart.all_transitions())
    boxes = tuple(_boxes(chart.states, "", edges, closed))
    outside = {edge.dest for edge in edges if edge.dest and edge.dest.startswith(SEPARATOR)}
    boxes += tuple(_outside(path) for path in sorted(outside) if not _ends(path))
    return Picture(chart.name, chart.about, boxes, _arrows(edges), _start(chart, closed))


def _seen_from_outside(edge: Transition, closed: tuple[str, ...]) -> Transition:
    """Return `edge` as it looks when `closed` are closed: inner states, guards and books are not seen."""
    source, dest = edge.source.split(SEPARATOR)[0], edge.dest and edge.dest.split(SEPARATOR)[0]
    dest = dest if dest in closed else edge.dest
    if source not in closed:
        return replace(edge, dest=dest)
    return Transition(edge.trigger, source, source if dest in (None, source) else dest)


def _boxes(
    states: tuple[State, ...], prefix: str, edges: tuple[Transition, ...], closed: tuple[str, ...]
) -> Iterator[Box]:
    for state in states:
        path = prefix + state.name
        if state.name == FAILED:
            yield _failures(path, state)
            continue
        shut = path in closed
        inside = () if shut else tuple(_boxes(state.inside, path + SEPARATOR, edges, closed))
        rows = _summary(path, edges) if shut else _rows(path, edges)
        if inside and rows:
            inside += (Box(f"{path}/{EVERY}", "in every state here", "", "every", rows=rows),)
            rows = ()
        yield Box(path, state.name, state.about, _kind(state, shut), state.do, rows, inside)


def _rows(path: str, edges: tuple[Transition, ...]) -> tuple[Label, ...]:
    return tuple(_label(edge) for edge in edges if edge.source == path and _is_row(edge))


def _summary(path: str, edges: tuple[Transition, ...]) -> tuple[Label, ...]:
    """Return one row for each end that the closed machine at `path` can come to."""
    found = (_end(edge.dest) for edge in edges if edge.source == path and edge.dest and _ends(edge.dest))
    return tuple(Label("", "", "", end) for end in sorted(set(found)))


def _failures(path: str, state: State) -> Box:
    rows = tuple(Label(child.name, "", "", child.about) for child in state.children)
    return Box(path, state.name, state.about, "failure", rows=rows)


def _kind(state: State, shut: bool) -> str:
    if state.inside:
        return "closed" if shut else "composite"
    if state.name == ABORTED:
        return "outside"
    return "leaf" if state.do else "end"


def _outside(path: str) -> Box:
    return Box(path, path.removeprefix(SEPARATOR), "the supervisor goes on", "outside")


def _ends(path: str | None) -> bool:
    """Whether the run ends unfinished at `path`: in a named failure or aborted."""
    first = (path or "").removeprefix(SEPARATOR).split(SEPARATOR)[0]
    return first in (FAILED, ABORTED)


def _end(path: str) -> str:
    return path.rsplit(SEPARATOR, 1)[-1]


def _is_row(edge: Transition) -> bool:
    return edge.dest is None or edge.dest == edge.source or _ends(edge.dest)


def _label(edge: Transition) -> Label:
    end = _end(edge.dest) if edge.dest and _ends(edge.dest) else ""
    return Label(edge.trigger, edge.condition, ", ".join(edge.actions), end)


def _arrows(edges: tuple[Transition, ...]) -> tuple[Arrow, ...]:
    ways: dict[tuple[str, str], list[Label]] = {}
    for edge in edges:
        if edge.dest is not None and not _is_row(edge):
            labels = ways.setdefault((edge.source, edge.dest), [])
            labels += [_label(edge)] if _label(edge) not in labels else []
    return tuple(Arrow(source, dest, tuple(labels)) for (source, dest), labels in ways.items())


def _start(chart: Chart, closed: tuple[str, ...]) -> str:
    state, path = chart.states[0], chart.states[0].name
    while state.inside and path not in closed:
        state = state.inside[0]
        path += SEPARATOR + state.name
    return path
