"""From a diagnosis to a belief: the one place where the designer looks into a decision.

Probabilities are the diagnosis' own: exp(evidence / 2 TEMPER) among fitted explanations. A further effect may still
hide beside the likeliest, and what was found may hold only where it was driven (`doubts`). Before anything was driven
one effect of the catalogue is as likely as none; a second one beside the first is `FURTHER` times as likely as none.
Where nothing was detected, an effect that fitted a little of the noise is believed in by how likely it has a size that
matters, Laplace's approximation with sizes of both signs alike before,

    odds = exp(gain / TEMPER) min(1, sqrt(2 pi TEMPER) sd / 2) P(|size| > SIZES[0])

gain [nat] of the fit, size and its sd as shares of the typical size. Events happen once; in a new drive they change
nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import (
    catalogue,
    declared_starts,
    hypotheses_of,
    is_event,
)
from fsm_calib.diagnosis.candidates.ranking import evidence_of
from fsm_calib.diagnosis.candidates.starts import Prober
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis, depends_on_place, kept
from fsm_calib.diagnosis.design.doubts import SIZES, SPOT, TEMPER, Doubt, further_effects, shown_where
from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.diagnosis.fitting.values import switched_off, with_values
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.replay.simulator import NOMINAL_WHEEL_RATE
from fsm_calib.diagnosis.shapes.score_tests import residual_of
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.diagnosis.verdict.systematic_error import model_spread
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import NUISANCE, parameter_table

GENERAL_DOUBT = 0.02  # share of names that are wrong for no visible reason
MOST = 20  # explanations that are kept: those behind have a thousandth of the doubt
FURTHER = 0.15  # odds of a second effect beside the one that was found
ONLY_HERE = 0.06  # odds that what was found is the floor's, where all of it was found in one spot
LEAST_GAIN = 0.5  # log-likelihood units: a fit that won less found nothing
PRIOR_SPREAD = 0.4  # of a typical size, before anything was driven
UNNAMED = 0.5  # probability that no name is right, where the diagnosis gives none
ANY_PHASE = 1.8  # rad: standard deviation of a phase that may be anything
PRIOR_BASE = {
    "gain_left": 0.08, "gain_right": 0.08, "axle_length": 0.005, "tau_forward": 0.05, "tau_turn": 0.06,
}  # before anything was driven; m/s, m, s: gains of 32 real robots differ by an eighth (parameters.SPREAD)  # fmt: skip

Weighed = tuple[float, Hypothesis]
"""Log odds against nothing at all, and the explanation."""


def belief_of(decision: Decision, most: int = MOST) -> Belief:
    """Return what a decision leaves us to believe of the next drive."""
    base, simulator = decision.base, decision.engine.simulators[0]
    if decision.outcome == "match":
        weighed = [(0.0, _nothing(base)), *_unnoticed(decision)]
    else:
        weighed = [(0.0, _nothing(base)), *_singles(decision), *_pairs(decision)]
        weighed += _doubted(decision, weighed)
    top = max(log_odds for log_odds, _ in weighed)
    hypotheses = kept([replace(h, probability=math.exp(log_odds - top)) for log_odds, h in weighed], most)
    total = sum(h.probability for h in hypotheses)
    frames = float(np.median([s.prepared.geometry[2] for s in decision.engine.simulators]))
    return Belief(
        hypotheses=tuple(replace(h, probability=h.probability / total) for h in hypotheses),
        base=len(base.slots),
        plain=base.values[0],
        noise=decision.model.fit.noise,
        robot=simulator.prepared.recording.robot,
        frame_rate=1.0 / max(frames, 1e-3),
        full_speed=simulator.full_speed,
        unnamed=UNNAMED if decision.outcome == "unexplained" else GENERAL_DOUBT,
    )


def prior_belief(
    noise: Noise | None = None,
    robot: RobotFacts | None = None,
    frame_rate: float = 15.0,
    most: int = 30,
) -> Belief:
    """Return what is believed of a robot that has not been driven: nothing missing, or one effect of typical size."""
    facts = robot or RobotFacts(wheel_radius=0.0318, axle_length=0.1, max_wheel_rate=NOMINAL_WHEEL_RATE)
    table = parameter_table()
    full = (facts.max_wheel_rate or NOMINAL_WHEEL_RATE) * (facts.wheel_radius or 0.0318)
    plain = table.null
    for name in ("gain_left", "gain_right"):
        plain[table.place(name)] = full
    slots = tuple(slot_of(name) for name in NUISANCE)
    spread = np.diag([PRIOR_BASE[name] ** 2 for name in NUISANCE])
    hypotheses = [Hypothesis((), 0.5, plain, tuple(s.place for s in slots), spread, _steps(slots))]
    effects = [
        e for e in catalogue() if not is_event(e) and e.input in ("any", "command") and e.scan != "place"
    ]
    for effect in effects:
        values = with_values(plain[None], declared_starts(next(hypotheses_of(effect, 1)))[0])[0]
        own, sizes = _own_slots(effect, values)
        covariance = np.zeros((len(slots) + len(own),) * 2)
        covariance[: len(slots), : len(slots)] = spread
        covariance[range(len(slots), len(covariance)), range(len(slots), len(covariance))] = sizes**2
        places = tuple(s.place for s in (*slots, *own))
        hypotheses.append(
            Hypothesis((effect.name,), 0.5 / len(effects), values, places, covariance, _steps((*slots, *own)))
        )
    return Belief(
        kept(hypotheses, most), len(slots), plain, noise or Noise(), facts, frame_rate, full, GENERAL_DOUBT
    )


def _own_slots(effect: Effect, values: FloatArray) -> tuple[list[Slot], FloatArray]:
    """Return the strengths that a typical effect moves, and their spread before anything was driven."""
    own = [slot_of(f"{effect.name}.{name}") for name in effect.strengths if effect.parameter(name).fitted][:2]
    sizes = [PRIOR_SPREAD * abs(effect.parameter(name).typical - effect.parameter(name).null)
             for name in effect.strengths if effect.parameter(name).fitted][:2]  # fmt: skip
    return own, np.array(sizes)


def _steps(slots: Sequence[Slot]) -> FloatArray:
    return np.array([s.step for s in slots])


def _nothing(base: Fit) -> Hypothesis:
    places = tuple(s.place for s in base.slots)
    return Hypothesis((), 1.0, base.values[0], places, _spread(base, base.slots, ()), _steps(base.slots))


def _singles(decision: Decision) -> Iterator[Weighed]:
    """Yield every effect that won something by itself."""
    for ranked in decision.ranking:
        if ranked.gain >= LEAST_GAIN:
            yield 0.5 * ranked.evidence / TEMPER, _fitted(ranked.fit, (ranked.name,), decision.base)


def _pairs(decision: Decision) -> Iterator[Weighed]:
    """Yield an answer of several effects, the same without each of them, and with each of its rivals in its place."""
    supports = decision.model.supports
    if len(supports) < 2:
        return
    names = tuple(s.name for s in supports)
    total = evidence_of(decision.model.fit, decision.base, decision.engine.count)
    yield 0.5 * total / TEMPER, _fitted(decision.model.fit, names, decision.base)
    for i, support in enumerate(supports):
        rest = names[:i] + names[i + 1 :]
        if len(rest) > 1:
            yield (
                0.5 * (total - support.added.evidence) / TEMPER,
                _fitted(support.without, rest, decision.base),
            )
        for rival in support.rivals:
            other = (*names[:i], rival.name, *names[i + 1 :])
            yield 0.5 * (total - rival.gap.evidence) / TEMPER, _fitted(rival.fit, other, decision.base)


def _fitted(fit: Fit, names: tuple[str, ...], base: Fit) -> Hypothesis:
    """Return a fitted explanation as it would act in a new drive."""
    table = parameter_table()
    events = tuple(name for name in names if is_event(registry()[name]))
    values = switched_off(fit.values[:1], events)[0]
    first_runs: dict[int, Slot] = {}
    for slot in fit.slots[len(base.slots) :]:
        if table.owner[slot.place] not in events:
            first_runs.setdefault(slot.place, slot)
    slots = (*base.slots, *first_runs.values())
    return Hypothesis(
        names, 1.0, values, tuple(s.place for s in slots), _spread(fit, slots, names), _steps(slots)
    )


def _spread(fit: Fit, slots: Sequence[Slot], names: tuple[str, ...]) -> FloatArray:
    """Return the covariance of slots: the fit's, the doubt about each equation, and any phase in a new drive."""
    table = parameter_table()
    where = [fit.slots.index(slot) for slot in slots]
    covariance = np.array(fit.covariance[np.ix_(where, where)])
    for k, slot in enumerate(slots):
        owner = table.owner[slot.place]
        if not owner:
            continue
        entry = table.entries[slot.place]
        if entry.per_recording:
            covariance[k, :] = covariance[:, k] = 0.0
            covariance[k, k] = ANY_PHASE**2
        covariance[k, k] += model_spread(registry()[owner], entry.name, float(fit.values[0, slot.place])) ** 2
    return np.asarray(0.5 * (covariance + covariance.T))


