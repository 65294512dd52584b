"""The running machine: where the robot stands in its calibration, what to do now, and what an outcome leads
to.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from typing import Any

from fsm_calib.errors import FsmCalibError, UnknownNameError
from fsm_calib.machines.books import Books
from fsm_calib.machines.compile import Model, compile_chart
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.spec import SEPARATOR, State, Transition
from fsm_calib.machines.supervisor import PHASES, SUPERVISOR
from fsm_calib.outcome import Outcome


class UndeclaredOutcomeError(FsmCalibError):
    """An outcome that the active state does not declare: a fault of the program, not of the robot."""

    def __init__(self, state: str, trigger: str, known: Iterable[str]) -> None:
        self.state, self.trigger, self.known = state, trigger, tuple(sorted(known))
        super().__init__(
            f"in state {state} the outcome {trigger!r} is not declared; "
            f"declared: {', '.join(self.known) or 'none'}."
        )


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a run failed: the failure's name, the reason and the cure, each a sentence, and the state it came
    from.
    """

    name: str
    reason: str
    cure: str
    state: str


@dataclass(frozen=True, slots=True)
class Fired:
    """One event, as the journal keeps it.

    trigger : what happened; source, dest : the active leaf before and after; guards : the guards that were
    asked,
    with their answers; actions : the bookkeeping that was done, in order; transition : the row of the table.
    """

    trigger: str
    source: str
    dest: str
    guards: Mapping[str, bool] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    transition: str = ""


class CalibrationMachine:
    """The supervisor with its machines, at one state, with its books.

    Parameters
    ----------
    limits : Limits
        Budgets and thresholds.
    plan : iterable of str
        The phases to run, a subset of `PHASES`; they run in the paper's order.
    books, state : Books, str
        To go on from a checkpoint: the books and the leaf's path; `plan` is then the books'.

    Raises
    ------
    UnknownNameError
        When a phase or the state is not known.
    """

    def __init__(
        self,
        limits: Limits | None = None,
        plan: Iterable[str] = PHASES,
        *,
        books: Books | None = None,
        state: str | None = None,
    ) -> None:
        self.limits = limits or Limits()
        self.books = Books.for_plan(_in_order(plan)) if books is None else books
        start = SUPERVISOR.states[0].name if state is None else state
        if start not in leaves():
            raise UnknownNameError("state", start, leaves())
        self._machine = compile_chart(SUPERVISOR)
        self._model = Model(self.books, self.limits)
        self._machine.add_model(self._model, initial=start)

    @property
    def state(self) -> str:
        """The path of the active leaf, for instance ``scan/clockwise/collecting``."""
        return self._model.state

    @property
    def activity(self) -> str | None:
        """The name of the do-activity of the active leaf; None when the run has ended."""
        return leaves()[self.state].do or None

    @property
    def is_terminal(self) -> bool:
        """Whether the run has ended: done, aborted or failed."""
        return self.activity is None

    @property
    def failure(self) -> Failure | None:
        """Why the run failed; None when it has not."""
        return Failure(**self.books.failure) if self.books.failure else None

    @property
    def triggers(self) -> tuple[str, ...]:
        """The outcomes that the active leaf declares, those of the states around it included."""
        return declared(self.state)

    @property
    def briefing(self) -> dict[str, Any]:
        """What an activity may know of the machine: the state's path, the number of boards, the phase and the
        counts in the books.
        """
        return {"state": self.state, "boards": self.limits.boards, **self.books.to_dict()}

    def fire(self, outcome: Outcome) -> Fired:
        """Take `outcome` and move on.

        Raises
        ------
        UndeclaredOutcomeError
            When the active leaf does not declare the trigger; nothing has moved then.
        """
        source, model = self.state, self._model
        if outcome.trigger not in self.triggers:
            raise UndeclaredOutcomeError(source, outcome.trigger, self.triggers)
        if not model.dispatch(outcome.trigger, outcome.evidence):
            raise UndeclaredOutcomeError(source, outcome.trigger, self.triggers)
        if leaves()[self.state].reason:
            self.books.failure = asdict(self._failure(source, outcome))
        return Fired(
            outcome.trigger, source, self.state, dict(model.answers), tuple(model.kept), model.taken[0]
        )

    def _failure(self, source: str, outcome: Outcome) -> Failure:
        """Return why the run failed: when a budget ended it, the table's reason, else the activity's."""
        leaf, numbers = leaves()[self.state], asdict(self.limits) | self.books.to_dict()
        reason = leaf.reason.format(**numbers)
        if self._model.answers:
            return Failure(leaf.name, reason, leaf.cure, source)
        return Failure(leaf.name, outcome.sentence or reason, outcome.cure or leaf.cure, source)


def _in_order(plan: Iterable[str]) -> list[str]:
    wanted = set(plan)
    for name in sorted(wanted - set(PHASES)):
        raise UnknownNameError("phase", name, PHASES)
    return [phase for phase in PHASES if phase in wanted]


@cache
def leaves() -> dict[str, State]:
    """Return every leaf of the whole machine by its path."""
    return {path: state for path, state in SUPERVISOR.walk() if not state.inside}


@cache
def _transitions() -> tuple[Transition, ...]:
    """Return every transition of the whole machine."""
    return tuple(SUPERVISOR.all_transitions())


@cache
def declared(state: str) -> tuple[str, ...]:
    """Return the outcomes declared for the leaf `state`, those of the states around it included, sorted."""
    parts = state.split(SEPARATOR)
    around = {SEPARATOR.join(parts[:n]) for n in range(1, len(parts) + 1)}
    return tuple(sorted({edge.trigger for edge in _transitions() if edge.source in around}))
