"""The words a machine is declared in: states, transitions, and a chart of both, all frozen.

A chart is a tree of states. A leaf names its do-activity (`do`): what the runner executes while the leaf is
active. A transition takes the outcome of that activity (`trigger`) to the next state when its guards hold and
none of its `unless` holds, and keeps the books with its `actions`. Paths use `/`: a path inside a chart is
relative to the chart, a path that begins with `/` belongs to the chart around it (the supervisor).

The semantics are those of UML state machines with run-to-completion steps (OMG UML 2.5.1, chapter 14),
without history and without parallel regions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

SEPARATOR = "/"


@dataclass(frozen=True, slots=True)
class State:
    """A state: a leaf with a do-activity, a composite with children, or an end.

    Parameters
    ----------
    name : str
        One word or several with ``_``; no ``/``.
    about : str
        One sentence for a person: what the robot is doing here.
    do : str
        The do-activity of a leaf (`activities`); empty for composites and ends.
    children : tuple of State
        The states inside; the first is entered when the composite is entered.
    reason, cure : str
        For an end that is a failure: what happened and what the operator can do about it.
    chart : Chart or None
        A machine that is the inside of this state; its states and transitions are placed under this state's
        path.
    """

    name: str
    about: str = ""
    do: str = ""
    children: tuple[State, ...] = ()
    reason: str = ""
    cure: str = ""
    chart: Chart | None = None

    @property
    def inside(self) -> tuple[State, ...]:
        """The states directly inside this one."""
        return self.chart.states if self.chart else self.children


@dataclass(frozen=True, slots=True)
class Transition:
    """An edge: in `source`, the outcome `trigger` leads to `dest` when all `guards` and none of `unless`
    hold.

    `dest` None stays in the active leaf, whose activity is then done again. `actions` keep the books.
    """

    trigger: str
    source: str
    dest: str | None
    guards: tuple[str, ...] = ()
    unless: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()

    @property
    def condition(self) -> str:
        """The guards as text: ``a & !b``; empty when the transition is unconditional."""
        return " & ".join([*self.guards, *(f"!{name}" for name in self.unless)])

    @property
    def label(self) -> str:
        """What a diagram writes at the edge: trigger, guards and actions."""
        guarded = f"{self.trigger} [{self.condition}]" if self.condition else self.trigger
        return f"{guarded} / {', '.join(self.actions)}" if self.actions else guarded

    @property
    def ident(self) -> str:
        """A name that no other transition of the chart has: ``source--trigger[guards]->dest``."""
        return f"{self.source}--{self.trigger}[{self.condition}]->{self.dest or '(stay)'}"


@dataclass(frozen=True, slots=True)
class Chart:
    """A machine: its name, a sentence about it, its states (the first is the initial one) and its
    transitions.
    """

    name: str
    about: str
    states: tuple[State, ...]
    transitions: tuple[Transition, ...]

    def walk(self) -> Iterator[tuple[str, State]]:
        """Yield every state of the tree, charts inside included, with its path from the root of this
        chart.
        """
        yield from _walk(self.states, "")

    def all_transitions(self) -> Iterator[Transition]:
        """Yield every transition, those of charts inside included, with paths from the root of this chart."""
        yield from self.transitions
        for path, state in self.walk():
            if state.chart:
                yield from (_placed(edge, path) for edge in state.chart.transitions)


def _walk(states: tuple[State, ...], prefix: str) -> Iterator[tuple[str, State]]:
    for state in states:
        path = f"{prefix}{state.name}"
        yield path, state
        yield from _walk(state.inside, path + SEPARATOR)


def _placed(edge: Transition, prefix: str) -> Transition:
    """Return `edge`, declared in a chart that sits at `prefix`, with paths from the outer root."""
    dest = edge.dest
    if dest is not None:
        dest = dest.removeprefix(SEPARATOR) if dest.startswith(SEPARATOR) else prefix + SEPARATOR + dest
    return replace(edge, source=prefix + SEPARATOR + edge.source, dest=dest)


@dataclass(frozen=True, slots=True)
class Branch:
    """One way out of a choice: when `guard` holds (empty: otherwise), to `dest`, with book-keeping
    `actions`.
    """

    guard: str
    dest: str | None
    actions: tuple[str, ...]


def when(guard: str, dest: str | None, *actions: str) -> Branch:
    """Return the branch that is taken when `guard` holds and no earlier branch of the choice was taken."""
    return Branch(guard, dest, actions)


def otherwise(dest: str | None, *actions: str) -> Branch:
    """Return the branch that is taken when no other one is."""
    return Branch("", dest, actions)


def choose(trigger: str, sources: str | tuple[str, ...], *branches: Branch) -> tuple[Transition, ...]:
    """Return the transitions of an if / else-if / else: exclusive and complete by construction.

    Each branch requires its own guard and excludes the guards of all branches before it, so that the order of
    the resulting transitions does not matter. The last branch must be an `otherwise`.
    """
    rows: list[Transition] = []
    for source in (sources,) if isinstance(sources, str) else sources:
        refused: tuple[str, ...] = ()
        for branch in branches:
            guards = (branch.guard,) if branch.guard else ()
            rows.append(Transition(trigger, source, branch.dest, guards, refused, branch.actions))
            refused += guards
    return tuple(rows)


def always(
    trigger: str, sources: str | tuple[str, ...], dest: str | None, *actions: str
) -> tuple[Transition, ...]:
    """Return the unconditional transitions from each of `sources` on `trigger`."""
    return choose(trigger, sources, otherwise(dest, *actions))
