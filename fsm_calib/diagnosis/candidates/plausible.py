"""Is a fitted effect what its name says? A place is left again, a size is one that occurs, an event was seen.

Without the first an area that grows over the whole floor stands in for what acts everywhere (a rough floor for dry
friction, a turned marker for a turned sensor), with as good a likelihood as theirs. Without the second a warming
motor that is to lose more than half of its strength stands in for a battery that sags, as a slow exponential is a
straight line. A motor that fails a little for half a second stands in for a push; and where no poses were taken, or in
the last moments of a recording, what wandered while nobody looked stands in for one.

What is not plausible speaks against a form, not against its effect: of an effect's forms those that are plausible come
first. Drives of a robot whose motors' current is limited were fitted best by a supply that ends at 1.1 of full command,
which is no finding; the current's limit (1,031 units) was lost with it, and a driver's ramps were said (0.94).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.outstanding import RARE
from fsm_calib.diagnosis.candidates.ranked import Ranked, parameters_of
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.numbered import times_in
from fsm_calib.world2d.effects.parameter import Parameter
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive

AT_BOUND = 1e-4  # of the range between the bounds: nearer, a number rests there
SHORTEST_SPAN = 2.0  # s: within it a robot is pushed and brought back by its motors
OFTEN = 3  # times that something comes again
MOST_OF_IT = 0.5  # of a motor's strength: a driver that starts anew, a plug that opens
LONGEST_BLINK = 0.5  # s between poses: a push and what the motors make of it take no longer
LEAST_INSIDE = 0.5  # s of driving: a few outliers in a row are no place
SECOND_STAY = 0.2  # s: a few poses
MOST_IN_EDGE = 0.05  # of the driven time: commands of every size have 0.01 of 0.5 there
MOST_INSIDE = 0.7  # of the driving time; by the same token a place needs a third of the drive to compare with


def plausible_of(forms: Sequence[Ranked], simulators: Sequence[Simulator]) -> Sequence[Ranked]:
    """Return the forms of an effect that are what its name says; all where none is."""
    return [ranked for ranked in forms if is_plausible(ranked, simulators)] or forms


def is_plausible(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether an effect has a size and, if it is one, a place that its name stands for."""
    return (
        has_size(ranked)
        and passes_whole(ranked, simulators)
        and lasts(ranked, simulators)
        and is_seen(ranked, simulators)
        and is_crossed(ranked, simulators)
    )


