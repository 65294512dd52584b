"""A progress bar for a diagnosis, on standard error; plain lines where it is no terminal."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn

from fsm_calib.progress.bar import TerminalBar

OTHER_PARTS = 4  # base robot, location, what is left, proof


class DiagnosisProgress(TerminalBar):
    """Shows which part is worked on.

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
        self._task = self._progress.add_task("reading", total=effects + OTHER_PARTS)

    def part(self, name: str) -> None:
        """Say which part begins."""
        if self._console.is_terminal:
            self._progress.update(self._task, advance=1, description=name)
