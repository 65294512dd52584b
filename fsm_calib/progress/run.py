"""The bar of a run: what each machine is doing."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn

from fsm_calib.outcome import Outcome
from fsm_calib.progress.bar import COMPILES, TerminalBar


class ProgressBar(TerminalBar):
    """An observer that draws one bar over the phases of the plan.

    Parameters
    ----------
    plan : sequence of str
        The phases to come.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, plan: Sequence[str], console: Console | None = None) -> None:
        super().__init__(
            SpinnerColumn(),
            TextColumn("{task.fields[phase]:<11}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[time]:7.1f} s simulated"),
            TimeElapsedColumn(),
            TextColumn("{task.description}"),
            console=console,
        )
        self._plan = list(plan)
        self._phase = ""
        self._task = self._progress.add_task(
            f"starting {COMPILES}", total=len(self._plan), phase="", time=0.0
        )

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
