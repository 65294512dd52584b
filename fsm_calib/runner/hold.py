"""One run at a time in a directory: two that write one journal would leave nobody's result."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fsm_calib.errors import InputError

LOCK_NAME = ".running"
"""File whose lock the run holds that is at work in a directory; the lock goes with its process, also by a kill."""


@contextmanager
def held(directory: Path) -> Iterator[None]:
    """Hold a directory for this run until the `with` block ends.

    Raises
    ------
    InputError
        Another run is at work there.
    """
    if not directory.is_dir():  # nothing to hold: whoever goes on says so
        yield
        return
    with (directory / LOCK_NAME).open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            cure = "Wait for it, or give another --out."
            raise InputError(
                "another run is at work in this directory", where=str(directory), cure=cure
            ) from error
        except OSError:  # a file system without locks
            pass
        yield
