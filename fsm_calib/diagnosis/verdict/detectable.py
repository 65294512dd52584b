"""How small an effect would these recordings have shown? What a match is worth.

An effect of size s changes the simulated increments by dx(s). Whitened, and without what the re-fitted base robot can
take over, it wins |dx(s)|^2 in evidence on average; it would have been seen where that exceeds what detection asks
for, and the price ln N of its one number [N innovations]:

    |dx(s)|^2 >= detect + ln N

dx is simulated, never scaled: a limit above every command shows nothing, though half of its distance from "no limit"
would. An effect that stays below at every size that occurs is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, hypotheses_of, scaled
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.shapes.score_tests import project
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.world2d.effects import Effect

TRIES = 12  # simulations for one effect at most
NEAR_ENOUGH = 1.3  # times the evidence asked for
BEYOND = 1.1  # what a guess is larger than the straight line says, so that it is seen
MOST_GROWTH = 100.0  # of a typical size in one guess


def smallest_sizes(decision: Decision, threshold: float) -> dict[str, tuple[str, float, str]]:
    """Return, for a match, the size of each plain effect that would have been seen: name to (parameter, size, unit).

    threshold : evidence that detection asks for. Effects of a place or a moment are left out: they depend on where.
    """
    wanted = threshold + math.log(decision.engine.count)
    found: dict[str, tuple[str, float, str]] = {}
    for effect in decision.asked:
        if effect.scan:
            continue
        changes = declared_starts(next(hypotheses_of(effect, len(decision.engine.simulators))))[0]
        name = _first_strength(effect, changes)
        if name is None:
            continue
        scale = _smallest_seen(partial(_evidence, decision, effect, changes), wanted)
        if scale is not None:
            size = scaled(effect, changes, scale)[f"{effect.name}.{name}"]
            found[effect.name] = (name, size, effect.parameter(name).unit)
    return found


def _first_strength(effect: Effect, changes: Mapping[str, float]) -> str | None:
    """Return the first strength that `changes` moves off its null value."""
    for name in effect.strengths:
        value = changes.get(f"{effect.name}.{name}")
        if value is not None and value != effect.parameter(name).null:
            return name
    return None


def _evidence(decision: Decision, effect: Effect, changes: Mapping[str, float], scale: float) -> float:
    """Return the evidence that `changes`, scaled, win on average."""
    prober, values = decision.bank.prober, with_values(decision.base.values, scaled(effect, changes, scale))
    x = project(prober.residual, prober.columns(values))[:, 0]
    return float(x @ x)


def _smallest_seen(evidence: Callable[[float], float], wanted: float) -> float | None:
    """Return a scale whose evidence is `wanted` or little more; None where no tried one reaches it.

    Guesses follow a square law from the last scale that was tried, inside the bracket of one that is not seen and one
    that is.
    """
    unseen, seen, scale = 0.0, math.inf, 1.0
    for _ in range(TRIES):
        won = evidence(scale)
        if won >= wanted:
            seen = scale
            if won <= NEAR_ENOUGH * wanted:
                break
        else:
            unseen = scale
        guess = scale * min(BEYOND * math.sqrt(wanted / won), MOST_GROWTH) if won > 0.0 else math.inf
        if not unseen < guess < seen:
            guess = 0.5 * (unseen + seen) if seen < math.inf else MOST_GROWTH * scale
        scale = guess
    return seen if seen < math.inf else None
