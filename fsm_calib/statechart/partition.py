"""Which transitions are enabled, read off the table without a machine and without an order."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.spec import Transition


def families(edges: Sequence[Transition]) -> dict[tuple[str, str], list[Transition]]:
    """Return the transitions by source and trigger."""
    found: dict[tuple[str, str], list[Transition]] = defaultdict(list)
    for edge in edges:
        found[edge.source, edge.trigger].append(edge)
    return dict(found)


def vectors(
    edges: Sequence[Transition], exclusive: Sequence[tuple[str, ...]] = ()
) -> Iterator[dict[str, bool]]:
    """Yield every combination of answers of the guards of `edges`; of an exclusive family exactly one says yes."""
    names = sorted({name for edge in edges for name in edge.guards + edge.unless})
    bound = [family for family in exclusive if set(family) & set(names)]
    free = [name for name in names if not any(name in family for family in bound)]
    for answers in product((False, True), repeat=len(free)):
        for chosen in product(*bound):
            yes = {name: name in chosen for family in bound for name in family}
            yield dict(zip(free, answers, strict=True)) | yes


def enabled(edges: Sequence[Transition], answers: Mapping[str, bool]) -> list[Transition]:
    """Return the transitions whose condition holds under `answers`."""
    return [
        edge
        for edge in edges
        if all(answers[name] for name in edge.guards) and not any(answers[name] for name in edge.unless)
    ]


def undecided(machinery: Machinery) -> Iterator[str]:
    """Yield a sentence for each state and trigger whose guards leave none, or more than one, transition enabled."""
    for (source, trigger), edges in families(machinery.transitions).items():
        for answers in vectors(edges, machinery.exclusive):
            count = len(enabled(edges, answers))
            if count != 1:
                said = " & ".join(name if yes else f"!{name}" for name, yes in answers.items()) or "no guard"
                yield f"state {source}: on {trigger}, {count} transitions are enabled when {said}"
                break
