"""Earlier effects asked again when another has joined: whether a rival does better beside it, or another closure.

What led alone may have stood in for a sum. A rival that joins later stands beside what it would have replaced, often
with another equation than it would have there: so it is tried in the earlier one's place alone, too. (A robot's rolling
resistance was a dragging caster with a little dry friction of the motors beside it: 131 log units less than the
resistance alone.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of, strongest
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.verdict.in_its_place import Fitting, on_its_own_ground
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table

RIVALS = 2  # of an earlier effect, asked again beside a new one
NEAR = 0.4  # of its evidence: a rival that had less does not take its place
BETTER = 3.0  # log-likelihood units that make another optimum worth a look


def swapped(
    fitting: Fitting,
    effects: tuple[Ranked, ...],
    fit: Fit,
    rankings: Sequence[Sequence[Ranked]],
) -> tuple[tuple[Ranked, ...], Fit]:
    """Return the effects, the last of which has just joined, and their fit with the rivals that do better.

    rankings : what each round found, the rivals of the effect that won it.
    """
    joining = effects[-1]
    for earlier in effects[:-1]:
        place = next(i for i, e in enumerate(effects) if e is earlier)
        near = _rivals(earlier, place, rankings)
        effects, fit = _with_another(fitting, effects, fit, place, near)
        is_last = effects[-1] is joining  # until it has taken an earlier one's place
        if is_last and _nearly_won(joining.name, effects[place].name, rankings):
            effects, fit = _moved_up(fitting, effects, fit, place, rankings)
    return effects, fit


def _rivals(earlier: Ranked, place: int, rankings: Sequence[Sequence[Ranked]]) -> list[Ranked]:
    """Return what was near an effect in the round that it won, strongest first.

    Effects are sorted by what each adds to the others, rounds by time: a slope of a robot that also drags a caster was
    asked in the place of what had won another round, and a nap that pulls kept its own. An effect that took another's
    place won no round; it has the rivals of the round that its place tells.
    """
    won = rounds_won(earlier.name, rankings)
    found = won[-1] if won else rankings[min(place, len(rankings) - 1)]
    most = won[-1][0].evidence if won else earlier.evidence
    return [r for r in found if r.evidence > NEAR * most]


def rounds_won(winner: str, rankings: Sequence[Sequence[Ranked]]) -> list[Sequence[Ranked]]:
    """Return what the rounds that an effect won had found."""
    return [found for found in rankings if found and found[0].name == winner]


def _with_another(
    fitting: Fitting,
    effects: tuple[Ranked, ...],
    fit: Fit,
    place: int,
    near: Sequence[Ranked],
) -> tuple[tuple[Ranked, ...], Fit]:
    """Return the effects with a rival in a place, or another closure there, where that is better.

    Each is tried in the model as it was given: in one that a rival has entered it would stand beside that rival.
    """
    given, earlier, names = fit, effects[place], {e.name for e in effects}
    rivals = [r for r in near if r.name not in names][:RIVALS]
    rivals += [earlier] if has_closures(registry()[earlier.name]) else []
    if not rivals:
        return effects, fit
    bank = bank_without(fitting.engine, fit, fitting.without(fit, earlier.name))
    for rival in rivals:
        tried = bank.best_of(registry()[rival.name])
        if rival is not earlier:
            tried = strongest(r for r in (tried, on_its_own_ground(bank, rival, given, earlier.name)) if r)
        if tried is not None and is_better(fitting.engine, tried.fit, fit):
            effects = (*effects[:place], replace(tried, evidence=rival.evidence), *effects[place + 1 :])
            fit = tried.fit
    return effects, fit


def _nearly_won(name: str, winner: str, rankings: Sequence[Sequence[Ranked]]) -> bool:
    """Return whether an effect was near in a round that `winner` won."""
    rounds = rounds_won(winner, rankings)
    return any(r.name == name and r.evidence > NEAR * found[0].evidence for found in rounds for r in found)


def _moved_up(
    fitting: Fitting,
    effects: tuple[Ranked, ...],
    fit: Fit,
    place: int,
    rankings: Sequence[Sequence[Ranked]],
) -> tuple[tuple[Ranked, ...], Fit]:
    """Return the effects with the last in an earlier one's place, where it needs no company of that one.

    It is fitted anew, and taken as it was in the round that the earlier one won, where that had all the others: beside
    play in the gears the likelihood has many hills, and which of them a new fit climbs hangs on the last digits.
    """
    earlier, last = effects[place], effects[-1]
    bare = fitting.without(fitting.without(fit, earlier.name), last.name)
    tried = bank_without(fitting.engine, fit, bare).best_of(registry()[last.name])
    kept = {e.name for e in effects if e is not earlier}
    rounds = [r for found in rounds_won(earlier.name, rankings) for r in found if r.name == last.name]
    then = [r for r in rounds if _has(r.fit, kept) and _are_alike_late(r.fit, fit)]
    anew = [] if tried is None else [tried]
    tried = max([*then, *anew], key=lambda r: r.fit.score, default=None)
    if tried is None:
        return effects, fit
    alone = fitting.with_noise(tried.fit)
    if not is_better(fitting.engine, alone, fit):
        return effects, fit
    moved = replace(tried, fit=alone, evidence=earlier.evidence)
    return (*effects[:place], moved, *effects[place + 1 : -1]), alone


def _has(fit: Fit, names: set[str]) -> bool:
    """Return whether a fit has these effects and no others."""
    return set(parameter_table().active_effects(fit.values[0])) == names


def _are_alike_late(one: Fit, other: Fit) -> bool:
    """Return whether both fits have punctual commands, or neither (`verdict/punctual.py`)."""
    return (one.noise.jitter > 0.0) == (other.noise.jitter > 0.0)


def bank_without(engine: Engine, fit: Fit, less: Fit) -> Bank:
    """Return the bank on a fit without an effect; what stays far below the whole fit is not fitted to the end."""
    return Bank.on(engine, less, max(evidence_of(fit, less, engine.count), 0.0))


def is_better(engine: Engine, tried: Fit, fit: Fit) -> bool:
    """Return whether a fit has more evidence than another, by more than optimisers differ."""
    return evidence_of(tried, fit, engine.count) > 2.0 * BETTER


def has_closures(effect: Effect) -> bool:
    """Return whether an effect has several equations of which another may fit better beside other effects."""
    return not effect.scan and len(effect.competing) > 1
