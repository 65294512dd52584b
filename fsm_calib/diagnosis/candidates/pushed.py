"""A push at one moment of one recording, with the impulse that a simulation finds there (`impulse.py`).

A speed controller ends at once what a hand began, and shows it again, the other way, where the hand lets go: how long
it leant is asked of the simulation, too (of a robot that was leant on three times in a drive 14 to 15 units by speed
errors that last became 33 to 45).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import GROWTH
from fsm_calib.diagnosis.candidates.impulse import ROUNDS, Impulse
from fsm_calib.diagnosis.candidates.outstanding import standing_out
from fsm_calib.diagnosis.candidates.scan_pushes import KICK, SEEN, are_apart, turns
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.numbered import numbered
from fsm_calib.world2d.scale import Scale

IMPULSES = ("impulse_x", "impulse_y", "impulse_turn")
SHIFTS = (-0.2, -0.1, 0.1, 0.2)  # s about a moment of the scan
LEANT = (0.5, 0.8, 1.2, 1.7, 2.5)  # s for which somebody may have leant on it
SHARE = 0.6  # of a strength's bounds within which its first guess lies


@dataclass(frozen=True, eq=False)
class Pushed:
    """A push of one recording: start and length [s], start values by full name, log-likelihood that it wins.

    seen : what a speed error about that moment wins; it may be more, where the first guess is a little off.
    """

    run: int
    start: float
    length: float
    changes: Mapping[str, float]
    won: float
    seen: float = 0.0

    @property
    def promise(self) -> float:
        """The log-likelihood that a fit from here may win."""
        return max(self.won, self.seen)

    def is_apart_from(self, other: Pushed) -> bool:
        """Return whether this push of the same recording begins well after the other's end, or ends well before it."""
        return bool(are_apart(np.array(self.start), self.length, other.start, other.length))


def standing(pushes: Iterable[Pushed], run: int, worth: float, most: int) -> list[Pushed]:
    """Return the pushes of one recording, most first, that stand out together from whatever else happened there.

    At least its best one, at most `most`. Who pushes a robot once may push it again: two alike would deny each other.
    """
    apart: list[Pushed] = []
    for push in sorted((p for p in pushes if p.run == run), key=lambda p: -p.won):
        if all(push.is_apart_from(other) for other in apart):
            apart.append(push)
    won = [push.won for push in apart] + [worth / GROWTH]  # what was not tried promised less
    return apart[: max(standing_out(won, worth, most), 1)]


def known_beside(push: Pushed, standing: Mapping[int, Sequence[Pushed]]) -> dict[int, Sequence[Pushed]]:
    """Return of each recording the pushes that are no argument against this one: itself and what stands as it does."""
    known = dict(standing)
    if all(push.is_apart_from(other) for other in known.get(push.run, [])):
        known[push.run] = [push]
    return known


def together(pushes: Sequence[Pushed], effect: Effect) -> dict[str, float]:
    """Return the start values of several pushes of one recording, by full name, each with how long it lasted."""
    usual = {f"{effect.name}.duration": effect.parameter("duration").null}
    each = enumerate(pushes, 1)
    return {
        numbered(full, time): value
        for time, push in each
        for full, value in {**usual, **push.changes}.items()
    }


