"""Every configuration that the real machine can reach, and what follows from each: states, books, outcomes.

A configuration is the active leaf with the books (but for `ticks`, which only counts). From each, every
outcome of the leaf's activity is fired with every kind of evidence that a guard can tell apart, and `abort`.
Nothing is stubbed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from machine_rig import Rig

from fsm_calib.machines.activities import CONTRACT
from fsm_calib.machines.books import Books
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.runtime import leaves

Config = tuple[str, tuple[Any, ...]]
NAMES = tuple(name for name in Books().to_dict() if name not in ("ticks", "failure"))
SAMPLES: dict[str, tuple[Any, ...]] = {
    "sharp": (True, False),
    "quiet": (True, False),
    "precise": (True, False),
    "fresh_views": (0, 9),
    "turned": (0.0, 4.0),
    "heading": (0.0, -0.1, 0.1, -1.0, 1.0),
}
"""Evidence on both sides of every threshold of `small_limits`."""


def small_limits(
    boards: int, *, late: bool = False, passes: int = 1, budget: int = 2, misses: int = 2
) -> Limits:
    """Budgets so small that every configuration can be visited, thresholds between the samples."""
    return Limits(
        boards=boards, start_board=boards // 2, passes=passes, misses_before_lost=misses,
        late_bound_check=late, views_per_board=budget, views_per_judgement=1, precise_judgements=2,
        search_steps=budget, search_angle=3.0, standpoints=2,
        focus_looks=budget, seeking_steps=budget, seeking_angle=3.0, turns=budget, overshoots=1, recoveries=2,
        frame_retries=1, aligned_within=0.05, roughly_aligned_within=0.2, square_within=0.5,
        quiet_iterations=min(budget, 3), iterations=budget + 1, leaving_steps=budget, following_steps=budget,
        markers=budget,
    )  # fmt: skip


def outcomes(leaf: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every outcome that the activity of `leaf` may return, with every kind of evidence."""
    for returned in CONTRACT[leaves()[leaf].do].returns:
        for values in product(*(SAMPLES[key] for key in returned.keys)):
            yield returned.trigger, dict(zip(returned.keys, values, strict=True))
    yield "abort", {}


@dataclass
class Explored:
    """The graph of all configurations: where each outcome leads, and which rows of the table were taken."""

    ways: dict[Config, dict[tuple[str, tuple[Any, ...]], Config]] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)

    @property
    def ends(self) -> list[Config]:
        """The configurations in which the run has ended."""
        return [config for config in self.ways if not leaves()[config[0]].do]


def explore(limits: Limits, plan: list[str], ceiling: int = 40_000) -> Explored:
    """Visit every configuration of `plan`; more than `ceiling` means that a budget does not end."""
    rig, graph = Rig(limits), Explored()
    start = ("between", _frozen(Books.for_plan(plan)))
    fresh = [start]
    while fresh:
        config = fresh.pop()
        if config in graph.ways:
            continue
        assert len(graph.ways) < ceiling, "the machine does not end"
        graph.ways[config] = dict(_steps(rig, config, graph.taken))
        fresh.extend(graph.ways[config].values())
    return graph


def _steps(rig: Rig, config: Config, taken: set[str]) -> Iterator[tuple[tuple[str, tuple[Any, ...]], Config]]:
    leaf, values = config
    if not leaves()[leaf].do:
        return
    for trigger, evidence in outcomes(leaf):
        rig.put(leaf, dict(zip(NAMES, values, strict=True)))
        assert rig.fire(trigger, evidence), f"dead end: {leaf} does not take {trigger} with {evidence}"
        assert len(rig.model.taken) == 1
        taken.update(rig.model.taken)
        yield (trigger, tuple(evidence.values())), (rig.state, _frozen(rig.model.books))


def _frozen(books: Books) -> tuple[Any, ...]:
    values = books.to_dict()
    return tuple(tuple(values[name]) if name == "plan" else values[name] for name in NAMES)
