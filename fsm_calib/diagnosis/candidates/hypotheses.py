"""The hypotheses: each effect of the catalogue in each of its forms, with the places where a fit should start.

Everything comes from what the effects declare (`world2d.effects`): variants, start values, which parameters belong
to one recording.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.world2d.effects import Closure, Effect, registry
from fsm_calib.world2d.effects.numbered import is_later
from fsm_calib.world2d.scale import SMALL, Scale

MOST_STARTS = 24


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One closure of one effect: the parameters it frees; `run` for an event of one recording, else -1.

    chance : with which probability a moment stands out so far where nothing happened; 0 where none was sought.
    closure : its name among the effect's; empty where only the parameters are known, and nothing else is held.
    """

    effect: str
    names: tuple[str, ...]
    run: int = ALL_RUNS
    chance: float = 0.0
    closure: str = ""

    @property
    def held(self) -> dict[str, float]:
        """Values at which the closure holds choices, by full name."""
        fixes = registry()[self.effect].closure(self.closure).fixes if self.closure else {}
        return {f"{self.effect}.{name}": value for name, value in fixes.items()}

    @property
    def full_names(self) -> tuple[str, ...]:
        """Names in the parameter table."""
        return tuple(f"{self.effect}.{name}" for name in self.names)


def catalogue(without: Iterable[str] = (), base_lacks: Iterable[str] = ()) -> list[Effect]:
    """Return the candidate effects: the registry without those named, and without those that the base robot has."""
    left_out, lacks = set(without), set(base_lacks)
    return [
        e for e in registry().values() if e.name not in left_out and (e.family != "base" or e.name in lacks)
    ]


def shown_by(effects: Iterable[Effect], simulators: Sequence[Simulator]) -> list[Effect]:
    """Return the effects that these recordings can show, by their kind of input (commands, twists, wheels) and poses.

    Headings without positions show what turns the robot, and no place on the floor.
    """
    allowed, twists = {"any"}, all(_by_twists(s) for s in simulators)
    if not any(s.measured_input for s in simulators):
        allowed.add("command")
    if twists:
        allowed.add("twist")
    if twists or all(s.measured_input or s.prepared.has_encoders for s in simulators):
        allowed.add("wheels")
    placed = any(s.prepared.poses.placed for s in simulators)
    return [
        e
        for e in effects
        if e.input in allowed and (placed or ("turn" in e.channels and e.where == "anywhere"))
    ]


def _by_twists(simulator: Simulator) -> bool:
    recording = simulator.prepared.recording
    return recording.twist is not None and recording.command is None


def is_event(effect: Effect) -> bool:
    """Return whether the effect happens once, in one recording."""
    return effect.scan == "time"


def has_phase(effect: Effect) -> bool:
    """Return whether a lasting effect has a number of its own in every recording: where in a turn a wheel begins."""
    return not is_event(effect) and any(p.fitted and p.per_recording for p in effect.parameters)


def hypotheses_of(effect: Effect, runs: int) -> Iterator[Hypothesis]:
    """Yield every closure of an effect that competes for its name; an event once for each recording."""
    for closure in effect.competing:
        for run in range(runs) if is_event(effect) else (ALL_RUNS,):
            yield Hypothesis(effect.name, closure.frees, run, closure=closure.name)


def slots_of(hypothesis: Hypothesis, runs: int, scale: Scale = SMALL) -> tuple[Slot, ...]:
    """Return the free numbers: shared ones once, those that belong to a recording once for each; bounds by `scale`."""
    effect = registry()[hypothesis.effect]
    alike = effect.closure(hypothesis.closure).alike if hypothesis.closure else ()
    slots: list[Slot] = []
    for name, full in zip(hypothesis.names, hypothesis.full_names, strict=True):
        if hypothesis.run != ALL_RUNS:
            slots.append(slot_of(full, hypothesis.run, scale))
        elif effect.parameter(name).per_recording and name not in alike:
            slots += [slot_of(full, run, scale) for run in range(runs)]
        else:
            slots.append(slot_of(full, scale=scale))
    return tuple(slots)