def is_finding(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether an effect of a model may be said: it is what its name says, and no robot is built so."""
    return is_plausible(ranked, simulators) and not is_as_built(ranked)


def has_size(ranked: Ranked) -> bool:
    """Return whether a strength is large enough to be told, and none rests at a bound short of where nature ends.

    Nor may a number that is another effect at its low bound, though it is no strength.
    """
    table, effect = parameter_table(), registry()[ranked.name]
    told = []
    for name in ranked.hypothesis.names:
        p = effect.parameter(name)
        if not (p.strength or p.floor):
            continue
        place = table.place(f"{ranked.name}.{name}")
        values = ranked.fit.values[:, place]
        low, high = _bounds(ranked, p)
        upper = [high] if p.strength and not p.natural_end else []
        ends = [end for end in (low, *upper) if end != p.null]
        if p.strength:
            told.append(not np.any(np.abs(values - p.null) < p.least))
        if any(np.any(np.abs(values - end) < AT_BOUND * (high - low)) for end in ends):
            return False
    return any(told) or not told


def _bounds(ranked: Ranked, parameter: Parameter) -> tuple[float, float]:
    """Return the bounds of an effect's number in its fit, the declared ones where it is not free there."""
    place = parameter_table().place(f"{ranked.name}.{parameter.name}")
    free = ((slot.low, slot.high) for slot in ranked.fit.slots if slot.place == place)
    return next(free, (parameter.low, parameter.high))


def is_as_built(ranked: Ranked) -> bool:
    """Return whether all strengths that an effect frees are as robots are built (`Parameter.as_built`), and what else
    it frees is at its least.

    A robot whose motors are 1.1 times as strong in reverse has a supply that ends at 1.02 of full command: any bridge
    ends where its pulses fill the time, behind the least gain of a loop. Behind one that has a gain it starves it.
    """
    effect, values = registry()[ranked.name], parameters_of(ranked)
    freed = [effect.parameter(name) for name in ranked.hypothesis.names]
    strengths = [p for p in freed if p.strength]
    for p in freed:
        low, high = _bounds(ranked, p)
        if not p.strength and np.any(np.abs(values[p.name] - low) >= AT_BOUND * (high - low)):
            return False
    return bool(strengths) and all(
        bool(np.all((values[p.name] - p.as_built) * (p.null - p.as_built) >= 0.0)) for p in strengths
    )


def passes_whole(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether hardly any command passes in part, by an edge that is there for the fit's sake (`Parameter.edge`).

    A robot that lost 0.2 of every command was driven at 0.17, 0.255 and 0.34. A threshold of 0.2547 lets half of 0.255
    through by its edge of 0.01, and so fitted as well as what was true.
    """
    edged = [p for p in map(registry()[ranked.name].parameter, ranked.hypothesis.names) if p.edge > 0.0]
    return all(_passes(number, ranked, simulators) for number in edged)


def _passes(number: Parameter, ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether a number's edge holds hardly any command of any recording."""
    values = ranked.fit.values[:, parameter_table().place(f"{ranked.name}.{number.name}")]
    return all(
        _share_in_part(s.drive, number.name, float(value), number.edge) <= MOST_IN_EDGE
        for s, value in zip(simulators, values, strict=True)
    )


def _share_in_part(drive: Drive, name: str, value: float, width: float) -> float:
    """Return the share of the driven time with commands that pass in part, of the wheels that a number is about.

    A command u passes by the part g = (|u| - value) / width + 1/2, 0 to 1, and counts by 4 g (1 - g): a level that the
    edge just leaves aside counts little, since nothing leads a fit farther.
    """
    sizes = np.abs(np.column_stack([drive.left, drive.right]))[:-1]
    if side := [i for i, wheel in enumerate(("left", "right")) if name.endswith(wheel)]:
        sizes = sizes[:, side]
    held = np.diff(drive.time)[:, None] * (sizes > 0.0)
    part = np.clip((sizes - value) / width + 0.5, 0.0, 1.0)
    return float(np.sum(held * 4.0 * part * (1.0 - part)) / max(np.sum(held), 1e-9))


def lasts(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether a span of time is longer than a push, and the drive as much longer; True for other effects.

    What lasts from begin to end of a recording is another robot there, nothing that came or went. Short ones are more
    than pushes where they come again by the same loss, `OFTEN` times or in all as long, or where the motor loses
    `MOST_OF_IT`: a plug opens, a driver starts anew. Faults fitted to 14 pushes of foreign robots changed 0.08 at most.
    """
    return registry()[ranked.name].when != "span" or all(
        _lasts_in(ranked, simulators, run) for run in _runs(ranked, simulators)
    )


def _runs(ranked: Ranked, simulators: Sequence[Simulator]) -> Sequence[int]:
    """Return the recordings that an event is told by: one, or all where it comes alike in each."""
    run = ranked.hypothesis.run
    return range(len(simulators)) if run == ALL_RUNS else (run,)


def _lasts_in(ranked: Ranked, simulators: Sequence[Simulator], run: int) -> bool:
    """Return whether a span `lasts` in one recording."""
    effect, table = registry()[ranked.name], parameter_table()
    values = dict(zip(table.names, ranked.fit.values[run].tolist(), strict=True))
    names = [[f"{ranked.name}.{n}" for n in time] for time in times_in(ranked.hypothesis.names)]
    spans = [(values[start], values[length]) for start, length in names]
    p = simulators[run].prepared
    inside = np.any([(p.time >= begin) & (p.time <= begin + length) for begin, length in spans], axis=0)
    lost = [values[f"{ranked.name}.{n}"] for n in ranked.hypothesis.names if effect.parameter(n).strength]
    long = sum(length for _, length in spans) >= SHORTEST_SPAN or len(spans) >= OFTEN
    beside = float(np.sum((p.dt * p.moving)[~inside]))
    return (long or max(lost, default=0.0) >= MOST_OF_IT) and beside >= SHORTEST_SPAN


def is_seen(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether poses were taken while momentary events began, and for a while after; True for other effects.

    What came alike in every recording needs to be seen in one: hands hide markers.
    """
    if registry()[ranked.name].when != "moment":
        return True
    starts = [parameter_table().place(f"{ranked.name}.{n}") for n, _ in times_in(ranked.hypothesis.names)]
    watched = (
        all(
            _is_watched(simulators[run].prepared.poses.time, float(ranked.fit.values[run, place]))
            for place in starts
        )
        for run in _runs(ranked, simulators)
    )
    return any(watched)


def _is_watched(time: FloatArray, moment: float) -> bool:
    """Return whether poses at the times (n,) [s] were taken at a moment [s] and for a while after."""
    after = int(np.searchsorted(time, moment))
    if after == 0 or moment > time[-1] - SHORTEST_SPAN:
        return False
    return float(time[after] - time[after - 1]) <= LONGEST_BLINK


def is_crossed(ranked: Ranked, simulators: Sequence[Simulator]) -> bool:
    """Return whether the robot drove on the place for a while, and beside it as well; True for other effects.

    One short stay is a moment as much as a place: it takes a second one, or a stay that is longer than a push. Where
    poses jump at its edge a place may be most of the floor: what acts everywhere has no edge.
    """
    effect = registry()[ranked.name]
    if effect.scan != "place":
        return True
    stays, total = [0.0], 0.0
    for simulator, values in zip(simulators, ranked.fit.values, strict=True):
        p = simulator.prepared
        driven = p.dt * p.moving
        total += float(np.sum(driven))
        stays += stays_in(in_place(ranked.name, values, p.reference), driven)
    inside, longest = sum(stays), max(stays)
    again = longest >= SHORTEST_SPAN or inside - longest >= SECOND_STAY
    most = total - SHORTEST_SPAN if effect.jumps else MOST_INSIDE * total
    return again and LEAST_INSIDE <= inside <= most


def stays_in(inside: np.ndarray, driven: FloatArray) -> list[float]:
    """Return how long [s] each stay lasted; inside : (n,) bool, driven : (n,) time driven up to each event [s]."""
    entered = inside & ~np.concatenate([[False], inside[:-1]])
    return [float(t) for t in np.bincount(np.cumsum(entered)[inside], driven[inside])[1:]]


def in_place(name: str, values: FloatArray, path: FloatArray) -> np.ndarray:
    """Return which points of `path` (n, 2 or more) [m] lie in the area of a place effect with parameters (p,)."""
    table = parameter_table()
    numbers = {p.name: float(values[table.place(f"{name}.{p.name}")]) for p in registry()[name].parameters}
    x, y = path[:, 0] - numbers["x"], path[:, 1] - numbers["y"]
    if "radius" in numbers:
        return np.asarray(np.hypot(x, y) < numbers["radius"])
    x, y = x / numbers["half_x"], y / numbers["half_y"]
    if numbers.get("roundness", 0.0) > 0.0:
        return np.asarray(np.hypot(x, y) < 1.0)
    return np.asarray((np.abs(x) < 1.0) & (np.abs(y) < 1.0))


def stands_out(ranked: Ranked, detect: float) -> bool:
    """Return whether an event stands out from other moments as chance hardly does; True where no moment was sought.

    detect : evidence that an effect needs.
    """
    chance = ranked.hypothesis.chance
    return chance <= 0.0 or (chance <= RARE and ranked.evidence >= detect)
