"""Files that a manifest names lie in its folder, or are the user's own and named by their whole path.

A manifest comes with the data of others: what it names is read, and what is wrong in it is quoted. So a relative name
leads nowhere outside the manifest's folder, by ``..`` or by a link, and an absolute one only to what belongs to the
user.
"""

from __future__ import annotations

import os
from pathlib import Path

from fsm_calib.errors import InputError


def named_file(manifest: Path, name: str, where: str) -> Path:
    """Return the file or folder that a manifest names; whether it is there is for its reader to say.

    Raises
    ------
    InputError
        The name leads out of the manifest's folder, or to a file of another user; `where` is the name's place.
    """
    path = manifest.parent / name
    if "\0" in name:
        raise InputError("a file's name holds a zero byte", where=where)
    try:
        target = path.resolve()
        if Path(name).is_absolute():
            _refuse_others(target, name, where)
        elif not target.is_relative_to(manifest.parent.resolve()):
            cure = "Put it beside the manifest, or give the whole path of a file of yours."
            raise InputError(f"{name!r} leads out of the manifest's folder", where=where, cure=cure)
    except (
        OSError,
        RuntimeError,
    ) as error:  # a name too long, a loop of links, a folder that may not be entered
        raise InputError(f"the file {name!r} cannot be reached", where=where) from error
    return path


def _refuse_others(target: Path, name: str, where: str) -> None:
    """Raise InputError for what another user owns; what is not there belongs to nobody."""
    if hasattr(os, "getuid") and target.exists() and target.stat().st_uid != os.getuid():
        cure = "Copy it beside the manifest."
        raise InputError(f"{name!r} belongs to another user", where=where, cure=cure)
