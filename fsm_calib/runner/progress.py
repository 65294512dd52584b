"""Shows on standard error what each machine is doing: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Any, Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from fsm_calib.outcome import Outcome

LONGEST_STATE = 40
"""Width of the state's path on the bar [characters]."""


class Observer(Protocol):
    """Whoever watches a run."""

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Take note: the machine is in `state` of `phase` after `outcome`, at robot time `time` [s]."""
        ...


class Silent:
    """An observer that shows nothing."""

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Do nothing."""


class ProgressBar:
    """An observer that draws one bar over the phases of the plan.

    Parameters
    ----------
    plan : sequence of str
        The phases to come.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, plan: Sequence[str], console: Console | None = None) -> None:
        self._plan = list(plan)
        self._console = console or Console(stderr=True)
        self._phase = ""
        columns: list[Any] = [
            SpinnerColumn(),
            TextColumn("{task.fields[phase]:<11}"),
            BarColumn(bar_width=24),
        ]
        columns += [TextColumn("{task.fields[time]:7.1f} s simulated"), TimeElapsedColumn()]
        columns += [TextColumn("{task.description}")]
        self._progress = Progress(*columns, console=self._console, transient=True)
        self._task = self._progress.add_task("starting", total=len(self._plan), phase="", time=0.0)

    def __enter__(self) -> Self:
        """Start to draw."""
        if self._console.is_terminal:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the screen clean."""
        if self._console.is_terminal:
            self._progress.stop()

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Move the bar; a change of phase is also written as a line that stays."""
        said = f"{state}: {outcome.sentence or outcome.trigger}" if outcome else state
        if phase != self._phase:
            if phase:
                self._console.print(f"[{time:7.1f} s] {phase}", markup=False, highlight=False)
            self._phase = phase
        done = self._plan.index(phase) if phase in self._plan else self._task_done(state)
        self._progress.update(self._task, completed=done, description=said, phase=phase, time=time)

    def _task_done(self, state: str) -> float:
        """Return how many phases are done outside of any phase."""
        return len(self._plan) if state == "done" else self._progress.tasks[0].completed
