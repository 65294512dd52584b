"""Opens bags; of ROS 1 also those whose message types hold text constants, such as Duckietown's FSMState.

ROS 1 takes everything behind the ``=`` of a text constant as its value, quotes too, and rosbags takes them off; the
md5 is then another than the bag's, and rosbags refuses the bag. A second pair of quotes keeps the first.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Generator, Sequence
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.typesys.store import Typestore

_QUOTED = re.compile(r'^(\s*string\s+\w+\s*=\s*)("[^"\n]*")\s*$', re.MULTILINE)


class _KeepingReader(Reader1):
    """A reader of ROS 1 bags that keeps the quotes of text constants."""

    def open(self) -> None:
        """Open the bag."""
        super().open()
        self.connections = [_with_quotes(connection) for connection in self.connections]


def _with_quotes(connection: Any) -> Any:
    """Return a connection whose definition has a second pair of quotes about each text constant."""
    definition = connection.msgdef
    text = _QUOTED.sub(r"\1'\2'", definition.data)
    return connection._replace(msgdef=definition._replace(data=text))


class BagReader(AnyReader):
    """`rosbags.highlevel.AnyReader` for bags as robots record them."""

    def __init__(self, paths: Sequence[Path], *, default_typestore: Typestore | None = None) -> None:
        super().__init__(paths, default_typestore=default_typestore)
        if not self.is2:
            self.readers = [_KeepingReader(path) for path in paths]

    def messages(
        self, connections: Collection[Connection] = (), start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield connection, time of recording [ns] and raw message, of all connections or some, from `start` to `stop`.

        Raises
        ------
        ValueError
            A time is no whole number: a table of SQLite takes anything.
        """
        for connection, stamp, raw in super().messages(connections, start, stop):
            if not isinstance(stamp, int):
                raise ValueError(f"the time of a message of {connection.topic} is no whole number")
            yield connection, stamp, raw
