r"""Which push brings about what was seen after a moment? Found by simulation, as a push is not linear.

    J <- J + argmin_s |w (r(J) - C s)|^2        C_i = (f(J + d_i) - f(J)) / |d_i|,  r(J) = r(0) - f(J)

J [N s, N s, N m s] the impulse ahead, to the left and about the vertical at the push's begin; f(J) what it changes in
the whitened increments of the seconds in which it shows, r their residual, w the robust weights; d_i a nudge along each
of the three, of a size that moves a robot. A robot that stands, or that is pushed sideways, does not move until dry
friction or its tyres give way, and the motors of one robot hold it a hundred times as stiffly as those of another: a
rule for the first guess misses by as much. A speed controller ends at once what a hand began, and shows it again, the
other way, where the hand lets go: how long it leant is asked of the simulation, too (of a robot that was leant on three
times in a drive 14 to 15 units by speed errors that last became 33 to 45). Source: Gauss-Newton with secants, halved
while it makes things worse.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import GROWTH
from fsm_calib.diagnosis.candidates.outstanding import standing_out
from fsm_calib.diagnosis.candidates.scan_pushes import KICK, SEEN, are_apart, fitted
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.likelihood.robust import log_kernel
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.numbered import numbered
from fsm_calib.world2d.scale import Scale

IMPULSES = ("impulse_x", "impulse_y", "impulse_turn")
ROUNDS = 3  # of Gauss-Newton: what is left of a push is fitted in full anyway
HALVINGS = 2
SHIFTS = (-0.2, -0.1, 0.1, 0.2)  # s about a moment of the scan
LEANT = (0.5, 0.8, 1.2, 1.7, 2.5)  # s for which somebody may have leant on it
SHARE = 0.6  # of a strength's bounds within which its first guess lies
NUDGE = 0.2  # of the impulse so far, the size of the next nudges


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


def best_apart_from(others: Sequence[Pushed], known: Mapping[int, Sequence[Pushed]]) -> float:
    """Return the most that one wins which is none of the `known` of its recording."""
    apart = (o for o in others if all(o.is_apart_from(k) for k in known.get(o.run, ())))
    return max((o.won for o in apart), default=0.0)


@dataclass(frozen=True, eq=False)
class Moment:
    """A moment of one recording, with all that a push there is judged by.

    passages : of the parent model in that recording, of which only the push's seconds are simulated; scale : of the
    robot; seen : what a speed error here wins.
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

    def kick(self) -> Pushed:
        """Return the kick that wins most about here: what it began a controller ends in a tenth of a second."""
        return _most(moment.push() for moment in (self, *self._shifted()))

    def held(self) -> Pushed:
        """Return the push of some length that wins most, of those that begin, or end, about here."""
        tried = [
            replace(self, start=start, length=length)
            for length in LEANT
            for start in (self.start, self.start + self.length - length)
        ]
        best = _most(moment.push(rounds=1) for moment in tried)
        about = replace(self, start=best.start, length=best.length)
        best = _most([best, *(moment.push(rounds=1) for moment in about._shifted())])
        return replace(about, start=best.start).push()

    def _shifted(self) -> list[Moment]:
        """Return the moments a little before and after."""
        return [replace(self, start=self.start + shift) for shift in SHIFTS]

    def push(self, rounds: int = ROUNDS) -> Pushed:
        """Return the push that wins most here, after some rounds."""
        nu, white = self.residual.engine.nu, self._white
        impulse: FloatArray = np.zeros(3)
        done: FloatArray = np.zeros(len(white))
        won, nudge = 0.0, self._nudge()
        for _ in range(rounds):
            ahead = self._changed([impulse + d for d in np.diag(nudge)]) - done[:, None]
            _, step = fitted(ahead / nudge, white - done, nu)
            better = self._uphill(impulse, step, won)
            if better is None:
                break
            impulse, done, won = better
            nudge = np.maximum(NUDGE * np.abs(impulse), NUDGE * self._nudge())
        return Pushed(self.run, self.start, self.length, self._named(impulse), won, self.seen)

    def _uphill(
        self, impulse: FloatArray, step: FloatArray, won: float
    ) -> tuple[FloatArray, FloatArray, float] | None:
        """Return the impulse after a step, what it changes and wins; None where no part of the step wins more."""
        white, nu = self._white, self.residual.engine.nu
        before = log_kernel(white, nu)
        tried = [np.clip(impulse + 0.5**k * step, *self._bounds()) for k in range(HALVINGS + 1)]
        changed = self._changed(tried)
        wins = [float(log_kernel(white - column, nu) - before) for column in changed.T]
        best = int(np.argmax(wins))
        return (tried[best], changed[:, best], wins[best]) if wins[best] > won else None

    def _changed(self, impulses: list[FloatArray]) -> FloatArray:
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
    def _white(self) -> FloatArray:
        """The whitened innovations (n,) of the seconds in which the push shows."""
        scored, (first, last) = self.passages.simulator.prepared.scored, self._seconds
        begin = self.residual.rows(self.run).start + int(scored[:first].sum())
        return self.residual.white[begin : begin + int(scored[first : last + 1].sum())]

    def _nudge(self) -> FloatArray:
        """Return impulses (3,) that move a robot: the typical ones, at the force of a kick."""
        typical = [abs(self.effect.parameter(n).typical) * self._factor(n) for n in IMPULSES]
        return np.array([max(typical[:2]), max(typical[:2]), typical[2]]) * self.length / KICK

    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        high = np.array([SHARE * self.effect.parameter(n).high * self._factor(n) for n in IMPULSES])
        return -high, high

    def _factor(self, name: str) -> float:
        return self.scale.factor(self.effect.parameter(name).unit)

    def _named(self, impulse: FloatArray) -> dict[str, float]:
        """Return the start values of an impulse (3,) ahead, to the left and about the vertical."""
        s, name = self.situation, self.effect.name
        heading = float(np.interp(self.start, s.time, s.heading))
        c, d = np.cos(heading), np.sin(heading)
        ahead, left, turn = impulse.tolist()
        values = (c * ahead - d * left, d * ahead + c * left, turn)
        held = {f"{name}.duration": self.length} if self.length > KICK else {}
        named = {f"{name}.{n}": float(v) for n, v in zip(IMPULSES, values, strict=True)}
        return {**named, f"{name}.start": self.start, **held}


def _most(pushes: Iterable[Pushed]) -> Pushed:
    return max(pushes, key=lambda push: push.won)
