"""Shows on standard error how far a fleet of real robots is."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn

from fsm_calib.progress.bar import TerminalBar


class RobotsBar(TerminalBar):
    """One bar over all robots; a line per robot where nobody looks at a bar.

    Parameters
    ----------
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, console: Console | None = None) -> None:
        columns = (BarColumn(bar_width=24), MofNCompleteColumn(), TimeElapsedColumn())
        super().__init__(*columns, TextColumn("{task.description}"), console=console)
        self._task = self._progress.add_task("starting", total=None)
        self._done, self._total = 0, 0

    def begin(self, done: int, total: int, workers: int) -> None:
        """Set the bar to `done` of `total`."""
        self._done, self._total = done, total
        self._progress.update(self._task, total=total, completed=done, description=f"{workers} at a time")
        if not self._console.is_terminal or done:
            self._say(f"{done} of {total} robots are there; {workers} at a time")

    def row(self, row: dict[str, Any]) -> None:
        """Move the bar by one robot; a robot with an error is also written as a line that stays."""
        self._done += 1
        self._progress.update(self._task, completed=self._done, description=row["robot"])
        if "error" in row:
            self._say(f"{row['robot']}: {row['error']['reason']}")
        elif not self._console.is_terminal:
            self._say(f"[{self._done}/{self._total}] {row['robot']}  {row['seconds']:.1f} s")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False)
