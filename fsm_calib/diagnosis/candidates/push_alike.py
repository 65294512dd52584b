r"""Was it pushed alike in every drive? One moment of each recording that one and the same impulse explains.

    J = (sum_r P_r)^-1 sum_r s_r,    won_r = s_r' J - J' P_r J / 2,    agreed = R min_r won_r

P_r, s_r : power and score of speed errors ahead, to the left and at the rim [m/s] at a moment of recording r, of R
(`scan_pushes.py`), turned by the heading there where what pushes stays along the room, and as they are where it stays
along the robot. Chance, or an inexact law, may have one moment of one drive; that it has two which agree in size and
direction is as rare as their product. If what one moment wins falls off as exp(-w / f), R times the least of R falls
off alike, so that both are held to one rule (`outstanding.by_chance`). So a push which is too faint to stand out in
either drive does in both: of three robots of others' physics that were pushed by 1 % of their weight, or turned, 13 to
36 units in each drive beside 10 to 31 elsewhere. Moments of three and more recordings are joined one recording after
the other. Source: pooled estimates, e.g. DerSimonian & Laird, Control. Clin. Trials 7 (1986) 177, without a spread
between the drives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import GROWTH, Candidate
from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.impulse import ROUNDS
from fsm_calib.diagnosis.candidates.outstanding import MOMENTS, by_chance
from fsm_calib.diagnosis.candidates.pushed import LEANT, Moment
from fsm_calib.diagnosis.candidates.scan_pushes import KICK, STEP, Pushes, apart_from, turns
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.side_by_side import side_by_side
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.external_push import ALONG_WHAT

Known = Mapping[int, Sequence[tuple[float, float]]]
"""Moments that are taken, by recording: begin and length [s]."""

JOINED = 40  # moments of each recording, of which the best one each are joined
NO_POWER = 1e-9  # added to a moment's that wins nothing
SIMULATED = 2  # of what promises most along the room, and along the robot
SAME = 1.0  # s between the moments of two of them


@dataclass(frozen=True, eq=False)
class Agreed:
    """Moments (R,) [s], one of each recording, at which pushes of one length [s] agree.

    won : what they win together; agreed : R times what the one wins that wins least.
    """

    starts: tuple[float, ...]
    length: float
    along: float
    won: float
    agreed: float


@dataclass(frozen=True, slots=True)
class Alike:
    """A push that came alike in every recording, as simulations find it about moments that agree.

    candidate : with its start values and the log-likelihood that a fit from there may win; starts (R,), length [s] : of
    each; won : together as it stands; agreed : R times what the one wins that wins least, or that of speed errors.
    """

    candidate: Candidate
    starts: tuple[float, ...]
    length: float
    won: float
    agreed: float


@dataclass(frozen=True, eq=False)
class _Push:
    """One impulse (3,) at a moment of each recording, and what it wins together."""

    moments: tuple[Moment, ...]
    impulse: FloatArray
    won: float

    def found(self, about: Agreed) -> Alike:
        """Return it as found about some moments, whose speed errors may win more where the guess is a little off."""
        name, shared = self.moments[0].effect.name, self.moments[0].shared(self.impulse)
        each = tuple({f"{name}.start": moment.start} for moment in self.moments)
        candidate = Candidate(shared, max(self.won, about.won), ALL_RUNS, each=each)
        least = len(self.moments) * min(_won_by(moment, self.impulse) for moment in self.moments)
        starts = tuple(moment.start for moment in self.moments)
        return Alike(candidate, starts, self.moments[0].length, self.won, max(least, about.agreed))


@dataclass(frozen=True, eq=False)
class AlikeSearch:
    """The search for pushes that came alike in every recording.

    seen : by length, kicks first, what speed errors win in each recording; moment : makes a moment of a recording, by
    number, begin and length [s]; worth : log-likelihood that the numbers of one that lasts must win; price : that one
    number must.
    """

    seen: Sequence[Sequence[Pushes]]
    engine: Engine
    situations: Sequence[Situation]
    moment: Callable[[int, float, float], Moment]
    worth: float
    price: float

    def candidates(self) -> list[Candidate]:
        """Return the best kick that came alike in every recording, and the best that lasts where it promises more."""
        best = self._agreed[:1]
        if len(self.situations) < 2 or not best or GROWTH * best[0].won < self.worth:
            return []
        tried = [agreed for along in ALONG_WHAT.values() for agreed in self._leaders(along)]
        found = [one for some in side_by_side(self.engine, self._simulated, tried) for one in some]
        kicks = [one for one in found if one.length <= KICK]
        lasting = [one for one in found if one.length > KICK]
        kick = max(kicks, key=lambda one: one.agreed, default=None)
        held = max(lasting, key=lambda one: one.agreed, default=None)
        kept = [kick] if kick is not None else []
        if held is not None and (kick is None or held.won > kick.won + 0.5 * self.price):
            kept.append(held)
        return [replace(one.candidate, chance=self._chance(one)) for one in kept]

    @cached_property
    def _agreed(self) -> list[Agreed]:
        """What agrees between the recordings, best first."""
        return sorted(self._joined({}), key=lambda one: -one.agreed)

    def _leaders(self, along: float) -> list[Agreed]:
        """Return what agrees best along the room or the robot."""
        some = [one for one in self._agreed if one.along == along and one.agreed > 0.0]
        agreed = np.array([one.agreed for one in some])
        starts = np.array([one.starts for one in some]).reshape(len(some), -1)
        return [some[i] for i in apart(agreed, starts, SIMULATED, SAME)]

    def _joined(self, known: Known) -> Iterator[Agreed]:
        """Yield the best that each moment of the first recording agrees with, none of it one of the `known`."""
        for each in self.seen:
            length, robot = each[0].length, [self._told(one, known.get(one.run, ())) for one in each]
            room = [told.turned(turns(self._heading(run, told.starts))) for run, told in enumerate(robot)]
            yield from _agreeing(room, ALONG_WHAT["room"], length)
            yield from _agreeing(robot, ALONG_WHAT["robot"], length)

    def _told(self, seen: Pushes, known: Sequence[tuple[float, float]]) -> _Told:
        """Return what is told at the best moments of a recording, apart from what is known by begin and length."""
        free = apart_from(seen.starts, seen.length, known)
        best = np.flatnonzero(free)[apart(seen.won[free], seen.starts[free][:, None], JOINED, 1.5 * STEP)]
        numbers, power = seen.numbers[best], seen.power[best]
        power = power * _as_densities(seen.won[best], numbers, power)[:, None, None]
        return _Told(seen.starts[best], power, np.einsum("mij,mj->mi", power, numbers))

    def _heading(self, run: int, moments: FloatArray) -> FloatArray:
        """Return the headings (m,) [rad] of a recording at some moments [s]."""
        return np.interp(moments, self.situations[run].time, self.situations[run].heading)

    def _simulated(self, agreed: Agreed) -> list[Alike]:
        """Return the kick, if it may be one, and the push that lasts which win most about some moments."""
        about = [
            replace(self.moment(run, start, agreed.length), along=agreed.along)
            for run, start in enumerate(agreed.starts)
        ]
        kicks = [self._pushed(about)] if agreed.length <= KICK else []
        held = [
            self._pushed([_of_length(moment, length, ends) for moment in about], rounds=1)
            for length in LEANT
            for ends in (False, True)
        ]
        best = [*kicks, max(held, key=lambda one: one.won)]
        return [self._settled(one).found(agreed) for one in best]

    def _pushed(self, moments: Sequence[Moment], rounds: int = ROUNDS) -> _Push:
        """Return the push, the same at all moments, that wins most after some rounds."""

        def changed(impulses: list[FloatArray]) -> FloatArray:
            return np.vstack([moment.changed(impulses) for moment in moments])

        white = np.concatenate([moment.white for moment in moments])
        impulse, won = replace(moments[0].search(), changed=changed, white=white).most_won(rounds)
        return _Push(tuple(moments), impulse, won)

    def _settled(self, found: _Push) -> _Push:
        """Return a push with each of its moments where its recording is likeliest, fitted again."""
        moments = []
        for moment in found.moments:
            tried = [moment, *moment.shifted()]
            moments.append(max(tried, key=lambda one: _won_by(one, found.impulse)))
        return max(found, self._pushed(moments), key=lambda one: one.won)

    def _chance(self, found: Alike) -> float:
        """Return with which probability moments that nobody pushed at agree so much better than the next ones."""
        known, others = (
            {run: [(start, found.length)] for run, start in enumerate(found.starts)},
            list[float](),
        )
        while len(others) <= MOMENTS:
            best = max(self._joined(known), key=lambda one: one.agreed, default=None)
            if best is None or best.agreed <= 0.0:
                break
            others.append(best.agreed)
            for run, start in enumerate(best.starts):
                known[run].append((start, best.length))
        return by_chance([found.agreed, *sorted(others, reverse=True)])


@dataclass(frozen=True, eq=False)
class _Told:
    """Moments (m,) [s] of a recording with the power (m, 3, 3) of their columns and the scores (m, 3) on them."""

    starts: FloatArray
    power: FloatArray
    score: FloatArray

    def turned(self, by: FloatArray) -> _Told:
        """Return it with the directions turned by rotations (m, 3, 3)."""
        power = by @ self.power @ np.swapaxes(by, 1, 2)
        return _Told(self.starts, power, np.einsum("mij,mj->mi", by, self.score))


def _agreeing(each: Sequence[_Told], along: float, length: float) -> Iterator[Agreed]:
    """Yield with each moment of the first recording the one of every further one that agrees best."""
    first = each[0]
    powers, scores, starts = first.power[:, None], first.score[:, None], first.starts[:, None]
    won = _each_wins(powers, scores)
    for told in each[1:]:
        if not len(told.starts):
            return
        pairs, rows = (len(powers), len(told.starts)), np.arange(len(powers))
        power = np.concatenate([_spread(powers, pairs, 1), _spread(told.power[:, None], pairs, 0)], axis=2)
        score = np.concatenate([_spread(scores, pairs, 1), _spread(told.score[:, None], pairs, 0)], axis=2)
        each_wins = _each_wins(power, score)
        best = np.argmax(each_wins.min(axis=2), axis=1)
        powers, scores, won = power[rows, best], score[rows, best], each_wins[rows, best]
        starts = np.column_stack([starts, told.starts[best]])
    for moments, wins in zip(starts.tolist(), won, strict=True):
        yield Agreed(tuple(moments), length, along, float(wins.sum()), float(len(wins) * wins.min()))


def _spread(some: FloatArray, pairs: tuple[int, int], axis: int) -> FloatArray:
    """Return what some moments have for all pairs of them with others, which stand along `axis`."""
    return np.broadcast_to(np.expand_dims(some, axis), (*pairs, *some.shape[1:]))


def _each_wins(power: FloatArray, score: FloatArray) -> FloatArray:
    """Return what one impulse wins in each recording (..., R) of powers (..., R, 3, 3) and scores (..., R, 3)."""
    whole = power.sum(axis=-3) + NO_POWER * np.eye(3)
    impulse = np.linalg.solve(whole, score.sum(axis=-2)[..., None])[..., 0]
    squares = np.einsum("...i,...rij,...j->...r", impulse, power, impulse)
    return np.asarray(np.einsum("...ri,...i->...r", score, impulse) - 0.5 * squares)


def _won_by(moment: Moment, impulse: FloatArray) -> float:
    """Return the log-likelihood that an impulse (3,) wins at a moment as it stands."""
    return float(moment.search().wins(moment.changed([impulse]))[0])


def _as_densities(won: FloatArray, numbers: FloatArray, power: FloatArray) -> FloatArray:
    """Return what part of powers (m, 3, 3) is won (m,): an outlier weighs less than its square says."""
    squares = 0.5 * np.einsum("mi,mij,mj->m", numbers, power, numbers)
    return np.asarray(np.clip(won / np.maximum(squares, 1e-12), 0.0, 1.0))


def _of_length(moment: Moment, length: float, ends: bool) -> Moment:
    """Return a moment of another length [s], that begins where it did, or `ends` there."""
    start = moment.start + (moment.length - length if ends else 0.0)
    return replace(moment, start=start, length=length)
