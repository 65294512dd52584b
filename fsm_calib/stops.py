"""Signals by which a person or the system stops a command, from its first moment to its last."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

STOP_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)


class Interrupted(BaseException):
    """A stop signal came while nobody had anything better to do about it than to end.

    It is no `Exception`, so that nothing on the way takes it for a failure of its own.
    """


@contextmanager
def on_stop_signals(raised: Callable[[str], BaseException]) -> Iterator[None]:
    """Raise ``raised(NAME)`` where a stop signal comes inside the `with` block, in the main thread.

    What was ignored before stays ignored: ``nohup`` has its terminal's end ignored. In another thread nothing changes:
    whoever owns the main thread handles its signals.
    """

    def handle(number: int, frame: object) -> None:
        raise raised(signal.Signals(number).name)

    before = {}
    try:
        for number in STOP_SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                before[number] = signal.signal(number, handle)
    except ValueError:  # not the main thread
        pass
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
