"""From the frozen table to a running `transitions` machine; the only place that imports the library.

States become nested states whose names are joined by `/`. Every transition is placed at the machine's root
with absolute paths, so that there is one scope only: the library looks at the leaf's transitions first and
then at those of the states around it. Events are queued (run to completion) and carry the outcome's evidence.

Source: the library's documentation, github.com/pytransitions/transitions, "Hierarchical State Machine".
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, cast

from transitions import EventData, MachineError
from transitions.extensions.nesting import HierarchicalMachine, NestedState, NestedTransition

from fsm_calib.statechart.books import Books
from fsm_calib.statechart.machinery import Evidence, Machinery
from fsm_calib.statechart.spec import SEPARATOR, Chart, State, Transition


class SlashState(NestedState):
    """A nested state whose path is written with `/`, so that names may hold `_`."""

    separator = SEPARATOR


class RecordedTransition(NestedTransition):
    """A transition that knows its row in the table and tells its model when it is taken."""

    def __init__(self, *args: Any, ident: str = "", **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.ident = ident

    def execute(self, event: EventData) -> bool:
        """Run the transition; note its place in the table when its guards let it pass."""
        passed = bool(super().execute(event))
        if passed:
            cast(Model, event.model).taken.append(self.ident)
        return passed


class SlashMachine(HierarchicalMachine):
    """The library's hierarchical machine with the two classes above."""

    state_cls = SlashState
    transition_cls = RecordedTransition


def compile_chart(chart: Chart) -> SlashMachine:
    """Return the running machine of `chart`, without a model yet."""
    machine = SlashMachine(
        model=None,
        states=[_state(state) for state in chart.states],
        initial=chart.states[0].name,
        auto_transitions=False,
        queued=True,
        send_event=True,
    )
    for edge in chart.all_transitions():
        machine.add_transition(**_transition(edge))
    return machine


class Model:
    """What the library drives: it holds the state, and what the callbacks read and note.

    `answers` : the guards asked and their answers; `kept` : the bookkeeping done; `taken` : the rows of
    the table that were taken, by ident.
    """

    state: str
    trigger: Callable[..., bool]  # bound by the library

    def __init__(self, machinery: Machinery, books: Books, limits: Any) -> None:
        self.machinery, self.books, self.limits = machinery, books, limits
        self.answers: dict[str, bool] = {}
        self.kept: list[str] = []
        self.taken: list[str] = []

    def dispatch(self, trigger: str, evidence: Evidence) -> bool:
        """Let the machine take `trigger`; return whether a transition was taken. When not, nothing has
        changed.
        """
        self.answers, self.kept, self.taken = {}, [], []
        try:
            self.trigger(trigger, evidence=evidence)
        except MachineError:
            return False
        if self.taken:
            self._count()
        return bool(self.taken)

    def _count(self) -> None:
        """Count the event; it ends every streak that it does not go on with."""
        self.books.ticks += 1
        for book, action in self.machinery.streaks.items():
            if action not in self.kept:
                setattr(self.books, book, 0)


def _state(state: State) -> dict[str, Any]:
    made: dict[str, Any] = {"name": state.name}
    if state.inside:
        made.update(children=[_state(child) for child in state.inside], initial=state.inside[0].name)
    return made


def _transition(edge: Transition) -> dict[str, Any]:
    return {
        "ident": edge.ident,
        "trigger": edge.trigger,
        "source": edge.source,
        "dest": edge.dest,
        "conditions": [_asking(name) for name in edge.guards],
        "unless": [_asking(name) for name in edge.unless],
        "before": [_keeping(name) for name in edge.actions],
    }


def _asking(name: str) -> Callable[[EventData], bool]:
    return partial(_ask, name)


def _ask(name: str, event: EventData) -> bool:
    """Ask the guard `name` and note its answer for the journal."""
    model = cast(Model, event.model)
    answer = model.machinery.guards[name](model.books, model.limits, event.kwargs["evidence"])
    model.answers[name] = answer
    return answer


def _keeping(name: str) -> Callable[[EventData], None]:
    return partial(_keep, name)


def _keep(name: str, event: EventData) -> None:
    """Do the bookkeeping `name`."""
    model = cast(Model, event.model)
    model.machinery.actions[name](model.books, model.limits, event.kwargs["evidence"])
    model.kept.append(name)
