"""Lets a fleet end cleanly when it is asked to: workers are ended, rows and half-done robots stay on disk."""

from __future__ import annotations

from contextlib import AbstractContextManager

from fsm_calib.stops import on_stop_signals


def interrupted_by_signals() -> AbstractContextManager[None]:
    """Turn stop signals into `KeyboardInterrupt` inside the `with` block, in the main thread.

    It is no `Exception`, so that a robot that runs in this process ends without a row and is taken up again
    at its last event.
    """
    return on_stop_signals(KeyboardInterrupt)
