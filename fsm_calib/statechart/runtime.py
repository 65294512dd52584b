"""The running machine: where it stands, what to do now, and what an outcome leads to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

from fsm_calib.errors import FsmCalibError, UnknownNameError
from fsm_calib.statechart.books import Books
from fsm_calib.statechart.compile import Model, compile_chart
from fsm_calib.statechart.machinery import Machinery, initial_leaf
from fsm_calib.statechart.validate import check


class Happened(Protocol):
    """What a machine takes: the result of an activity."""

    @property
    def trigger(self) -> str:
        """The fact, as the table declares it."""
        ...

    @property
    def evidence(self) -> Mapping[str, Any]:
        """What guards read and the journal keeps."""
        ...

    @property
    def sentence(self) -> str:
        """One sentence for a person; may be empty."""
        ...

    @property
    def cure(self) -> str:
        """What the operator can do about a failure; may be empty."""
        ...


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


class Machine:
    """A machine at one state, with its books.

    Parameters
    ----------
    machinery : Machinery
        The machine as it is declared.
    limits : object or None
        Budgets and thresholds, of the machinery's own type; its defaults when None.
    plan : iterable of str or None
        The phases to run, a subset of the machinery's, all when None; they run in the order of the root's states.
    books, state : Books, str
        To go on from a checkpoint: the books and the leaf's path; `plan` is then the books'.

    Raises
    ------
    InputError
        When the tables are not sound.
    UnknownNameError
        When a phase or the state is not known.
    """

    def __init__(
        self,
        machinery: Machinery,
        limits: Any = None,
        plan: Iterable[str] | None = None,
        *,
        books: Books | None = None,
        state: str | None = None,
    ) -> None:
        check(machinery)
        self.machinery = machinery
        self.limits = machinery.limits() if limits is None else limits
        planned = _in_order(machinery.phases, machinery.phases if plan is None else plan)
        self.books = machinery.books.for_plan(planned) if books is None else books
        start = _initial(machinery) if state is None else state
        if start not in machinery.leaves:
            raise UnknownNameError("state", start, machinery.leaves)
        self._machine = compile_chart(machinery.root)
        self._model = Model(machinery, self.books, self.limits)
        self._machine.add_model(self._model, initial=start)

    @property
    def state(self) -> str:
        """The path of the active leaf, for instance ``scan/clockwise/collecting``."""
        return self._model.state

    @property
    def activity(self) -> str | None:
        """The name of the do-activity of the active leaf; None when the run has ended."""
        return self.machinery.leaves[self.state].do or None

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
        return self.machinery.declared(self.state)

    @property
    def briefing(self) -> dict[str, Any]:
        """What an activity may know of the machine: the state's path, the limits that are told, and the books."""
        told = {name: getattr(self.limits, name) for name in self.machinery.briefed}
        return {"state": self.state, **told, **self.books.to_dict()}

    def fire(self, outcome: Happened) -> Fired:
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
        if self.machinery.leaves[self.state].reason:
            self.books.failure = asdict(self._failure(source, outcome))
        return Fired(
            outcome.trigger, source, self.state, dict(model.answers), tuple(model.kept), model.taken[0]
        )

    def _failure(self, source: str, outcome: Happened) -> Failure:
        """Return why the run failed: when a budget ended it, the table's reason, else the activity's."""
        leaf, numbers = self.machinery.leaves[self.state], asdict(self.limits) | self.books.to_dict()
        reason = leaf.reason.format(**numbers)
        if self._model.answers:
            return Failure(leaf.name, reason, leaf.cure, source)
        return Failure(leaf.name, outcome.sentence or reason, outcome.cure or leaf.cure, source)


def _in_order(phases: tuple[str, ...], plan: Iterable[str]) -> list[str]:
    wanted = set(plan)
    for name in sorted(wanted - set(phases)):
        raise UnknownNameError("phase", name, phases)
    return [phase for phase in phases if phase in wanted]


def _initial(machinery: Machinery) -> str:
    """Return the leaf in which a run begins."""
    return initial_leaf(machinery.states, machinery.root.states[0].name)
