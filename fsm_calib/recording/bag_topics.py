"""The topics of a bag, read on one clock.

Stamps are whole nanoseconds: a message's header where it has one, else when it was recorded. Where the headers of a
topic run on another clock than the recorder (a robot without network time, a simulation), its stamps are moved onto the
recorder's by the median difference, and that is told.
"""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording.bag_reader import BagReader
from fsm_calib.recording.duckietown_messages import typestore
from fsm_calib.recording.recording import Finding
from fsm_calib.recording.ros_messages import POSES, STATES, TURNS, TWISTS, WHEELS
from fsm_calib.recording.topics import Topic

WANTED = frozenset(
    (*POSES, *TWISTS, *WHEELS, *TURNS, *STATES, "WheelsCmdStamped", "AprilTagDetectionArray", "ChannelRow")
)
KNOWN_BESIDE = ("CompressedImage", "CameraInfo")  # read elsewhere, image by image
OTHER_CLOCK = 1_000_000_000  # ns: messages travel faster than this
LONGEST_SAID = 200
"""Characters that are told of what the reader of a damaged bag says."""
Row = tuple[int, int, Any]
"""Header stamp [ns; 0 for none], time of recording [ns], message."""
_TEXT = r"""'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*\""""
_TEXTS = re.compile(
    rf"\w*[(\[{{]((?:{_TEXT})(?:, (?:{_TEXT}))*),?[)\]}}]"
)  # ('a',), ['a', 'b'], KeyError('a')


def read_topics(path: Path) -> tuple[dict[str, Topic], list[Finding]]:
    """Return every topic that may tell of a drive, by name, and what was found about their clocks.

    Raises
    ------
    InputError
        The bag is damaged, cut short or holds no known topic.
    """
    rows: dict[tuple[str, str, str | None], list[Row]] = defaultdict(list)
    try:
        with BagReader([path], default_typestore=typestore()) as reader:
            all_kinds = {c.topic: c.msgtype.split("/")[-1] for c in reader.connections}
            wanted = [c for c in reader.connections if c.msgtype.split("/")[-1] in WANTED]
            for connection, recorded, raw in reader.messages(connections=wanted):
                kind = connection.msgtype.split("/")[-1]
                message = reader.deserialize(raw, connection.msgtype)
                for name, parent, part in _parts(connection.topic, kind, message):
                    rows[name, kind, parent].append((_header_stamp(part), recorded, part))
    except Exception as error:  # a damaged bag can fail anywhere inside its reader
        raise InputError(
            f"the bag is damaged or cut short: {_in_words(error)}",
            where=f"{path}:1",
            cure="Record it again, or repair it with: rosbag reindex",
        ) from error
    if not rows and not any(kind in KNOWN_BESIDE for kind in all_kinds.values()):
        listed = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(all_kinds.items())[:8]) or "none"
        raise InputError(f"the bag holds no topic that tells of a drive; topics: {listed}", where=f"{path}:1")
    topics, findings = {}, []
    for (name, kind, parent), found in rows.items():
        stamped, moved = _on_one_clock(found)
        topics[name] = Topic(name, kind, stamped, parent)
        if moved:
            said = f"the headers of {name} run on another clock; {moved / 1e9:+.3f} s brought them onto the recorder's"
            findings.append(Finding(name, "clocks", said))
    return topics, findings


def _in_words(error: Exception) -> str:
    """Return what an error says, on one line without a full stop; what it shows as a tuple, list or set of texts, or
    as another error, is told as these texts.
    """
    text = " ".join(map(str, error.args)) if str(error) == str(error.args) else str(error)
    text = text[: 10 * LONGEST_SAID]  # a damaged file may be quoted whole
    text = _TEXTS.sub(lambda found: ", ".join(map(_bare, re.findall(_TEXT, found[1]))), text)
    return " ".join(text.split())[:LONGEST_SAID].rstrip(" .,:;") or type(error).__name__


def _bare(quoted: str) -> str:
    """Return a text without its quotes, its backslashes and its full stop."""
    return re.sub(r"\\(.)", r"\1", quoted[1:-1]).rstrip(".")


def _parts(topic: str, kind: str, message: Any) -> list[tuple[str, str | None, Any]]:
    """Return name, parent frame and message of a topic, or of every transform that a message holds."""
    if kind == "TFMessage":
        return [(f"{topic}:{t.child_frame_id}", t.header.frame_id, t) for t in message.transforms]
    return [(topic, None, message)]


def _header_stamp(message: Any) -> int:
    header = getattr(message, "header", None)
    return 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def _on_one_clock(rows: list[Row]) -> tuple[list[tuple[int, Any]], int]:
    """Return (stamp [ns], message) by the recorder's clock, and by how much the headers were moved."""
    late = [recorded - header for header, recorded, _ in rows if header]
    if not late:
        return [(recorded, message) for _, recorded, message in rows], 0
    middle = int(np.median(late))
    moved = middle if abs(middle) > OTHER_CLOCK else 0
    return [(header + moved if header else recorded, message) for header, recorded, message in rows], moved
