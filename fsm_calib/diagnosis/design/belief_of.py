"""From a diagnosis to a belief: the one place where the designer looks into a decision.

Odds follow from the diagnosis' evidence by one law (`odds`); a rival that the verdict has in a set with an effect is as
open here as there (laps of a real Duckiebot: a dead zone 18 units behind a caster, beaten with 0.7). Every effect that
won no evidence may still hide, alone where nothing was detected or what is missing has no name, else beside the
answer, at sizes that matter, as far as the drives allow (`unseen`). Events happen once; in a new drive they change
nothing. What an effect explains may be of the floor that was driven on (`floor_here`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import (
    catalogue,
    declared_starts,
    has_phase,
    hypotheses_of,
    is_event,
)
from fsm_calib.diagnosis.candidates.ranked import EXACT, Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Prober
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis, kept
from fsm_calib.diagnosis.design.floor_here import floor_instead
from fsm_calib.diagnosis.design.odds import DETECT, log_odds, room_of
from fsm_calib.diagnosis.design.unseen import ANY_PHASE, unseen
from fsm_calib.diagnosis.fitting.base import slot_of
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot
from fsm_calib.diagnosis.fitting.values import switched_off, with_values
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.replay.simulator import NOMINAL_WHEEL_RATE
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.diagnosis.verdict.posterior import TINY
from fsm_calib.diagnosis.verdict.support import RivalGap, Support
from fsm_calib.diagnosis.verdict.systematic_error import model_spread
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import NUISANCE, parameter_table

GENERAL_DOUBT = 0.02  # share of names that are wrong for no visible reason
MOST = 14  # explanations that are kept: those behind have a thousandth of the doubt
LEAST_GAIN = 0.5  # log-likelihood units: a fit that won less found nothing
PRIOR_SPREAD = 0.4  # of a typical size, before anything was driven
FURTHER = 0.1  # odds that an answer lacks an effect, before the drives are asked: most are found
UNNAMED = 0.5  # probability that no name is right, where the diagnosis gives none
PRIOR_BASE = {
    "gain_left": 0.08, "gain_right": 0.08, "axle_length": 0.005, "tau_forward": 0.05, "tau_turn": 0.06,
}  # before anything was driven; m/s, m, s: gains of 32 real robots differ by an eighth (parameters.SPREAD)  # fmt: skip

Weighed = tuple[float, Hypothesis]
"""Log odds against nothing at all, and the explanation."""


def belief_of(decision: Decision, most: int = MOST) -> Belief:
    """Return what a decision leaves us to believe of the next drive; explanations beyond `most` count as un-named."""
    base, simulator = decision.base, decision.engine.simulators[0]
    lasting = [e for e in decision.asked if not is_event(e)]
    weighed = [(0.0, _nothing(base)), *_something(decision, lasting)]
    top = max(odds for odds, _ in weighed)
    everything = [replace(h, probability=math.exp(odds - top)) for odds, h in weighed]
    hypotheses = kept(everything, most)
    total = sum(h.probability for h in hypotheses)
    behind = 1.0 - total / sum(h.probability for h in everything)
    doubt = UNNAMED if decision.outcome == "unexplained" else GENERAL_DOUBT
    frames = float(np.median([s.prepared.geometry[2] for s in decision.engine.simulators]))
    return Belief(
        hypotheses=tuple(replace(h, probability=h.probability / total) for h in hypotheses),
        base=len(lasting_slots(base)),
        plain=base.values[0],
        noise=decision.model.fit.noise,
        robot=simulator.prepared.recording.robot,
        frame_rate=1.0 / max(frames, 1e-3),
        full_speed=simulator.full_speed,
        unnamed=1.0 - (1.0 - doubt) * (1.0 - behind),
    )


def prior_belief(
    noise: Noise | None = None,
    robot: RobotFacts | None = None,
    frame_rate: float = 15.0,
    without: Collection[str] = (),
) -> Belief:
    """Return what is believed of a robot that has not been driven: nothing missing, or one effect of typical size.

    without : effects that the robot is known not to have.
    """
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
        e
        for e in catalogue(without)
        if not is_event(e) and e.input in ("any", "command") and e.scan != "place"
    ]
    for effect in effects:
        values = with_values(plain[None], declared_starts(next(hypotheses_of(effect, 1)))[0])[0]
        own, sizes = _own_slots(effect, values)
        covariance = np.zeros((len(slots) + len(own),) * 2)
        covariance[: len(slots), : len(slots)] = spread
        covariance[range(len(slots), len(covariance)), range(len(slots), len(covariance))] = sizes**2
        places = tuple(s.place for s in (*slots, *own))
        hypotheses.append(
            Hypothesis(
                (effect.name,), 0.5 / len(effects), values, places, covariance, _steps((*slots, *own)), DETECT
            )
        )
    return Belief(
        kept(hypotheses, len(hypotheses)),
        len(slots),
        plain,
        noise or Noise(),
        facts,
        frame_rate,
        full,
        GENERAL_DOUBT,
    )


def _own_slots(effect: Effect, values: FloatArray) -> tuple[list[Slot], FloatArray]:
    """Return the strengths that a typical effect moves, and their spread before anything was driven."""
    own = [slot_of(f"{effect.name}.{name}") for name in effect.strengths if effect.parameter(name).fitted][:2]
    sizes = [PRIOR_SPREAD * effect.parameter(name).typical_size
             for name in effect.strengths if effect.parameter(name).fitted][:2]  # fmt: skip
    return own, np.array(sizes)


def _steps(slots: Sequence[Slot]) -> FloatArray:
    return np.array([s.step for s in slots])


def _nothing(base: Fit) -> Hypothesis:
    slots = lasting_slots(base)
    places = tuple(s.place for s in slots)
    return Hypothesis((), 1.0, base.values[0], places, _spread(base, slots, ()), _steps(slots))


def lasting_slots(base: Fit) -> tuple[Slot, ...]:
    """Return the numbers of the base robot that a new drive has as well: a battery's charge is of one drive."""
    owner = parameter_table().owner
    return tuple(s for s in base.slots if s.run == ALL_RUNS or owner[s.place])


