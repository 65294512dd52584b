"""Lets a fleet end cleanly when it is asked to: workers are ended, rows and half-done robots stay on disk."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals by which a person or the system stops a command."""


@contextmanager
def interrupted_by_signals() -> Iterator[None]:
    """Turn stop signals into `KeyboardInterrupt` inside the `with` block, in the main thread.

    It is no `Exception`, so that a robot that runs in this process ends without a row and is taken up again
    at its last event.
    """

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt(signal.Signals(number).name)

    before = {number: signal.signal(number, interrupt) for number in STOP_SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
