"""A progress bar for a diagnosis, on standard error; plain lines where it is no terminal."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

OTHER_PARTS = 4  # base robot, location, what is left, proof


class DiagnosisProgress:
    """Shows which part is worked on.

    Parameters
    ----------
    effects : int
        How many effects the catalogue holds.
    console : rich.console.Console or None
        Where to draw; standard error by default.
    """

    def __init__(self, effects: int, console: Console | None = None) -> None:
        self._console = console or Console(stderr=True)
        self._progress = Progress(
            SpinnerColumn(), BarColumn(bar_width=28), TimeElapsedColumn(), TextColumn("{task.description}"),
            console=self._console, transient=True,
        )  # fmt: skip
        self._task = self._progress.add_task("reading", total=effects + OTHER_PARTS)

    def __enter__(self) -> Self:
        """Start to draw."""
        if self._console.is_terminal:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the line."""
        if self._console.is_terminal:
            self._progress.stop()

    def part(self, name: str) -> None:
        """Say which part begins."""
        if self._console.is_terminal:
            self._progress.update(self._task, advance=1, description=name)
