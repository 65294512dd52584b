"""A rig for tests of the machines: put the machine anywhere, fire one outcome, look at everything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsm_calib.machines.books import Books
from fsm_calib.machines.compile import Model, compile_chart
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.spec import Chart
from fsm_calib.machines.supervisor import SUPERVISOR


class Rig:
    """One compiled machine whose state, books and limits a test sets as it likes."""

    def __init__(self, limits: Limits, chart: Chart = SUPERVISOR) -> None:
        self.machine = compile_chart(chart)
        self.model = Model(Books(), limits)
        self.machine.add_model(self.model, initial=chart.states[0].name)

    def put(self, leaf: str, books: Mapping[str, Any]) -> None:
        """Place the machine in `leaf` with the given books, all others as at the start."""
        self.model.books = Books(**{**books, "plan": list(books.get("plan", ()))})
        self.machine.set_state(leaf, self.model)

    def fire(self, trigger: str, evidence: Mapping[str, Any]) -> bool:
        """Dispatch one outcome; whether a transition was taken."""
        return self.model.dispatch(trigger, evidence)

    @property
    def state(self) -> str:
        """The active leaf."""
        return self.model.state
