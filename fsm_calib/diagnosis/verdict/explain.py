"""From a decision to the verdict a person reads: names, numbers with intervals, sets, sentences, the next manoeuvre."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.likelihood.noise import NOISE_NAMES
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Gates
from fsm_calib.diagnosis.proof.heldout import Comparison
from fsm_calib.diagnosis.verdict.argument import arguments_of
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.diagnosis.verdict.detectable import smallest_sizes
from fsm_calib.diagnosis.verdict.posterior import Belief
from fsm_calib.diagnosis.verdict.shares import shares_of
from fsm_calib.diagnosis.verdict.systematic_error import with_doubt
from fsm_calib.diagnosis.verdict.verdict import ErrorTriple, Estimate, Located, NamedEffect, Rival, Verdict
from fsm_calib.diagnosis.verdict.weight import weighed, weight_of
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.effects.numbered import times_in
from fsm_calib.world2d.parameters import parameter_table

MANOEUVRE_MENU = (
    "straights at three speeds both ways, spins at three rates, a slalom, "
    "and the suspected place on two headings"
)


def verdict_of(
    decision: Decision,
    train: Comparison,
    holdout: Comparison | None,
    *,
    horizon: float,
    gates: Gates = DEFAULT_GATES,
) -> Verdict:
    """Put a decision and its proof into the contract's values."""
    sets = ambiguous_sets(decision)
    shares = shares_of(decision.engine, decision.base, decision.model)
    return Verdict(
        verdict=decision.outcome,
        effects=tuple(_named(belief, decision, shares) for belief in decision.named),
        ambiguous=sets,
        located=located(decision),
        horizon=horizon,
        train=ErrorTriple(train.before, train.after, train.floor),
        holdout=None if holdout is None else ErrorTriple(holdout.before, holdout.after, holdout.floor),
        rivals=rivals(decision),
        next_manoeuvre=next_manoeuvre(decision, sets),
        reason=decision.reason,
        base=base_estimates(decision.model.fit),
        noise=dict(zip(NOISE_NAMES, map(float, decision.model.fit.noise.vector()), strict=True)),
        family=family_of(decision),
        unnamed=decision.model.contest.numbers(),
        model=arguments_of(decision.model),
        smallest_seen=_smallest(decision, gates) if decision.outcome == "match" else {},
        seconds=dict(decision.seconds),
    )


def estimates(ranked: Ranked, fit: Fit) -> dict[str, Estimate]:
    """Return the effect's numbers; those that belong to a recording carry its number after the name.

    Of an event those of the recording that shows it best carry none. A choice that was tried, not fitted, is among
    them where it is not the usual one, without a spread.
    """
    table, effect = parameter_table(), registry()[ranked.name]
    chosen = {p.name: float(fit.values[0, table.place(f"{ranked.name}.{p.name}")]) for p in effect.choices}
    found = {
        p.name: Estimate(chosen[p.name], math.nan, p.unit) for p in effect.choices if chosen[p.name] != p.null
    }
    for slot, value, variance in fit.numbers():
        if table.owner[slot.place] != ranked.name:
            continue
        entry = table.entries[slot.place]
        found[entry.name + _tail(ranked, slot.run)] = Estimate(
            value, with_doubt(effect, entry.name, value, variance), entry.unit
        )
    return found


def _tail(ranked: Ranked, run: int) -> str:
    """Return what the name of an effect's number in a recording ends with."""
    return "" if run in (ALL_RUNS, ranked.hypothesis.run) else f"_{run + 1}"


def base_estimates(fit: Fit) -> dict[str, Estimate]:
    """Return the base robot's fitted numbers; those of one recording carry its number after the name."""
    table = parameter_table()
    found = {}
    for slot, value, variance in fit.numbers():
        owner = table.owner[slot.place]
        if not owner or registry()[owner].family == "base":
            spread, unit = math.sqrt(max(variance, 0.0)), table.entries[slot.place].unit
            tail = "" if slot.run == ALL_RUNS else f"_{slot.run + 1}"
            found[table.names[slot.place] + tail] = Estimate(value, spread, unit)
    return found


@dataclass(frozen=True, slots=True)
class _Number:
    """An estimate as it stands in a sentence: with its sign, or as a size with the word that says it."""

    estimate: Estimate

    def __format__(self, words: str) -> str:
        """Return ``-0.03 ± 0.001 m``; with words ``ahead|behind`` of plus and minus ``0.03 ± 0.001 m behind``."""
        value, unit = self.estimate.value, "" if self.estimate.unit == "1" else f" {self.estimate.unit}"
        spread = f" ± {self.estimate.sd:.1g}" if math.isfinite(self.estimate.sd) else ""
        if not words:
            return f"{value:.3g}{spread}{unit}"
        plus, _, minus = words.partition("|")
        return f"{abs(value):.3g}{spread}{unit} {minus if value < 0.0 else plus}"


def sentence(effect: Effect, numbers: dict[str, Estimate], closure: str = "") -> str:
    """Return the sentence of an effect's closure with its numbers; empty: the effect's own."""
    said = {}
    for p in effect.parameters:
        e = numbers.get(p.name) or numbers.get(f"{p.name}_1") or Estimate(p.null, math.nan, p.unit)
        said[p.name] = _Number(e)
    own = effect.closure(closure).sentence if closure else ""
    return (own or effect.sentence).format(**said)


