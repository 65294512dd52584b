"""Who pushed the robot, when and how often? Moments that stand out by speed errors, each then tried by simulation.

Kicks, and pushes that last, are sought apart: these have a number more, and a length for which anything slow may stand
in. What stands out together (`pushed.standing`) is offered as one: several pushes of a drive are one effect, and each
alone leaves the others to speak against it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import GROWTH, Candidate
from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.outstanding import MOMENTS, by_chance
from fsm_calib.diagnosis.candidates.push_alike import AlikeSearch
from fsm_calib.diagnosis.candidates.pushed import (
    Moment,
    Pushed,
    known_beside,
    standing,
    together,
)
from fsm_calib.diagnosis.candidates.scan_pushes import HELD, KICK, Pushes, apart_from, pushes
from fsm_calib.diagnosis.fitting.side_by_side import side_by_side
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.numbered import starts_in
from fsm_calib.world2d.scale import Scale

SIMULATED = 6  # moments of one recording that are tried by simulation, more than may stand together
SAME = 1.0  # s between the middles of two of them
OTHERS_APART = (
    2.0  # s between the middles of those that one has to stand out from: what is seen of one overlaps less
)


@dataclass(frozen=True, eq=False)
class PushSearch:
    """The search for pushes on top of one model.

    passages : of that model, one a recording; scale : of the robot.
    """

    effect: Effect
    residual: Residual
    situations: Sequence[Situation]
    passages: Sequence[Passages]
    scale: Scale

    def candidates(self, keep: int) -> list[Candidate]:
        """Return at most `keep` kicks and as many that last, most promising first, and what stands out together.

        A push that lasts costs a number more, so it has to promise as much more than the best kick.
        """
        kicks = self._each(self._kicks, self._seen[:1], keep)
        best = max((candidate.promise for candidate in kicks), default=0.0)
        held = self._each(self._held, self._seen[1:], keep)
        lasting = [candidate for candidate in held if candidate.promise > best + 0.5 * self._price]
        return kicks + lasting + list(self._together()) + self._alike()

    @property
    def _price(self) -> float:
        """The evidence that one number must bring [1]."""
        return float(np.log(self.residual.engine.count))

    @property
    def _worth(self) -> float:
        """The log-likelihood that the numbers of a push which lasts must win."""
        return 0.5 * self._price * len(self.effect.closure("held").frees)

    @cached_property
    def _seen(self) -> list[list[Pushes]]:
        """By length, kicks first: what speed errors that begin at each moment of each recording win."""
        runs = range(len(self.situations))
        return [
            [pushes(self.residual, run, self.situations[run], length) for run in runs]
            for length in (KICK, *HELD)
        ]

    @cached_property
    def _kicks(self) -> list[Pushed]:
        """The kicks that a simulation finds about the moments that stand out most."""
        return side_by_side(self.residual.engine, Moment.kick, self._moments(self._seen[:1]))

    @cached_property
    def _held(self) -> list[Pushed]:
        """The pushes that last, found in the same way, also where a kick stands out: it may be how one began."""
        return side_by_side(self.residual.engine, Moment.held, self._moments(self._seen))

    def _alike(self) -> list[Candidate]:
        """Return what came alike in every recording."""
        engine, worth = self.residual.engine, (self._worth, self._price)
        return AlikeSearch(self._seen, engine, self.situations, self._moment, *worth).candidates()

    def _moment(self, run: int, start: float, length: float, seen: float = 0.0) -> Moment:
        """Return a moment of one recording."""
        told = run, start, length, self.scale, seen
        return Moment(self.effect, self.passages[run], self.residual, self.situations[run], *told)

    def _moments(self, seen: Sequence[Sequence[Pushes]]) -> Iterator[Moment]:
        """Yield the moments that promise most, of some lengths and apart in time, where one may be worth a push.

        What a simulation makes of the others is what it makes of nothing: they are tried where that one is.
        """
        most = max((float(one.won.max(initial=0.0)) for lengths in seen for one in lengths), default=0.0)
        if GROWTH * most < self._worth:
            return
        for run, tried in enumerate(_moments_of(seen, ())):
            for i in apart(tried.won, tried.middle, SIMULATED, SAME):
                told = tried.starts[i], tried.lengths[i], tried.won[i]
                yield self._moment(run, *map(float, told))

    def _standing(self, found: Sequence[Pushed]) -> Mapping[int, list[Pushed]]:
        """Return of each recording the pushes that stand out together, at least its best one of those found."""
        most = len(starts_in(p.name for p in self.effect.parameters))
        return {run: standing(found, run, self._worth, most) for run in {push.run for push in found}}

    def _each(
        self, simulated: Sequence[Pushed], seen: Iterable[Sequence[Pushes]], keep: int
    ) -> list[Candidate]:
        """Return the best of some pushes, each by itself."""
        every, stand, found = _moments_of(seen, simulated), self._standing(simulated), []
        for push in simulated:
            chance = by_chance([push.promise, *_others(every, known_beside(push, stand))])
            found.append(Candidate(push.changes, push.promise, push.run, chance))
        return sorted(found, key=lambda candidate: -candidate.promise)[:keep]

    def _together(self) -> Iterator[Candidate]:
        """Yield of each recording what stands out together, where that is more than one."""
        found = [*self._kicks, *self._held]
        every, stand = _moments_of(self._seen, found), self._standing(found)
        for run, several in stand.items():
            if len(several) > 1:
                won = sorted((push.promise for push in several), reverse=True)
                chance = by_chance([*won, *_others(every, stand)], len(several))
                yield Candidate(together(several, self.effect), sum(won), run, chance)


@dataclass(frozen=True, eq=False)
class _Moments:
    """All pushes (m,) that were tried in one recording: begins and lengths [s], and what each wins."""

    starts: FloatArray
    lengths: FloatArray
    won: FloatArray

    @property
    def middle(self) -> FloatArray:
        """The middles (m, 1) [s]."""
        return (self.starts + 0.5 * self.lengths)[:, None]


def _moments_of(seen: Iterable[Sequence[Pushes]], simulated: Sequence[Pushed]) -> list[_Moments]:
    """Return what was tried in each recording: speed errors of some lengths, and pushes that were simulated."""
    found = []
    for run, each in enumerate(zip(*seen, strict=True)):
        own = [push for push in simulated if push.run == run]
        starts = [*(one.starts for one in each), [push.start for push in own]]
        lengths = [*(np.full(len(one.starts), one.length) for one in each), [push.length for push in own]]
        won = [*(one.won for one in each), [push.won for push in own]]
        found.append(_Moments(*map(np.concatenate, (starts, lengths, won))))
    return found


def _others(every: Sequence[_Moments], known: Mapping[int, Sequence[Pushed]]) -> list[float]:
    """Return what moments apart in time win that are none of the `known` of their recording, most first."""
    found: list[float] = []
    for run, moments in enumerate(every):
        told = ((push.start, push.length) for push in known.get(run, ()))
        free = apart_from(moments.starts, moments.lengths, told)
        won = moments.won[free]
        found += won[apart(won, moments.middle[free], MOMENTS + 1, OTHERS_APART)].tolist()
    return sorted(found, reverse=True)
