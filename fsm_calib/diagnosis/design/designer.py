"""The designer: composes a drive whose outcome would remove the most doubt per second, within bounds.

A drive costs its own seconds and those of getting back and looking (`Wishes.overhead`). Manoeuvres are added one by
one, each time the one that gives the most information per second, until another would give less per second than the
drive as a whole: the marginal value theorem (Charnov, Theor. Popul. Biol. 9 (1976) 129). Information is bounded from
below (`separation`); what is promised of the whole drive is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief, drawn_values, place_of
from fsm_calib.diagnosis.design.foresight import Foresight, Holds
from fsm_calib.diagnosis.design.plan import Forecast, Outlook, Plan, Waypoint
from fsm_calib.diagnosis.design.primitives import Primitive, menu
from fsm_calib.diagnosis.design.separation import Pairs, distances, expected_posteriors, information
from fsm_calib.types import FloatArray, Pose2

REACHES = (
    1.0,
    0.5,
    0.25,
)  # shares of the full manoeuvres that are tried in a row where longer ones do not fit in
CRAMPED_SHARE = 0.25  # of manoeuvres that do not fit in: from another place there may be more to choose from
MOST_TRIED = 12  # manoeuvres that are held against the bounds at each step before the drive ends there


@dataclass(frozen=True, slots=True)
class Wishes:
    """Bounds and prices of a drive.

    longest, shortest [s]; limit : largest command [1]; overhead [s] :
    what a drive costs beside itself; least [nat] : information below which a drive is not worth it; draws : of every
    explanation's numbers, for the promise; careful : of them, for the bounds; retried : manoeuvres that are weighed
    again at every step; caution : by how much more evidence is distrusted while composing than in the promise, for a
    drive that somebody has to set up and that should settle at once.
    """

    longest: float = 30.0
    shortest: float = 8.0
    limit: float = 0.6
    overhead: float = 6.0
    least: float = 0.02
    draws: int = 48
    careful: int = 4
    retried: int = 16
    caution: float = 1.0


def played(longest: float) -> Wishes:
    """Return the wishes for a drive that a person sets up and plays: long enough to settle what it can at once."""
    return Wishes(longest=longest, shortest=min(20.0, 0.6 * longest), overhead=60.0, caution=3.0)


class NoDrive(Enum):
    """Why there is no drive: none tells anything, none that tells anything fits in from here, none fits in at all."""

    NOTHING_TOLD = "nothing told"
    CRAMPED = "cramped"
    NO_ROOM = "no room"


def design(
    belief: Belief, area: Area, start: Pose2, rng: np.random.Generator, wishes: Wishes = Wishes()
) -> Plan | NoDrive:
    """Return the drive from `start` that settles most per second, or why there is none.

    Where manoeuvres of full reach do not fit in, shorter ones are tried.
    """
    if len(belief.hypotheses) < 2:
        return NoDrive.NOTHING_TOLD
    foresight, fits, cramped = Foresight(belief), False, False
    for reach in REACHES:
        composer = Composer.at(foresight, area, wishes, start, reach)
        chosen = composer.kept_safe(composer.composed(rng), rng)
        cramped = cramped or composer.refused > CRAMPED_SHARE * composer.offered
        fits = fits or bool(chosen)
        if chosen:
            plan = composer.plan(chosen, rng)
            if plan.forecast.information >= wishes.least:
                return plan
        if not composer.refused:
            break
    if not fits:
        return NoDrive.NO_ROOM
    return NoDrive.CRAMPED if cramped else NoDrive.NOTHING_TOLD


def random_drive(
    belief: Belief,
    area: Area,
    start: Pose2,
    rng: np.random.Generator,
    wishes: Wishes = Wishes(),
    seconds: float = 20.0,
) -> Plan | NoDrive:
    """Return a drive of primitives drawn at random within the same bounds, about `seconds` [s] long: what design is
    compared with.
    """
    foresight = Foresight(belief)
    for reach in REACHES:
        composer = Composer.at(foresight, area, wishes, start, reach)
        if chosen := composer.kept_safe(composer.drawn(seconds, rng), rng):
            return composer.plan(chosen, rng)
    return NoDrive.NO_ROOM


def foretold(plan: Plan, belief: Belief, rng: np.random.Generator, wishes: Wishes = Wishes()) -> Plan:
    """Return a plan with what it promises to a belief other than the one it was designed for."""
    start = np.array([plan.start.x, plan.start.y, plan.start.theta])
    return replace(plan, forecast=_promised(Foresight(belief), plan.holds, start, wishes.draws, rng)[0])


def _promised(
    foresight: Foresight, holds: Holds, start: FloatArray, draws: int, rng: np.random.Generator
) -> tuple[Forecast, FloatArray]:
    """Return what a drive promises, and what would be said of it (h, h): row = what is true, column = said."""
    belief, columns = foresight.belief, foresight.columns
    gram, p = foresight.gram(holds, start), belief.probabilities
    said, surest = expected_posteriors(gram, columns, belief.log_weights, belief.within, draws, rng)
    apart = distances(gram, columns, Pairs.of(columns))
    forecast = Forecast(
        sureness_before=belief.sureness,
        sureness=float(p @ surest) * (1.0 - belief.unnamed),
        information=information(apart, p, belief.tempers),
        doubt_before=belief.doubt,
    )
    return forecast, said


@dataclass(eq=False)
class Composer:
    """Chains manoeuvres from one start (x, y, theta).

    reach : share of their full length that straights and turns have. offered, refused : manoeuvres that were held
    against the bounds, and those that did not fit.
    """

    foresight: Foresight
    area: Area
    wishes: Wishes
    start: FloatArray
    reach: float = 1.0
    offered: int = 0
    refused: int = 0

    @classmethod
    def at(cls, foresight: Foresight, area: Area, wishes: Wishes, start: Pose2, reach: float) -> Composer:
        """Begin at `start`."""
        return cls(foresight, area, wishes, np.array([start.x, start.y, start.theta]), reach)

    def composed(self, rng: np.random.Generator) -> list[Primitive]:
        """Return manoeuvres in order, greedily by information per second; each within the bounds for every draw."""
        belief, columns = self.foresight.belief, self.foresight.columns
        pairs, p = Pairs.of(columns), belief.probabilities
        gram = np.zeros((columns.width, columns.width))
        starts = np.tile(self.start, (len(belief.hypotheses), 1))
        chosen: list[Primitive] = []
        rows, temper = self.rows(rng), belief.tempers * self.wishes.caution
        spent, known, rates = 0.0, 0.0, dict[str, float]()
        while True:
            weighed: list[tuple[float, Primitive, FloatArray, float]] = []
            for option in self._promising(starts, spent, rates, chosen):
                grown = gram + self.foresight.gram(option.holds, starts[0])
                told = information(distances(grown, columns, pairs), p, temper)
                rates[option.name] = rate = (told - known) / option.duration
                weighed.append((rate, option, grown, told))
            weighed = [w for w in weighed if self._goes_on(w[0], known, spent)]
            weighed.sort(key=lambda w: -w[0])
            best = next((w for w in weighed[:MOST_TRIED] if self.stays([*chosen, w[1]], rows)), None)
            if best is None:
                return chosen
            _, option, gram, known = best
            chosen.append(option)
            spent += option.duration
            starts = self.foresight.paths(option.holds, starts)[:, -1]

    def _promising(
        self, starts: FloatArray, spent: float, rates: Mapping[str, float], chosen: Sequence[Primitive]
    ) -> list[Primitive]:
        """Return the options that told most per second when they were last tried, new ones first.

        What a manoeuvre adds hardly ever grows as others are added (Minoux, Optimization Techniques (1978) 234).
        A cautious drive repeats none: equations are inexact alike in every repetition.
        """
        names = {p.name for p in chosen} if self.wishes.caution > 1.0 else set()
        fresh = [p for p in self.options(starts, spent) if p.name not in names]
        options = sorted(fresh, key=lambda p: -rates.get(p.name, math.inf))
        new = sum(p.name not in rates for p in options)
        return options[: new + self.wishes.retried]

    def _goes_on(self, rate: float, known: float, spent: float) -> bool:
        """Return whether another manoeuvre pays: it tells more per second than the drive as a whole."""
        if spent < self.wishes.shortest:
            return rate > 0.0
        return rate * (spent + self.wishes.overhead) > known

    def drawn(self, seconds: float, rng: np.random.Generator) -> list[Primitive]:
        """Return manoeuvres drawn at random until `seconds` [s] are full."""
        starts = np.tile(self.start, (len(self.foresight.belief.hypotheses), 1))
        chosen: list[Primitive] = []
        rows = self.rows(rng)
        while (spent := sum(p.duration for p in chosen)) < seconds:
            options = list(self.options(starts, spent))
            order = rng.permutation(len(options))[:MOST_TRIED]
            option = next((options[k] for k in order if self.stays([*chosen, options[k]], rows)), None)
            if option is None:
                break
            chosen.append(option)
            starts = self.foresight.paths(option.holds, starts)[:, -1]
        return chosen

    def options(self, starts: FloatArray, spent: float) -> Iterator[Primitive]:
        """Yield the manoeuvres that stay inside the area under every explanation, from each one's pose (h, 3)."""
        pace = replace(self.foresight.pace, share=self.reach)
        wanted = [*menu(self.wishes.limit, pace), *self._crossings(starts[0])]
        for option in wanted:
            if spent + option.duration > self.wishes.longest:
                continue
            paths = self.foresight.paths(option.holds, starts)
            self.offered += 1
            if self.area.allows(paths):
                yield option
            else:
                self.refused += 1

    def _crossings(self, pose: FloatArray) -> Iterator[Primitive]:
        """Yield turns towards the centre and the places that explanations name, and the straight over each."""
        centre = self.area.centre
        targets = {"the centre": (centre.x, centre.y)}
        targets |= {
            f"the {h.label}": place for h in self.foresight.belief.hypotheses if (place := place_of(h))
        }
        pace, u = self.foresight.pace, 0.4 * self.wishes.limit
        for name, (x, y) in targets.items():
            dx, dy = x - pose[0], y - pose[1]
            way = math.hypot(dx, dy)
            turn = math.remainder(math.atan2(dy, dx) - pose[2], math.tau)
            if way < 0.15:
                continue
            spin = round(abs(turn) / max(pace.turn(u), 0.1), 2)
            ahead = round(min((way + 0.25) / max(pace.speed(u), 0.02), 4.0), 2)
            side = math.copysign(u, turn)
            first = ((spin, -side, side), (0.4, 0.0, 0.0)) if spin > 0.05 else ()
            yield Primitive(f"towards {name} at {u:g}", (*first, (ahead, u, u), (0.6, 0.0, 0.0)))

    def holds(self, chosen: Sequence[Primitive]) -> tuple[tuple[float, float, float], ...]:
        """Return the commands of the whole drive."""
        return tuple(hold for primitive in chosen for hold in primitive.holds)

    def rows(self, rng: np.random.Generator) -> FloatArray:
        """Return parameter vectors (k, p): every explanation, and some draws from the spread of its numbers."""
        rows: list[FloatArray] = []
        for h in self.foresight.belief.hypotheses:
            rows += [h.values, *drawn_values(h, self.wishes.careful, rng)]
        return np.array(rows)

    def stays(self, chosen: Sequence[Primitive], rows: FloatArray) -> bool:
        """Return whether the drive so far stays within the bounds for every row of parameters."""
        fits = self.area.allows(self.foresight.rolled(self.holds(chosen), rows, self.start))
        self.offered, self.refused = self.offered + 1, self.refused + (not fits)
        return fits

    def kept_safe(self, chosen: list[Primitive], rng: np.random.Generator) -> list[Primitive]:
        """Return the longest beginning of a drive that stays within the bounds for new draws, too."""
        rows = self.rows(rng)
        while chosen and not self.stays(chosen, rows):
            chosen = chosen[:-1]
        return chosen

    def plan(self, chosen: Sequence[Primitive], rng: np.random.Generator) -> Plan:
        """Roll the whole drive out, and say what is expected of it."""
        foresight, belief = self.foresight, self.foresight.belief
        holds, p = self.holds(chosen), belief.probabilities
        forecast, said = _promised(foresight, holds, self.start, self.wishes.draws, rng)
        values = np.array([h.values for h in belief.hypotheses])
        ends = foresight.rolled(holds, values, self.start)[:, -1]
        outlooks = tuple(
            Outlook(
                h.names,
                float(p[k]),
                float(said[k, k]),
                Pose2(*map(float, ends[k])),
                _rival(belief, said[k], k),
            )
            for k, h in enumerate(belief.hypotheses)
        )
        path = foresight.rolled(holds, belief.leader.values[None], self.start)[0]
        steps, at = [], 0.0
        for primitive in chosen:
            steps.append(Waypoint(round(at, 3), primitive.name, round(primitive.duration, 3)))
            at += primitive.duration
        return Plan(holds, tuple(steps), Pose2(*map(float, self.start)), forecast, outlooks, path)


def _rival(belief: Belief, said: FloatArray, k: int) -> str:
    """Return with what an explanation would still be taken for, most likely; empty where with none."""
    others = said.copy()
    others[k] = 0.0
    worst = int(np.argmax(others))
    return belief.hypotheses[worst].label if others[worst] > 0.02 else ""