def declared_starts(
    hypothesis: Hypothesis, given: Mapping[str, float] | None = None
) -> list[dict[str, float]]:
    """Return combinations of the declared start values of a hypothesis' parameters, at most `MOST_STARTS`.

    `given` : values that are known already. Choices (not fitted, but with starts) are part of the combinations, those
    that the closure holds at their value.
    """
    effect = registry()[hypothesis.effect]
    given = {**(given or {}), **hypothesis.held}
    held = [full.split(".")[1] for full in hypothesis.held]
    choices = list(dict.fromkeys([*(p.name for p in effect.choices), *held]))
    lists = []
    for name in (*hypothesis.names, *choices):
        p = effect.parameter(name)
        if f"{effect.name}.{name}" in given:
            lists.append([(f"{effect.name}.{name}", given[f"{effect.name}.{name}"])])
            continue
        fallback = (p.typical,) if p.strength and _only_strength(effect, hypothesis, name) else (p.null,)
        lists.append([(f"{effect.name}.{name}", value) for value in (p.starts or fallback)])
    return [dict(choice) for choice in product(*lists)][:MOST_STARTS]


def single_steps(hypothesis: Hypothesis, choices: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
    """Return a step of its derivative for each strength that no start moves, alone.

    A start moves the first strength: a floor that falls along x says nothing of one that falls along y.
    """
    effect = registry()[hypothesis.effect]
    strengths = [
        (f, effect.parameter(n)) for n, f in zip(hypothesis.names, hypothesis.full_names, strict=True)
    ]
    unmoved = [(f, p) for f, p in strengths if p.strength and all(choice[f] == p.null for choice in choices)]
    return [{**hypothesis.held, full: p.null + slot_of(full).step} for full, p in unmoved]


def starts_move_all(hypothesis: Hypothesis) -> bool:
    """Return whether the starts of a form move all its numbers but strengths, which single steps move.

    What starts promise says nothing of a spring whose end none of them moves.
    """
    parameters = map(registry()[hypothesis.effect].parameter, hypothesis.names)
    return all(p.strength or p.starts for p in parameters)


def asked_for(effect: Effect, given: set[str]) -> list[Closure]:
    """Return the closures of an event of one recording whose times a scan gives (a begin, or a length, too); of a place
    those that extend the others where only they have all that it tells.
    """
    if effect.scan != "time":
        told = {n for n in given if effect.parameter(n).fitted}
        larger = [c for c in effect.extending if told <= set(c.frees)]
        return list(effect.competing) if not larger or told <= _freed(effect) else larger
    times = {p.name for p in effect.parameters if not p.strength}
    differ = [len((set(closure.frees) ^ given) & times) for closure in effect.competing]
    return [c for c, number in zip(effect.competing, differ, strict=True) if number == min(differ)]


def _freed(effect: Effect) -> set[str]:
    """Return all numbers that the competing closures of an effect free."""
    return {name for closure in effect.competing for name in closure.frees}


def alike_in(effect: Effect, closure: str) -> set[str]:
    """Return the closures of an event that are of one kind with `closure`, in however many times: the same motor's."""

    def strengths(closure: Closure) -> set[str]:
        return {n for n in closure.frees if effect.parameter(n).strength and not is_later(n)}

    own = strengths(effect.closure(closure))
    return {c.name for c in effect.closures if strengths(c) == own and not c.alike}


def _only_strength(effect: Effect, hypothesis: Hypothesis, name: str) -> bool:
    """Return whether `name` is the first strength of the hypothesis: it must not start at its null value."""
    strengths = [n for n in hypothesis.names if effect.parameter(n).strength]
    declared = [
        n for n in strengths if any(x != effect.parameter(n).null for x in effect.parameter(n).starts)
    ]
    return not declared and strengths[:1] == [name]


def scaled(effect: Effect, changes: Mapping[str, float], scale: float) -> dict[str, float]:
    """Return the changes with the strengths' distance from null scaled, inside their bounds."""
    result = dict(changes)
    for full, value in changes.items():
        p = effect.parameter(full.split(".")[1])
        if p.strength:
            result[full] = float(np.clip(p.null + scale * (value - p.null), p.low, p.high))
    return result
