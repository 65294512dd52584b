"""Shows on standard error how far a fleet is: a bar on a terminal, a line per robot elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

from fsm_calib.progress.bar import COMPILES, TerminalBar
from fsm_calib.study.variants import BASE, robot_name

_HOUR = 3600.0


class Foreseen(Protocol):
    """Whoever knows what is left before the first robot has ended."""

    def sentence(self) -> str:
        """Return what is left, and what is worked on."""
        ...


class ForeseenColumn(TextColumn):
    """What is left, asked anew once a second."""

    max_refresh = 1.0

    def __init__(self) -> None:
        super().__init__("{task.description}")
        self.foreseen: Foreseen | None = None

    def render(self, task: Task) -> Text:
        """Return the sentence; the task's own where nobody foresees anything."""
        return Text(self.foreseen.sentence()) if self.foreseen is not None else super().render(task)


class FleetBar(TerminalBar):
    """A watcher that draws one bar over all robots.

    Parameters
    ----------
    named : callable
        How a row is called.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, named: Callable[[dict[str, Any]], str], console: Console | None = None) -> None:
        self._column = ForeseenColumn()
        columns = (BarColumn(bar_width=24), MofNCompleteColumn(), TimeElapsedColumn())
        super().__init__(*columns, self._column, console=console)
        self._named = named
        self._task = self._progress.add_task(f"starting {COMPILES}", total=None)
        self._began, self._ended, self._total, self._done = time.monotonic(), 0, 0, 0

    def begin(self, done: int, total: int, workers: int, foreseen: Foreseen | None = None) -> None:
        """Set the bar to `done` of `total`, and say what is left where somebody foresees it."""
        self._began, self._total, self._done = time.monotonic(), total, done
        self._column.foreseen = foreseen
        self._progress.update(self._task, total=total, completed=done, description=f"{workers} at a time")
        if not self._console.is_terminal or done:
            left = f"; {foreseen.sentence()}" if foreseen is not None else ""
            self._say(f"{done} of {total} robots are there; {workers} at a time{left}")

    def row(self, row: dict[str, Any]) -> None:
        """Move the bar by one robot; a robot with an error is also written as a line that stays."""
        self._ended += 1
        self._done += 1
        pace = self._pace()
        self._progress.update(self._task, completed=self._done, description=pace)
        if "error" in row:
            name = f"{row['error']['name']}: " if "name" in row["error"] else ""
            self._say(f"{self._named(row)}: {name}{row['error']['reason']}")
        elif not self._console.is_terminal:
            self._say(f"[{self._done}/{self._total}] {self._named(row)}  {pace}")

    def death(self, suspects: list[str]) -> None:
        """Write that a worker died."""
        self._say(f"a worker died; taken up again where they were: {', '.join(suspects)}")

    def _pace(self) -> str:
        """Return robots an hour and the minutes left, at the pace of the robots that have ended."""
        rate = self._ended / max(time.monotonic() - self._began, 1e-3)
        return f"{_HOUR * rate:.0f} robots/h, {(self._total - self._done) / rate / 60.0:.0f} min left"

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False)


def studied_name(row: dict[str, Any]) -> str:
    """Return how a row of a study is called: the robot, and the variant when it is not the base."""
    name = robot_name(int(row["robot"]))
    return name if row["variant"] == BASE else f"{row['variant']} {name}"


def real_name(row: dict[str, Any]) -> str:
    """Return how a real robot is called."""
    return str(row["robot"])
