r"""Which push brings about what was seen after a moment? Found by simulation, as a push is not linear.

    J <- J + argmin_s |w (r(J) - C s)|^2        C_i = (f(J + d_i) - f(J)) / |d_i|,  r(J) = r(0) - f(J)

J [N s, N s, N m s] the impulse ahead, to the left and about the vertical at the push's begin; f(J) what it changes in
the whitened increments of the seconds in which it shows, r their residual, w the robust weights; d_i a nudge along each
of the three, of a size that moves a robot. A robot that stands, or that is pushed sideways, does not move until dry
friction or its tyres give way, and the motors of one robot hold it a hundred times as stiffly as those of another: a
rule for the first guess misses by as much. Source: Gauss-Newton with secants, halved while it makes things worse.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.candidates.scan_pushes import KICK, SEEN, are_apart, fitted, innovations_of
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.likelihood.robust import log_kernel
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.scale import Scale

IMPULSES = ("impulse_x", "impulse_y", "impulse_turn")
ROUNDS = 3  # of Gauss-Newton: what is left of a push is fitted in full anyway
HALVINGS = 2
SHIFTS = (-0.2, -0.1, 0.1, 0.2)  # s about a moment of the scan
SHARE = 0.6  # of a strength's bounds within which its first guess lies
MOST_STANDING = 4  # pushes of one recording that may all be real
NUDGE = 0.2  # of the impulse so far, the size of the next nudges


@dataclass(frozen=True, eq=False)
class Pushed:
    """A push of one recording: start and length [s], start values by full name, log-likelihood that it wins."""

    run: int
    start: float
    length: float
    changes: Mapping[str, float]
    won: float

    def is_apart_from(self, other: Pushed) -> bool:
        """Return whether this push of the same recording begins well after the other's end, or ends well before it."""
        return bool(are_apart(np.array(self.start), self.length, other.start, other.length))


def standing(pushes: Sequence[Pushed], run: int, worth: float) -> list[Pushed]:
    """Return the pushes of one recording, most first, that each win `worth` more than whatever else happened there.

    At least its best one. Who pushes a robot once may push it again: two alike would deny each other.
    """
    apart: list[Pushed] = []
    for push in sorted((p for p in pushes if p.run == run), key=lambda p: -p.won):
        if all(push.is_apart_from(other) for other in apart):
            apart.append(push)
    gaps = [apart[k - 1].won - apart[k].won for k in range(1, min(MOST_STANDING + 1, len(apart)))]
    size = max((k for k, gap in enumerate(gaps, 1) if gap >= worth), default=1)
    return apart[:size]


def known_beside(push: Pushed, others: Sequence[Pushed], worth: float) -> dict[int, list[Pushed]]:
    """Return of each recording the pushes that are no argument against this one: itself and what stands as it does."""
    known = {run: standing(others, run, worth) for run in {other.run for other in others}}
    if all(push.is_apart_from(other) for other in known.get(push.run, [])):
        known[push.run] = [push]
    return known


def best_apart_from(others: Sequence[Pushed], known: Mapping[int, Sequence[Pushed]]) -> float:
    """Return the most that one wins which is none of the `known` of its recording."""
    apart = (o for o in others if all(o.is_apart_from(k) for k in known.get(o.run, ())))
    return max((o.won for o in apart), default=0.0)


@dataclass(frozen=True, eq=False)
class Moment:
    """A moment of one recording, with all that a push there is judged by.

    passages : of the parent model in that recording, of which only the push's seconds are simulated; scale : of the
    robot.
    """

    effect: Effect
    passages: Passages
    residual: Residual
    situation: Situation
    run: int
    start: float
    length: float
    scale: Scale

    def best(self) -> Pushed:
        """Return the push that wins most about here: what a kick began a controller ends in a tenth of a second."""
        shifts = SHIFTS if self.length <= KICK else ()
        moments = [self, *(replace(self, start=self.start + shift) for shift in shifts)]
        return max((moment.push() for moment in moments), key=lambda push: push.won)

    def push(self) -> Pushed:
        """Return the push that wins most here."""
        rows, nu = self._rows(), self.residual.engine.nu
        white = self.residual.white[rows]
        impulse: FloatArray = np.zeros(3)
        done: FloatArray = np.zeros(len(white))
        won, nudge = 0.0, self._nudge()
        for _ in range(ROUNDS):
            ahead = self._changed([impulse + d for d in np.diag(nudge)], rows) - done[:, None]
            _, step = fitted(ahead / nudge, white - done, nu)
            better = self._uphill(impulse, step, rows, won)
            if better is None:
                break
            impulse, done, won = better
            nudge = np.maximum(NUDGE * np.abs(impulse), NUDGE * self._nudge())
        return Pushed(self.run, self.start, self.length, self._named(impulse), won)

    def _uphill(
        self, impulse: FloatArray, step: FloatArray, rows: slice, won: float
    ) -> tuple[FloatArray, FloatArray, float] | None:
        """Return the impulse after a step, what it changes and wins; None where no part of the step wins more."""
        white, nu = self.residual.white[rows], self.residual.engine.nu
        before = log_kernel(white, nu)
        tried = [np.clip(impulse + 0.5**k * step, *self._bounds()) for k in range(HALVINGS + 1)]
        changed = self._changed(tried, rows)
        wins = [float(log_kernel(white - column, nu) - before) for column in changed.T]
        best = int(np.argmax(wins))
        return (tried[best], changed[:, best], wins[best]) if wins[best] > won else None

    def _changed(self, impulses: list[FloatArray], rows: slice) -> FloatArray:
        """Return what pushes (3,) change in the whitened increments of the rows (n, m)."""
        engine, (_, before) = self.residual.engine, innovations_of(self.residual, self.run)
        pushed = [with_values(self.passages.values[None], self._named(impulse)) for impulse in impulses]
        columns = self.passages.changes(np.vstack(pushed), [self._seconds()])
        white = engine.white_columns((self.residual.whiteners[self.run],), [columns])
        return white[rows.start - before : rows.stop - before]

    def _seconds(self) -> tuple[int, int]:
        """Return the first and last event of the recording between which the push shows."""
        time = self.passages.simulator.prepared.time
        first, last = np.searchsorted(time, (self.start, self.start + self.length + SEEN)).tolist()
        return max(first - 1, 0), min(last, len(time) - 1)

    def _rows(self) -> slice:
        """Return the innovations of all recordings in which the push shows."""
        times, before = innovations_of(self.residual, self.run)
        first, last = np.searchsorted(times, (self.start, self.start + self.length + SEEN)).tolist()
        return slice(before + first, before + last)

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
