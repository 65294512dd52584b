"""Which transitions are enabled, read off the table without a machine and without an order."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from fsm_calib.machines.guards import EXCLUSIVE
from fsm_calib.machines.spec import Chart, Transition


def families(chart: Chart) -> dict[tuple[str, str], list[Transition]]:
    """The transitions by source and trigger."""
    found: dict[tuple[str, str], list[Transition]] = defaultdict(list)
    for edge in chart.all_transitions():
        found[edge.source, edge.trigger].append(edge)
    return dict(found)


def vectors(edges: Sequence[Transition]) -> Iterator[dict[str, bool]]:
    """Every combination of answers of the guards of `edges`; of an exclusive family exactly one says yes."""
    names = sorted({name for edge in edges for name in edge.guards + edge.unless})
    exclusive = [family for family in EXCLUSIVE if set(family) & set(names)]
    free = [name for name in names if not any(name in family for family in exclusive)]
    for answers in product((False, True), repeat=len(free)):
        for chosen in product(*exclusive):
            yes = {name: name in chosen for family in exclusive for name in family}
            yield dict(zip(free, answers, strict=True)) | yes


def enabled(edges: Sequence[Transition], answers: Mapping[str, bool]) -> list[Transition]:
    """The transitions whose condition holds under `answers`."""
    return [
        edge
        for edge in edges
        if all(answers[name] for name in edge.guards) and not any(answers[name] for name in edge.unless)
    ]
