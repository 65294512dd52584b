"""What every progress bar of the command line shares: standard error, drawn only where a person looks at it."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import Progress, ProgressColumn

COMPILES = "(a first run compiles, too)"
"""Said beside the first part of the work, which takes so much longer on a new installation."""


class TerminalBar:
    """A bar of one task that is drawn on a terminal and wiped when its work ends.

    Parameters
    ----------
    columns : rich.progress.ProgressColumn
        What the bar shows, from left to right.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, *columns: ProgressColumn, console: Console | None = None) -> None:
        self._console = console or Console(stderr=True)
        self._progress = Progress(*columns, console=self._console, transient=True)

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
