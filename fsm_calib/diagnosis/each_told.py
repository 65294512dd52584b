"""What is done to each recording as it is taken in, and told in a sentence where anything was."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from fsm_calib.recording.recording import Recording
from fsm_calib.workers import each


def each_told(
    change: Callable[[Recording], tuple[Recording, str]], recordings: Iterable[Recording], processes: int = 1
) -> tuple[list[Recording], list[str]]:
    """Return the changed recordings, and the sentences of those that something was done to.

    processes : so many work side by side.
    """
    found = each(change, recordings, processes)
    return [recording for recording, _ in found], [said for _, said in found if said]
