"""Shows on standard error how far a fleet is: a bar on a terminal, a line per robot elsewhere."""

from __future__ import annotations

import time
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn

from fsm_calib.progress.bar import TerminalBar
from fsm_calib.study.variants import BASE, robot_name

_HOUR = 3600.0


class FleetBar(TerminalBar):
    """A watcher that draws one bar over all robots.

    Parameters
    ----------
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, console: Console | None = None) -> None:
        columns = (BarColumn(bar_width=24), MofNCompleteColumn(), TimeElapsedColumn())
        super().__init__(*columns, TextColumn("{task.description}"), console=console)
        self._task = self._progress.add_task("starting", total=None)
        self._began, self._ended, self._total, self._done = time.monotonic(), 0, 0, 0

    def begin(self, done: int, total: int, workers: int) -> None:
        """Set the bar to `done` of `total`."""
        self._began, self._total, self._done = time.monotonic(), total, done
        self._progress.update(self._task, total=total, completed=done, description=f"{workers} at a time")
        if not self._console.is_terminal or done:
            self._say(f"{done} of {total} robots are there; {workers} at a time")

    def row(self, row: dict[str, Any]) -> None:
        """Move the bar by one robot; a robot with an error is also written as a line that stays."""
        self._ended += 1
        self._done += 1
        rate = self._ended / max(time.monotonic() - self._began, 1e-3)
        left = (self._total - self._done) / rate
        pace = f"{_HOUR * rate:.0f} robots/h, {left / 60.0:.0f} min left"
        self._progress.update(self._task, completed=self._done, description=pace)
        if "error" in row:
            self._say(f"{row_name(row)}: {row['error']['name']}: {row['error']['reason']}")
        elif not self._console.is_terminal:
            self._say(f"[{self._done}/{self._total}] {row_name(row)}  {pace}")

    def death(self, suspects: list[str]) -> None:
        """Write that a worker died."""
        self._say(f"a worker died; taken up again where they were: {', '.join(suspects)}")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False)


def row_name(row: dict[str, Any]) -> str:
    """Return how a row is called: the robot, and the variant when it is not the base."""
    name = robot_name(int(row["robot"]))
    return name if row["variant"] == BASE else f"{row['variant']} {name}"
