"""A progress bar for a diagnosis, on standard error; plain lines where it is no terminal."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn

from fsm_calib.progress.bar import COMPILES, TerminalBar

OTHER_PARTS = 5  # base robot, what is left, how sure, place and moment, proof


class DiagnosisProgress(TerminalBar):
    """Shows which part is worked on; each further round over the catalogue makes the whole longer.

    Parameters
    ----------
    effects : int
        How many effects the catalogue holds.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, effects: int, console: Console | None = None) -> None:
        columns = (SpinnerColumn(), BarColumn(bar_width=28), TimeElapsedColumn())
        super().__init__(*columns, TextColumn("{task.description}"), console=console)
        self._effects, self._seen = effects, set[str]()
        self._task = self._progress.add_task(f"reading {COMPILES}", total=effects + OTHER_PARTS + 1)

    @property
    def share(self) -> float:
        """How much of what is known to be done has been done [1]."""
        task = self._progress.tasks[self._task]
        return float(task.completed / (task.total or 1.0))

    def part(self, name: str) -> None:
        """Say which part begins; a name that comes again begins another round."""
        if name in self._seen:
            self._seen.clear()
            total = (self._progress.tasks[self._task].total or 0.0) + self._effects
            self._progress.update(self._task, total=total)
        self._seen.add(name)
        self._progress.update(self._task, advance=1, description=name)
