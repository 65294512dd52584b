"""A machine on a bench: put it anywhere, let it take one outcome, look at everything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsm_calib.statechart.compile import Model, compile_chart
from fsm_calib.statechart.machinery import Machinery


class Probe:
    """One compiled machine whose state, books and limits are set at will."""

    def __init__(self, machinery: Machinery, limits: Any) -> None:
        self.machinery = machinery
        self.machine = compile_chart(machinery.root)
        self.model = Model(machinery, machinery.books(), limits)
        self.machine.add_model(self.model, initial=machinery.root.states[0].name)

    def put(self, leaf: str, books: Mapping[str, Any]) -> None:
        """Place the machine in `leaf` with the given books, all others as at the start."""
        self.model.books = self.machinery.books(**{**books, "plan": list(books.get("plan", ()))})
        self.machine.set_state(leaf, self.model)

    def fire(self, trigger: str, evidence: Mapping[str, Any]) -> bool:
        """Dispatch one outcome; whether a transition was taken."""
        return self.model.dispatch(trigger, evidence)

    @property
    def state(self) -> str:
        """The active leaf."""
        return self.model.state
