"""Whoever watches a run: the runner tells, and knows nobody who listens."""

from __future__ import annotations

from typing import Protocol

from fsm_calib.outcome import Outcome


class Observer(Protocol):
    """Whoever watches a run."""

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Take note: the machine is in `state` of `phase` after `outcome`, at robot time `time` [s]."""
        ...


class Silent:
    """An observer that shows nothing."""

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Do nothing."""
