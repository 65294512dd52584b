"""Rivals of a number of the base robot: effects of which one may do its job by itself, ranked once on each fit.

The numbers of a base robot are asked about one after the other, mostly on the same base, and what is ranked on it
at last, the catalogue, are the same effects again: a robot whose drives began with unequal charges was asked for all
of them twice, a third of the time that its diagnosis took.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field, replace

from fsm_calib.diagnosis.candidates.asked import Distinct
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.world2d.effects import Effect


@dataclass(eq=False)
class Banks:
    """The bank of the fit that was asked last, with what it answered."""

    _last: Bank | None = field(default=None, init=False, repr=False)

    def on(self, engine: Engine, parent: Fit, distinct: Distinct | None = None) -> Bank:
        """Return the bank on a fit, the same if that was asked last; what it knows of starts is in `distinct`, too."""
        if self._last is None or self._last.parent is not parent:
            self._last = Bank.on(engine, parent, distinct=distinct)
        elif distinct is not None:
            distinct.update(self._last.distinct)
            self._last = replace(self._last, distinct=distinct)
        return self._last


@dataclass(frozen=True, eq=False)
class Rivals:
    """Effects that are asked whether one does as well by itself."""

    effects: Sequence[Effect]
    banks: Banks = field(default_factory=Banks)

    def ranked_on(self, engine: Engine, base: Fit) -> list[Ranked]:
        """Return them on top of a base, most evidence first."""
        return self.banks.on(engine, base).rank(self.effects)

    def among(self, names: Container[str]) -> Rivals:
        """Return those that have one of some names."""
        return Rivals([effect for effect in self.effects if effect.name in names], self.banks)