def _unnoticed(decision: Decision) -> Iterator[Weighed]:
    """Yield the effects that a match may have all the same, together as likely as none before anything was driven."""
    base, doubts = decision.base, {d.effect: d for d in further_effects(decision.bank.prober)}
    won = {r.name: r for r in decision.ranking if r.gain >= LEAST_GAIN and not is_event(registry()[r.name])}
    names = {*doubts, *won}
    for name in sorted(names):
        weighed = []
        if name in doubts:
            weighed.append((doubts[name].log_odds, _beside(base, (), doubts[name], base)))
        if name in won:
            weighed.append(
                (_fitted_odds(won[name].fit, name, won[name].gain), _fitted(won[name].fit, (name,), base))
            )
        log_odds, hypothesis = max(weighed, key=lambda w: w[0])
        yield log_odds - math.log(len(names)), hypothesis


def _fitted_odds(fit: Fit, name: str, gain: float) -> float:
    """Return the log odds that a fitted effect has a size that matters."""
    table, effect, log_odds, unlikely = parameter_table(), registry()[name], gain / TEMPER, 1.0
    for slot, value, variance in fit.numbers():
        entry = table.entries[slot.place]
        if table.owner[slot.place] != name or not entry.strength:
            continue
        typical = effect.parameter(entry.name).typical - effect.parameter(entry.name).null
        if typical == 0.0:
            continue
        size, sd = (value - entry.null) / abs(typical), math.sqrt(max(TEMPER * variance, 0.0)) / abs(typical)
        log_odds += min(math.log(max(math.sqrt(math.tau) * sd / 2.0, 1e-300)), 0.0)
        unlikely *= _within(size, sd, SIZES[0])
    return log_odds + math.log(max(1.0 - unlikely, 1e-300))