def _something(decision: Decision, lasting: Sequence[Effect]) -> list[Weighed]:
    """Return the explanations by which something is missing."""
    if decision.outcome == "match":
        return [*_places(decision, len(lasting)), *_hidden(decision, lasting)]
    fitted = _likeliest([*_singles(decision, len(lasting)), *_several(decision, len(lasting))])
    if decision.outcome == "explained":
        answer = _answer(decision, len(lasting))
        floor = _floor_here(decision, answer, len(lasting))
        return [*_likeliest([answer, *fitted, *floor]), *_hidden_beside(decision, answer, lasting)]
    lasts = {e.name for e in lasting}  # of what happened once, and is not said, a new drive tells nothing
    led = lasts & {name for _, h in fitted for name in h.names if h.room <= 0.0}  # won as much as a name must
    named = [weighed for weighed in fitted if led.issuperset(weighed[1].names)]
    return [*named, *_hidden(decision, [e for e in lasting if e.name not in led])]


def _likeliest(weighed: Sequence[Weighed]) -> list[Weighed]:
    """Return explanations without those that have the names of a likelier one."""
    best: dict[frozenset[str], Weighed] = {}
    for odds, hypothesis in weighed:
        names = frozenset(hypothesis.names)
        if names not in best or odds > best[names][0]:
            best[names] = (odds, hypothesis)
    return list(best.values())


def _singles(decision: Decision, catalogue: int) -> Iterator[Weighed]:
    """Yield every effect that won something by itself."""
    for ranked in decision.ranking:
        if ranked.gain >= LEAST_GAIN:
            yield _weighed(ranked.evidence, ranked.fit, (ranked.name,), decision.base, catalogue)


def _places(decision: Decision, catalogue: int) -> Iterator[Weighed]:
    """Yield places that won something where nothing was detected: by its many looks a scan wins as much by chance."""
    for ranked in decision.ranking:
        if ranked.gain >= LEAST_GAIN and registry()[ranked.name].scan == "place":
            evidence = min(ranked.evidence - DETECT, 0.0)
            yield _weighed(evidence, ranked.fit, (ranked.name,), decision.base, catalogue)


def _told(decision: Decision) -> tuple[Support, ...]:
    """Return the effects of an answer; what may have happened once, but is not said, a new drive does not have."""
    said = {b.name for b in decision.named}
    return tuple(s for s in decision.model.supports if s.name in said or not is_event(registry()[s.name]))


def _answer(decision: Decision, catalogue: int) -> Weighed:
    """Return all effects of an answer together."""
    fit, names = decision.model.fit, tuple(s.name for s in _told(decision))
    total = evidence_of(fit, decision.base, decision.engine.count)
    return _weighed(total, fit, names, decision.base, catalogue)


def _several(decision: Decision, catalogue: int) -> Iterator[Weighed]:
    """Yield an answer of several effects, the same without each of them, and an answer with a rival in a place."""
    told, base = _told(decision), decision.base
    if not told:
        return
    names, answer = tuple(s.name for s in told), _answer(decision, catalogue)
    total = evidence_of(decision.model.fit, base, decision.engine.count)
    if len(decision.model.supports) > 1:
        yield answer
    for i, support in enumerate(told):
        rest = names[:i] + names[i + 1 :]
        if len(rest) > 1:
            yield _weighed(total - support.added.evidence, support.without, rest, base, catalogue)
        for rival in support.rivals:
            by_law, other = _in_place_of(decision, i, rival.name, rival.fit, rival.gap.evidence, catalogue)
            yield max(by_law, answer[0] + _open(support, rival)), other


