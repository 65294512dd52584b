"""What another user left in the working directory must not steer a command.

Two libraries read settings from whatever directory a command is started in: numba's may name a folder of compiled code,
which is then run, matplotlib's how figures are drawn. In a shared directory another user may have put them there.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from fsm_calib.errors import InputError

READ_UNASKED = (".numba_config.yaml", "matplotlibrc")
"""Files of the working directory that libraries read although nobody named them."""


def refuse_settings_of_others(directory: Path) -> None:
    """Refuse to work in a directory where libraries would read settings that another user can write.

    Raises
    ------
    InputError
        There is such a file.
    """
    for name in READ_UNASKED:
        path = directory / name
        if _is_of_others(path):
            raise InputError(
                "another user can write this file, and a library would read its settings from it",
                where=str(path.absolute()),
                cure="Run the command in a directory of your own.",
            )


def _is_of_others(path: Path) -> bool:
    """Whether there is such a file, or a link to one, that is neither this user's nor root's, or that all may write."""
    if not hasattr(os, "getuid"):
        return False
    try:
        ends = (path.lstat(), path.stat())
    except OSError:  # none, or a link to nowhere: nothing is read
        return False
    return any(end.st_uid not in (0, os.getuid()) for end in ends) or bool(ends[1].st_mode & stat.S_IWOTH)