def _within(mean: float, sd: float, limit: float) -> float:
    """Return the probability that a normal number lies within +-limit."""
    scale = max(sd, 1e-12) * math.sqrt(2.0)
    return 0.5 * (math.erf((limit - mean) / scale) + math.erf((limit + mean) / scale))


def _doubted(decision: Decision, weighed: Sequence[Weighed]) -> Iterator[Weighed]:
    """Yield what the likeliest explanation may be beside itself: with a further effect, or only where it was driven."""
    log_odds, leader = max(weighed, key=lambda w: w[0])
    fit = _fit_of(decision, leader.names)
    if fit is None:
        return
    engine, known = decision.engine, {frozenset(h.names) for _, h in weighed}
    beside = list(further_effects(Prober(engine.simulators, fit, residual_of(engine, fit))))
    for doubt in beside:
        if frozenset((*leader.names, doubt.effect)) not in known:
            odds = min(doubt.log_odds + math.log(FURTHER), 0.0) - math.log(
                len(beside)
            )  # the diagnosis saw none
            yield log_odds + odds, _beside(fit, leader.names, doubt, decision.base)
    placed = all(s.prepared.poses.placed for s in engine.simulators)
    if placed and not any(depends_on_place(name) for name in leader.names):
        (x, y), only_here = shown_where(decision.bank.prober, fit.values)
        yield log_odds + math.log(ONLY_HERE) + only_here, replace(leader, spot=(float(x), float(y), SPOT))


def _fit_of(decision: Decision, names: tuple[str, ...]) -> Fit | None:
    """Return the fit of an explanation by its names; None for nothing at all and for others than those looked into."""
    if names == tuple(s.name for s in decision.model.supports):
        return decision.model.fit
    return next((r.fit for r in decision.ranking if (r.name,) == names), None)


def _beside(fit: Fit, names: tuple[str, ...], doubt: Doubt, base: Fit) -> Hypothesis:
    """Return an explanation with a further effect of the size that is doubted."""
    told = _fitted(fit, names, base)
    slot = slot_of(f"{doubt.effect}.{doubt.parameter}")
    size = len(told.places)
    covariance = np.zeros((size + 1, size + 1))
    covariance[:size, :size] = told.covariance
    covariance[size, size] = doubt.spread**2
    return Hypothesis(
        (*names, doubt.effect),
        1.0,
        with_values(told.values[None], doubt.values)[0],
        (*told.places, slot.place),
        covariance,
        np.append(told.steps, slot.step),
    )
