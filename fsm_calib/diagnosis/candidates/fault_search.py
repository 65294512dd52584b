"""Which motor failed, when and how often? One span in which a wheel's gain is lower, or short ones that stand out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import Candidate
from fsm_calib.diagnosis.candidates.scan_blinks import blinks
from fsm_calib.diagnosis.candidates.scan_spans import alike_spans, gain_cells, likely_span
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.effects.numbered import numbered, starts_in
from fsm_calib.world2d.parameters import parameter_table

BOUNDS = (-0.4, 0.9)  # within which the first guess of a loss lies
SIDES = ("left", "right")


@dataclass(frozen=True, eq=False)
class FaultSearch:
    """The search for motors that fail, on top of one model."""

    effect: Effect
    parent: Fit
    residual: Residual

    def candidates(self, keep: int) -> list[Candidate]:
        """Return at most `keep` spans, most promising first, those alike in every drive, and what blinks in one."""
        spans = [self._span(run, side) for run in self._runs for side in SIDES]
        alike = [self._alike(side) for side in SIDES] if len(self._runs) > 1 else []
        again = [found for run in self._runs for found in self._blinks(run)]
        return [c for some in (spans, alike, again) for c in sorted(some, key=lambda c: -c.promise)[:keep]]

    @property
    def _runs(self) -> range:
        return range(len(self.parent.columns))

    def _gain(self, run: int, side: str) -> FloatArray:
        """Return what a wheel's whole gain does to the increments of a recording, (n, 5)."""
        place = parameter_table().place(f"gain_{side}")
        slot = next(i for i, s in enumerate(self.parent.slots) if s.place == place)
        return np.asarray(float(self.parent.values[0, place]) * self.parent.columns[run][:, :, slot])

    def _span(self, run: int, side: str) -> Candidate:
        """Return the best span of one recording in which one wheel is weaker."""
        span = likely_span(self.residual, run, partial(gain_cells, self.residual, run, self._gain(run, side)))
        loss = {f"loss_{side}": float(np.clip(span.loss, *BOUNDS))}
        return Candidate(self._named(loss, [[span.begin, span.end]]), span.promise, run)

    def _alike(self, side: str) -> Candidate:
        """Return the best span of every recording in which one wheel is weaker, by the same loss in all."""
        each = [partial(gain_cells, self.residual, run, self._gain(run, side)) for run in self._runs]
        spans = alike_spans(self.residual, each)
        loss = {f"{self.effect.name}.loss_{side}": float(np.clip(spans[0].loss, *BOUNDS))}
        own = tuple(self._named({}, [[span.begin, span.end]]) for span in spans)
        return Candidate(loss, sum(span.promise for span in spans), each=own)

    def _blinks(self, run: int) -> Iterator[Candidate]:
        """Yield the short spans of either motor that stand out together in one recording."""
        most = len(starts_in(p.name for p in self.effect.parameters))
        worth = 0.5 * 2 * float(np.log(self.residual.engine.count))
        for side in SIDES:
            cells = partial(gain_cells, self.residual, run, self._gain(run, side))
            found = blinks(self.residual, run, cells, worth, most)
            if found is not None:
                loss = {f"loss_{side}": float(np.clip(found.loss, *BOUNDS))}
                yield Candidate(self._named(loss, found.spans), found.won, run, found.chance)

    def _named(self, losses: Mapping[str, float], spans: FloatArray | list[list[float]]) -> dict[str, float]:
        """Return start values by full name; spans : begin and end [s] of each."""
        times = {
            numbered(name, time): float(value)
            for time, (begin, end) in enumerate(spans, 1)
            for name, value in (("start", begin), ("duration", end - begin))
        }
        return {f"{self.effect.name}.{name}": value for name, value in {**losses, **times}.items()}
