"""A folder for what this program runs again later: nobody else can put a file there, or there is no such folder.

What is kept here is executed (the woven module's compiled code is loaded by a format that can run anything), so
that a folder counts only when it is its user's own with no rights for others (0700), holds nothing of others, and
no folder above it lets others exchange it: each is owned by the user or by root, and is closed to the others'
writing or sticky, as the shared temporary folder is.
"""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

PRIVATE = 0o700
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
ROOT_USER = 0


def cache_home() -> Path | None:
    """Return where caches are wanted: ``FSM_CALIB_CACHE``, else ``$XDG_CACHE_HOME/fsm_calib`` or
    ``~/.cache/fsm_calib``; None where there is no home.
    """
    wanted = os.environ.get("FSM_CALIB_CACHE")
    if wanted:
        return Path(wanted).absolute()
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute() / "fsm_calib"
    except RuntimeError:  # no home
        return None


def private_folder(name: str) -> Path | None:
    """Return the private folder `name` in the cache's home, made if need be; None where there can be none."""
    home = cache_home()
    if home is None:
        return None
    folder = home / name
    try:
        home.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=PRIVATE, exist_ok=True)
        folder = folder.resolve(strict=True)
        if not is_private(folder):
            return None
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return None


def is_private(folder: Path) -> bool:
    """Whether only this user (and root) can write to the folder, to anything in it and to its place in the tree.

    Where a system has no such rights (no user ids), every folder counts.
    """
    if not hasattr(os, "getuid"):
        return True
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or status.st_mode & 0o077:
        return False
    return all(map(_cannot_be_exchanged, folder.parents)) and not any(map(_is_foreign, _below(folder)))


def _cannot_be_exchanged(parent: Path) -> bool:
    """Whether others can rename or remove nothing in a folder that is not their own."""
    status = parent.stat()
    if status.st_uid not in (ROOT_USER, os.getuid()):
        return False
    if status.st_mode & stat.S_ISVTX or not status.st_mode & OTHERS_WRITE:
        return True
    return not status.st_mode & stat.S_IWOTH and _is_group_of_one(status.st_gid)


def _is_group_of_one(group_id: int) -> bool:
    """Whether this user is the group's only member, as in systems that give each user a group."""
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.getuid()), grp.getgrgid(group_id)
    except KeyError:  # no such user or group is known here
        return False
    return (
        group.gr_gid == user.pw_gid and group.gr_name == user.pw_name and set(group.gr_mem) <= {user.pw_name}
    )


def _below(folder: Path) -> Iterator[Path]:
    """Yield everything in the folder and in its folders."""
    for root, folders, files in os.walk(folder):
        yield from (Path(root) / name for name in (*folders, *files))


def _is_foreign(path: Path) -> bool:
    """Whether another user owns the file, or it is a link that leads elsewhere."""
    try:
        status = path.lstat()
    except FileNotFoundError:  # another process of this user just moved it to its name
        return False
    return stat.S_ISLNK(status.st_mode) or status.st_uid != os.getuid()
