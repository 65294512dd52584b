"""What effects answered when they were asked on one fit."""

from __future__ import annotations

from dataclasses import dataclass, field

from fsm_calib.diagnosis.candidates.approached import Approached
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked

Distinct = dict[Hypothesis, list[int]]


@dataclass(frozen=True, eq=False)
class Asked:
    """What an effect has begun, which of its forms promise too little, and the starts that are distinct, if new."""

    name: str
    begun: tuple[Ranked, ...]
    left: tuple[Hypothesis, ...]
    distinct: Distinct


@dataclass(eq=False)
class Answers:
    """What each effect began, by name; what came of forms that had promised nothing; fits near their end, and at it."""

    begun: dict[str, Asked] = field(default_factory=dict)
    again: dict[Asked, list[Ranked]] = field(default_factory=dict)
    approached: dict[Ranked, Approached] = field(default_factory=dict)
    followed: dict[Approached, Ranked] = field(default_factory=dict)
