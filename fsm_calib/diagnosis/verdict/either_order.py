"""Two effects that explain much alone are one model, in whichever order they are found.

The first takes what it can of what the second does, and where its likelihood is rugged or curved no fit leads back. A
bridge of bipolar transistors on a robot with geared motors and exact encoders (Box2D 3/0): friction of loaded gears
alone had 7,080 units of evidence, with four times the torque that is there, a dead zone on top of it 40; the dead zone
alone 4,810 and the friction on top of that 2,803, 493 more for the same two. So when a second effect is sought, those
that were near the first are also fitted before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.world2d.effects import Effect, registry

NEAR = 0.5  # of the first's evidence alone
ASKED = 2  # of what is so near


class Finding(Protocol):
    """What finds the effects of one robot."""

    @property
    def engine(self) -> Engine:
        """Of its recordings."""
        ...

    @property
    def needed(self) -> float:
        """Evidence that each effect must add to all the others."""
        ...

    def beside(self, effects: Sequence[Ranked]) -> list[Effect]:
        """Return the effects of the catalogue that a robot may have beside some."""
        ...

    def is_told(self, ranked: Ranked) -> bool:
        """Return whether an effect is what its name says and, if it is an event, happened."""
        ...


def the_other_way_round(
    finding: Finding, alone: Sequence[Ranked], found: Sequence[Ranked]
) -> tuple[Ranked, Ranked] | None:
    """Return the first effect and a second as they are where the second comes first; None where no pair is better so.

    alone : what was found on top of the base robot, the first effect first; found : on top of that effect. A pair is
    better by as much evidence as a finding needs. Of what is sought by a scan the place hardly hangs on the order.
    """
    first, engine = alone[0], finding.engine
    if registry()[first.name].scan:
        return None
    joined = {ranked.name: ranked.fit.score for ranked in found}
    free = {effect.name for effect in finding.beside([first]) if not effect.scan}
    near = [r for r in alone[1:] if r.name in free and r.evidence > NEAR * first.evidence]
    best: tuple[Ranked, Ranked] | None = None
    least = 0.5 * finding.needed
    for second in near[:ASKED]:
        pair = Bank.on(engine, second.fit).best_of(registry()[first.name])
        known = max(joined.get(second.name, first.fit.score), first.fit.score)
        if pair is None or pair.fit.score < known + least:
            continue
        both = pair, replace(second, fit=pair.fit, evidence=evidence_of(pair.fit, first.fit, engine.count))
        if all(map(finding.is_told, both)) and (best is None or pair.fit.score > best[0].fit.score):
            best = both
    return best
