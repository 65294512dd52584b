"""Where the wall time of a run goes: each moment is charged to one part, the parts add up."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Parts:
    """A stack of named parts; time is charged to the one on top.

    Parameters
    ----------
    first : str
        The part that runs while no other does.
    clock : callable
        Returns seconds; monotonic.
    """

    def __init__(self, first: str, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._stack = [first]
        self._seconds: defaultdict[str, float] = defaultdict(float)
        self._since = clock()

    def enter(self, part: str) -> None:
        """Begin `part`; the part below pauses."""
        self._charge()
        self._stack.append(part)

    def leave(self) -> None:
        """End the part on top; the one below goes on."""
        self._charge()
        self._stack.pop()

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Charge a `with` block to the part `name`."""
        self.enter(name)
        try:
            yield
        finally:
            self.leave()

    def seconds(self) -> dict[str, float]:
        """Return the seconds [s] of each part so far, longest first."""
        self._charge()
        return dict(sorted(self._seconds.items(), key=lambda item: -item[1]))

    def _charge(self) -> None:
        """Charge the time since the last call to the part on top."""
        now = self._clock()
        self._seconds[self._stack[-1]] += now - self._since
        self._since = now
