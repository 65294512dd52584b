"""Every configuration that a machine can reach, and what follows from each: states, books, outcomes.

A configuration is the active leaf with the books (but for `ticks`, which only counts). From each, every
outcome of the leaf's activity is fired with every kind of evidence that a guard can tell apart, and `abort`.
Nothing is stubbed: it is the machine that runs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, fields
from itertools import product
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.statechart.activity import OPERATOR
from fsm_calib.statechart.books import Books
from fsm_calib.statechart.machinery import Machinery, initial_leaf
from fsm_calib.statechart.probe import Probe

Config = tuple[str, tuple[Any, ...]]
"""A leaf and the values of the books."""
Happening = tuple[str, tuple[Any, ...]]
"""A trigger and the values of its evidence."""
UNCOUNTED = ("ticks", "failure")
MOST_CONFIGURATIONS = 40_000
"""A machine with small budgets that has more of them does not end."""


@dataclass
class Explored:
    """The graph of all configurations: where each outcome leads, and which rows of the table were taken."""

    machinery: Machinery
    ways: dict[Config, dict[Happening, Config]] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)

    @property
    def ends(self) -> list[Config]:
        """The configurations in which the run has ended."""
        return [config for config in self.ways if not self.machinery.leaves[config[0]].do]

    def reaching(self, goals: Iterable[Config]) -> set[Config]:
        """Return the configurations from which one of `goals` can be reached."""
        into: dict[Config, list[Config]] = {}
        for config, ways in self.ways.items():
            for dest in ways.values():
                into.setdefault(dest, []).append(config)
        found = set(goals)
        fresh = list(found)
        while fresh:
            for source in into.get(fresh.pop(), ()):
                if source not in found:
                    found.add(source)
                    fresh.append(source)
        return found


class Sampled(dict[str, Any]):
    """Evidence of the check: asking for one that has no samples is refused, because the check would miss a way."""

    def __init__(self, values: Iterable[tuple[str, Any]], unsampled: frozenset[str]) -> None:
        super().__init__(values)
        self._unsampled = unsampled

    def __getitem__(self, key: str) -> Any:
        """Return the value."""
        self._refuse(key)
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:
        """Return the value, or `default`."""
        self._refuse(key)
        return super().get(key, default)

    def _refuse(self, key: str) -> None:
        if key in self._unsampled:
            cure = "Give values on both sides of every threshold in `samples`."
            raise InputError(f"the exhaustive check has no samples of the evidence {key}", cure=cure)


def counted(machinery: Machinery) -> tuple[str, ...]:
    """Return the names of the books that tell configurations apart, in the order of a configuration's values."""
    return tuple(item.name for item in fields(machinery.books) if item.name not in UNCOUNTED)


def outcomes(machinery: Machinery, leaf: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield every outcome that the activity of `leaf` may return, with every kind of evidence.

    Truth values are both; other evidence has its samples. What has none is left out, and asking for it is refused.
    """
    for returned in machinery.contract[machinery.leaves[leaf].do].returns:
        declared = zip(returned.keys, returned.evidence, strict=True)
        choices = {key: _samples(machinery, key, text) for key, text in declared}
        sampled = {key: values for key, values in choices.items() if values}
        unsampled = frozenset(choices) - frozenset(sampled)
        for values in product(*sampled.values()):
            yield returned.trigger, Sampled(zip(sampled, values, strict=True), unsampled)
    yield from ((trigger, {}) for trigger in OPERATOR)


def explore(
    machinery: Machinery, limits: Any, plan: Iterable[str], ceiling: int = MOST_CONFIGURATIONS
) -> Explored:
    """Visit every configuration of `plan`.

    Raises
    ------
    InputError
        There are more than `ceiling`, an outcome is not taken, or a guard or an action cannot do with its evidence.
    """
    probe, graph = Probe(machinery, limits), Explored(machinery)
    start = initial_leaf(machinery.states, machinery.root.states[0].name)
    fresh = [(start, _frozen(machinery, machinery.books.for_plan(plan)))]
    while fresh:
        config = fresh.pop()
        if config in graph.ways:
            continue
        if len(graph.ways) >= ceiling:
            cure = "Give limits with smaller budgets in `small`, and let every way back spend one of them."
            raise InputError(
                f"the machine has more than {ceiling} configurations", where=config[0], cure=cure
            )
        graph.ways[config] = dict(_steps(probe, config, graph.taken))
        fresh.extend(graph.ways[config].values())
    return graph


def _steps(probe: Probe, config: Config, taken: set[str]) -> Iterator[tuple[Happening, Config]]:
    leaf, values = config
    machinery = probe.machinery
    if not machinery.leaves[leaf].do:
        return
    names = counted(machinery)
    for trigger, evidence in outcomes(machinery, leaf):
        probe.put(leaf, dict(zip(names, values, strict=True)))
        if not _fired(probe, leaf, trigger, evidence):
            said = f"{trigger} with {evidence}" if evidence else trigger
            raise InputError(
                f"dead end: {said} is not taken",
                where=f"state {leaf}",
                cure="Declare what follows; `choose` with `otherwise` leaves nothing out.",
            )
        taken.update(probe.model.taken)
        yield (trigger, tuple(evidence.values())), (probe.state, _frozen(machinery, probe.model.books))


def _fired(probe: Probe, leaf: str, trigger: str, evidence: dict[str, Any]) -> bool:
    """Let the machine take an outcome; whether it did."""
    try:
        return probe.fire(trigger, evidence)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        problem = f"on {trigger} a guard or an action fails with {type(error).__name__}: {error}"
        cure = (
            "Read only evidence that the contract declares for the outcome, and books and limits that exist."
        )
        raise InputError(problem, where=f"state {leaf}", cure=cure) from error


def _samples(machinery: Machinery, key: str, evidence: str) -> tuple[Any, ...]:
    """Return values of an evidence, declared as ``key: what it is``, on both sides of every threshold."""
    if key in machinery.samples:
        return machinery.samples[key]
    return (True, False) if evidence.partition(":")[2].strip().startswith("bool") else ()


def _frozen(machinery: Machinery, books: Books) -> tuple[Any, ...]:
    values = books.to_dict()
    return tuple(
        tuple(values[name]) if isinstance(values[name], list) else values[name] for name in counted(machinery)
    )