@dataclass(frozen=True, eq=False)
class Moment:
    """A moment of one recording, with all that a push there is judged by.

    passages : of the parent model in that recording, of which only the push's seconds are simulated; scale : of the
    robot; seen : what a speed error here wins; along : what its impulses are told along, as the effect has it, for one
    that comes alike elsewhere; None: ahead and to the left, told in the world.
    """

    effect: Effect
    passages: Passages
    residual: Residual
    situation: Situation
    run: int
    start: float
    length: float
    scale: Scale
    seen: float = 0.0
    along: float | None = None

    def kick(self) -> Pushed:
        """Return the kick that wins most about here: what it began a controller ends in a tenth of a second."""
        return _most(moment.push() for moment in (self, *self.shifted()))

    def held(self) -> Pushed:
        """Return the push of some length that wins most, of those that begin, or end, about here."""
        tried = [
            replace(self, start=start, length=length)
            for length in LEANT
            for start in (self.start, self.start + self.length - length)
        ]
        best = _most(moment.push(rounds=1) for moment in tried)
        about = replace(self, start=best.start, length=best.length)
        best = _most([best, *(moment.push(rounds=1) for moment in about.shifted())])
        return replace(about, start=best.start).push()

    def shifted(self) -> list[Moment]:
        """Return the moments a little before and after."""
        return [replace(self, start=self.start + shift) for shift in SHIFTS]

    def push(self, rounds: int = ROUNDS) -> Pushed:
        """Return the push that wins most here, after some rounds."""
        impulse, won = self.search().most_won(rounds)
        return Pushed(self.run, self.start, self.length, self._named(impulse), won, self.seen)

    def search(self) -> Impulse:
        """Return the search for the impulse of a push here."""
        return Impulse(self.changed, self.white, self.residual.engine.nu, self.nudge(), self.high())

    def changed(self, impulses: list[FloatArray]) -> FloatArray:
        """Return what pushes (3,) change in the whitened increments of the seconds in which they show (n, m)."""
        first, last = self._seconds
        pushed = [with_values(self.passages.values[None], self._named(impulse)) for impulse in impulses]
        columns = self.passages.changes(np.vstack(pushed), [self._seconds])[first : last + 1]
        return -self.residual.whiteners[self.run].of_span(columns, first, last)

    @cached_property
    def _seconds(self) -> tuple[int, int]:
        """Return the first and last event of the recording between which the push shows."""
        time = self.passages.simulator.prepared.time
        first, last = np.searchsorted(time, (self.start, self.start + self.length + SEEN)).tolist()
        return max(first - 1, 0), min(last, len(time) - 1)

    @cached_property
    def white(self) -> FloatArray:
        """The whitened innovations (n,) of the seconds in which the push shows."""
        scored, (first, last) = self.passages.simulator.prepared.scored, self._seconds
        begin = self.residual.rows(self.run).start + int(scored[:first].sum())
        return self.residual.white[begin : begin + int(scored[first : last + 1].sum())]

    def nudge(self) -> FloatArray:
        """Return impulses (3,) that move a robot: the typical ones, at the force of a kick."""
        typical = [abs(self.effect.parameter(n).typical) * self._factor(n) for n in IMPULSES]
        return np.array([max(typical[:2]), max(typical[:2]), typical[2]]) * self.length / KICK

    def high(self) -> FloatArray:
        """Return the largest impulses (3,) that are looked for."""
        return np.array([SHARE * self.effect.parameter(n).high * self._factor(n) for n in IMPULSES])

    def _factor(self, name: str) -> float:
        return self.scale.factor(self.effect.parameter(name).unit)

    def _named(self, impulse: FloatArray) -> dict[str, float]:
        """Return the start values of an impulse (3,), along what the moment's are told."""
        return {**self.shared(impulse), f"{self.effect.name}.start": self.start}

    def shared(self, impulse: FloatArray) -> dict[str, float]:
        """Return what of the start values of an impulse (3,) every push that is like this one has."""
        name = self.effect.name
        values = self.turned(impulse) if self.along is None else impulse
        held = {f"{name}.duration": self.length} if self.length > KICK else {}
        along = {} if self.along is None else {f"{name}.along": self.along}
        named = {f"{name}.{n}": float(v) for n, v in zip(IMPULSES, values, strict=True)}
        return {**named, **held, **along}

    def turned(self, impulse: FloatArray) -> FloatArray:
        """Return an impulse (3,) ahead, to the left and about the vertical in the world's directions."""
        heading = np.interp([self.start], self.situation.time, self.situation.heading)
        return np.asarray(turns(heading)[0] @ impulse)


def _most(pushes: Iterable[Pushed]) -> Pushed:
    return max(pushes, key=lambda push: push.won)
