"""The answer of a diagnosis, as values; `as_json` is the contract of `diagnose --json`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from fsm_calib.diagnosis.proof.windows import HorizonError
from fsm_calib.diagnosis.verdict.argument import Argument
from fsm_calib.diagnosis.verdict.coverage import Coverage
from fsm_calib.diagnosis.verdict.plain import number

VerdictName = Literal["match", "explained", "unexplained"]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its standard deviation and unit; sd is nan when the data cannot tell."""

    value: float
    sd: float
    unit: str


@dataclass(frozen=True, slots=True)
class NamedEffect:
    """One effect that was left out: how sure, its numbers, a sentence.

    confidence : probability that the name is right, or, where it stands in a set of `Verdict.ambiguous`, that one of
    the set is; phenomenon : what a person would call it; closure : which of its equations fits best; share : of the
    base's squared error over the horizon that it takes away [1].
    """

    name: str
    confidence: float
    parameters: dict[str, Estimate]
    sentence: str
    phenomenon: str = ""
    closure: str = ""
    share: float = math.nan


@dataclass(frozen=True, slots=True)
class Located:
    """Where the mismatch shows; see `locate.Location`."""

    channels: tuple[str, ...] = ()
    when: tuple[tuple[float, float], ...] = ()
    where: dict[str, float] | None = None
    states: tuple[str, ...] = ()
    regime: str = ""
    p_value: float = 1.0


@dataclass(frozen=True, slots=True)
class ErrorTriple:
    """Errors over the horizon: base re-fitted, with the effects, noise alone."""

    before: HorizonError
    after: HorizonError
    floor: HorizonError


@dataclass(frozen=True, slots=True)
class Rival:
    """Another explanation and how much evidence it lacks to the first."""

    name: str
    evidence_gap: float


@dataclass(frozen=True, slots=True)
class Verdict:
    """All that `diagnose` says; unnamed : evidence of forms without a name against the effects (`form_test.py`);
    model : all effects that the improved world has, said or not; drives : what the drives can tell.
    """

    verdict: VerdictName
    effects: tuple[NamedEffect, ...]
    ambiguous: tuple[tuple[str, ...], ...]
    located: Located
    horizon: float
    train: ErrorTriple
    holdout: ErrorTriple | None
    rivals: tuple[Rival, ...]
    next_manoeuvre: str
    reason: str
    base: dict[str, Estimate]
    noise: dict[str, float]
    family: str = ""
    unnamed: dict[str, float] = field(default_factory=dict)
    model: tuple[Argument, ...] = ()
    smallest_seen: dict[str, Estimate] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    drives: Coverage | None = None

    @property
    def unsaid(self) -> tuple[Argument, ...]:
        """The effects that the model has and whose names are too unsure to be said."""
        said = {effect.name for effect in self.effects}
        return tuple(argument for argument in self.model if argument.name not in said)

    def as_json(self) -> dict[str, Any]:
        """Return plain values; numbers that are not finite become null."""
        return {
            "verdict": self.verdict,
            "reason": self.reason,
            "effects": [
                {
                    "name": e.name,
                    "confidence": number(e.confidence),
                    "parameters": _estimates(e.parameters),
                    "sentence": e.sentence,
                    "phenomenon": e.phenomenon,
                    "closure": e.closure,
                    "share": number(e.share),
                }
                for e in self.effects
            ],
            "ambiguous": [list(group) for group in self.ambiguous],
            "family": self.family or None,
            "located": {
                "channels": list(self.located.channels),
                "when": [list(span) for span in self.located.when],
                "where": self.located.where,
                "states": list(self.located.states),
                "regime": self.located.regime,
                "p_value": number(self.located.p_value),
            },
            "fit": {
                "horizon_s": self.horizon,
                "holdout": _triple(self.holdout),
                "train": _triple(self.train),
                "base": _estimates(self.base),
                "noise": {name: number(value) for name, value in self.noise.items()},
            },
            "rivals": [{"name": r.name, "evidence_gap": number(r.evidence_gap)} for r in self.rivals],
            "unnamed": {name: number(value) for name, value in self.unnamed.items()},
            "model": [argument.as_json() for argument in self.model],
            "next_manoeuvre": self.next_manoeuvre,
            "drives": None if self.drives is None else self.drives.as_json(),
            "smallest_seen": _estimates(self.smallest_seen),
            "seconds": number(sum(self.seconds.values())),
            "seconds_by_part": {name: number(value) for name, value in self.seconds.items()},
        }


def _estimates(estimates: dict[str, Estimate]) -> dict[str, Any]:
    return {
        name: {"value": number(e.value), "sd": number(e.sd), "unit": e.unit} for name, e in estimates.items()
    }


def _triple(triple: ErrorTriple | None) -> dict[str, Any] | None:
    if triple is None:
        return None
    rows = {"before": triple.before, "after": triple.after, "floor": triple.floor}
    return {name: {"xy_m": number(e.xy_m), "theta_rad": number(e.theta_rad)} for name, e in rows.items()}
