"""A worker whose command is gone ends at once, and its robot goes on with the next command from its last event.

A command that is killed tells nobody; its local workers then belong to another parent, which is what they look for.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable

LOOK_EVERY = 0.5
"""Time between two looks for the parent [s]."""
ORPHANED = 1
"""Exit code of a worker whose command is gone."""

_watched: set[int] = set()


def end_with(parent: int) -> None:
    """End this process soon after its parent process `parent` has ended; nothing happens in any other process."""
    if parent in _watched or os.getppid() != parent:
        return
    _watched.add(parent)
    threading.Thread(target=watch, args=(parent,), name="orphans", daemon=True).start()


def watch(
    parent: int,
    parent_now: Callable[[], int] = os.getppid,
    end: Callable[[int], object] = os._exit,
    wait: Callable[[float], object] = time.sleep,
) -> None:
    """Look for the parent until it is another one, then end the process without a word: nobody listens."""
    while parent_now() == parent:
        wait(LOOK_EVERY)
    end(ORPHANED)
