"""What speaks for an effect of the model and against it, said or not: the numbers behind its probability."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.plain import number
from fsm_calib.diagnosis.verdict.support import Support


@dataclass(frozen=True, slots=True)
class Argument:
    """The numbers from which `posterior` makes the probability of a name.

    evidence, spread : what the effect adds to all others, and its standard deviation from second to second; share :
    of what all effects add; left, stands_in : what forms without a name explain beside the model, as a share of the
    evidence, and how much of the effect's job these could do; uneven : how well it could be a patch; replaced, moved
    : as a share, what forms explain better in its place, and what is another law in each drive; jolted : log odds
    against a moment in which the robot is jolted; chance : the odds that chance has it, of a law 1 where its evidence
    may be chance and else 0, of an event how many moments would stand out as far where nothing happened; rivals :
    names in its place, with the evidence that each lacks and its spread. Shares [1], evidence twice a log-likelihood.
    """

    name: str
    closure: str
    confidence: float
    evidence: float
    spread: float
    share: float
    left: float
    stands_in: float
    uneven: float
    replaced: float
    moved: float
    jolted: float
    chance: float
    rivals: tuple[tuple[str, float, float], ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        numbers = {f.name: number(getattr(self, f.name)) for f in fields(self) if f.type == "float"}
        rivals = [
            {"name": name, "evidence_gap": number(lacks), "spread": number(spread)}
            for name, lacks, spread in self.rivals
        ]
        return {"name": self.name, "closure": self.closure, **numbers, "rivals": rivals}


def arguments_of(model: Model) -> tuple[Argument, ...]:
    """Return what speaks for each effect of a model and against it, in its order."""
    return tuple(
        _argument(support, belief.probability)
        for support, belief in zip(model.supports, model.beliefs, strict=True)
    )


def _argument(support: Support, probability: float) -> Argument:
    return Argument(
        name=support.name,
        closure=support.effect.hypothesis.closure,
        confidence=probability,
        evidence=support.added.evidence,
        spread=support.added.spread,
        share=support.share,
        left=support.left,
        stands_in=support.interchangeable,
        uneven=support.patchy,
        replaced=support.replaced,
        moved=support.moved,
        jolted=support.jolted,
        chance=support.by_chance,
        rivals=tuple((r.name, r.gap.evidence, r.gap.spread) for r in support.rivals),
    )