def _sentences(ranked: Ranked, numbers: dict[str, Estimate], fit: Fit) -> str:
    """Return the sentence of an effect; of an event that several recordings have, one for each."""
    effect, closure, runs = registry()[ranked.name], ranked.hypothesis.closure, fit.runs_of(ranked.name)
    if ranked.hypothesis.run == ALL_RUNS or len(runs) == 1:
        told = sentence(effect, numbers, closure)
        alike = bool(closure and effect.closure(closure).alike)
        return f"{told} It began {_moments(ranked, numbers, runs)}." if alike else told
    said = []
    for run in runs:
        tail = _tail(ranked, run)
        own = {p.name: numbers[p.name + tail] for p in effect.parameters if p.name + tail in numbers}
        said.append(f"Recording {run + 1}: {sentence(effect, own, closure)}")
    return " ".join(said)


def _moments(ranked: Ranked, numbers: dict[str, Estimate], runs: Sequence[int]) -> str:
    """Return in words when an event began that came in every recording."""
    begins = [_Number(numbers[f"start{_tail(ranked, run)}"]) for run in runs]
    return ", ".join(f"at {begin} in recording {run + 1}" for run, begin in zip(runs, begins, strict=True))


def _named(belief: Belief, decision: Decision, shares: dict[str, float]) -> NamedEffect:
    """Return an effect with its numbers; one of a set that cannot be told apart is as sure as the whole set."""
    effect = registry()[belief.name]
    weight = weight_of(decision.engine.simulators)
    numbers = weighed(estimates(belief.effect, decision.model.fit), weight)
    return NamedEffect(
        belief.name,
        belief.probability,
        numbers,
        _sentences(belief.effect, numbers, decision.model.fit),
        effect.phenomenon,
        belief.effect.hypothesis.closure,
        shares.get(belief.name, math.nan),
    )


def ambiguous_sets(decision: Decision) -> tuple[tuple[str, ...], ...]:
    """Return the sets of names that the data cannot tell apart, the name that is said first."""
    said = {b.name for b in decision.named}
    sets = ((b.name, *(n for n in b.among[1:] if n not in said)) for b in decision.named)
    return tuple(names for names in sets if len(names) > 1)


def rivals(decision: Decision) -> tuple[Rival, ...]:
    """Return the next five names in the strongest effect's place and the evidence that they lack."""
    if decision.model.supports and decision.model.supports[0].rivals:
        first = decision.model.supports[0]
        return tuple(Rival(r.name, r.gap.evidence) for r in first.rivals)[:5]
    if decision.model.effects:  # none was asked in its place beside the others: as they were alone
        named, led = {e.name for e in decision.model.effects}, decision.ranking[0].evidence
        return tuple(Rival(r.name, led - r.evidence) for r in decision.ranking if r.name not in named)[:5]
    return tuple(Rival(r.name, -r.evidence) for r in decision.ranking)[:5]


def family_of(decision: Decision) -> str:
    """Return the family that an unexplained mismatch resembles most; empty when nothing comes near."""
    if decision.outcome != "unexplained" or not decision.model.effects:
        return ""
    return registry()[decision.model.effects[0].name].family


def next_manoeuvre(decision: Decision, sets: tuple[tuple[str, ...], ...]) -> str:
    """Return the drive that would settle what is open."""
    if sets:
        first, *others = sets[0]
        effect = registry()[first]
        return f"To tell {first} from {' or '.join(others)}: {effect.manoeuvre} ({effect.separates})."
    if decision.outcome == "explained":
        return f"To confirm: {registry()[decision.named[0].name].manoeuvre}."
    if decision.outcome == "unexplained":
        return f"Drive {MANOEUVRE_MENU}, so that what it depends on stands out."
    return f"None is needed; for smaller effects drive longer: {MANOEUVRE_MENU}."


def located(decision: Decision) -> Located:
    """Return the location, made sharper by the named effect's own place and time."""
    place, when = decision.location.where, decision.location.when
    channels = list(decision.location.channels)
    if decision.outcome == "match":
        return Located(p_value=decision.location.p_value)
    for ranked in (b.effect for b in decision.named):
        effect = registry()[ranked.name]
        usual = {p.name: Estimate(p.null, math.nan, p.unit) for p in effect.parameters}
        numbers = usual | estimates(ranked, decision.model.fit)
        channels += [c for c in effect.channels if c == "sensor" and c not in channels]
        if effect.scan == "place":
            size = numbers.get("radius") or Estimate(
                min(numbers["half_x"].value, numbers["half_y"].value), math.nan, "m"
            )
            place = {"x": numbers["x"].value, "y": numbers["y"].value, "radius": size.value}
        if effect.scan == "time":
            spans = [(numbers[b].value, numbers[d].value) for b, d in times_in(ranked.hypothesis.names)]
            when = tuple((round(start, 3), round(start + length, 3)) for start, length in spans)
    channels = channels or list(
        registry()[decision.model.effects[0].name].channels if decision.model.effects else ()
    )
    return Located(
        tuple(channels), when, place, decision.location.states, _regime(decision), decision.location.p_value
    )


def _regime(decision: Decision) -> str:
    if decision.outcome == "explained":
        words = [r.replace("_", " ") for b in decision.named for r in registry()[b.name].regimes]
        return ", ".join(dict.fromkeys(words))
    return decision.location.regime


def _smallest(decision: Decision, gates: Gates) -> dict[str, Estimate]:
    sizes = smallest_sizes(decision, gates.first)
    told = {f"{name}.{p}": Estimate(size, math.nan, unit) for name, (p, size, unit) in sizes.items()}
    return weighed(told, weight_of(decision.engine.simulators))