def _open(support: Support, rival: RivalGap) -> float:
    """Return the log odds of a rival against an effect as the verdict has them: what it says as a set is open."""
    beaten = support.outdoes(rival)
    return math.log(max(1.0 - beaten, TINY) / max(beaten, TINY))


def _floor_here(decision: Decision, answer: Weighed, catalogue: int) -> Iterator[Weighed]:
    """Yield the answer with the floor that was driven on in the place of one of its effects (`floor_here.py`).

    It is not believed in more than the answer: it has no name until a drive has left it.
    """
    for i, support in enumerate(_told(decision)):
        added = support.added.evidence
        for here in floor_instead(decision.engine, support.without, added, decision.asked):
            found, lacks = here.found, added - here.evidence
            odds, hypothesis = _in_place_of(decision, i, found.name, found.fit, lacks, catalogue)
            yield min(odds + here.prior, answer[0]), hypothesis


def _in_place_of(decision: Decision, i: int, name: str, fit: Fit, lacks: float, catalogue: int) -> Weighed:
    """Return an answer with another effect in the place of its `i`-th; `lacks`: evidence, beside the answer's."""
    names = [s.name for s in _told(decision)]
    total = evidence_of(decision.model.fit, decision.base, decision.engine.count)
    return _weighed(total - lacks, fit, (*names[:i], name, *names[i + 1 :]), decision.base, catalogue)


def _weighed(evidence: float, fit: Fit, names: tuple[str, ...], base: Fit, catalogue: int) -> Weighed:
    """Return a fitted explanation with its odds."""
    found = replace(_fitted(fit, names, base), room=room_of(evidence, len(names)))
    return log_odds(evidence, len(names), catalogue), found


def _fitted(fit: Fit, names: tuple[str, ...], base: Fit) -> Hypothesis:
    """Return a fitted explanation as it would act in a new drive."""
    table = parameter_table()
    events = tuple(name for name in names if is_event(registry()[name]))
    values = switched_off(fit.values[:1], events)[0]
    first_runs: dict[int, Slot] = {}
    for slot in fit.slots[len(base.slots) :]:
        if table.owner[slot.place] not in events:
            first_runs.setdefault(slot.place, slot)
    slots = (*lasting_slots(base), *first_runs.values())
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


def _hidden(decision: Decision, effects: Sequence[Effect]) -> Iterator[Weighed]:
    """Yield effects that may still hide on a robot of which nothing is said."""
    fitted = {ranked.name: ranked for ranked in decision.ranking}
    yield from _beside(_nothing(decision.base), decision.bank.prober, fitted, effects)


def _hidden_beside(decision: Decision, answer: Weighed, effects: Sequence[Effect]) -> Iterator[Weighed]:
    """Yield effects that may still hide beside an answer.

    What may only mend it (EXACT) is no evidence of another; and what the diagnosis does not find is not believed in
    more than the answer, so that there is always a drive to tell.
    """
    fit, (odds, known) = decision.model.fit, answer
    bank = Bank.on(decision.engine, fit, distinct=decision.bank.distinct)
    modelled = {s.name for s in decision.model.supports}
    others = [e for e in effects if e.name not in modelled]
    ranked = bank.rank([e for e in others if has_phase(e)])
    inexact = 0.5 * EXACT * max(evidence_of(fit, decision.base, decision.engine.count), 0.0)
    for more, hypothesis in _beside(known, bank.prober, {r.name: r for r in ranked}, others, inexact):
        yield odds + min(math.log(FURTHER) + more, 0.0), hypothesis


def _beside(
    known: Hypothesis,
    prober: Prober,
    fitted: Mapping[str, Ranked],
    effects: Sequence[Effect],
    inexact: float = 0.0,
) -> Iterator[Weighed]:
    """Yield explanations with one effect more, and their log odds over what is known.

    inexact : log-likelihood that an effect may win though there is none.
    """
    for hidden in unseen(prober, known.values, fitted, [e for e in effects if not e.scan]):
        slot, size = slot_of(hidden.parameter), len(known.places)
        covariance = np.zeros((size + 1, size + 1))
        covariance[:size, :size] = known.covariance
        covariance[size, size] = hidden.spread**2
        won = hidden.log_ratio - min(max(hidden.log_ratio, 0.0), inexact)
        yield (
            won - math.log(len(effects)),
            Hypothesis(
                names=(*known.names, hidden.name),
                probability=1.0,
                values=hidden.values,
                places=(*known.places, slot.place),
                covariance=covariance,
                steps=np.append(known.steps, slot.step),
                room=room_of(2.0 * won, 1),
                over=known.names,
            ),
        )
