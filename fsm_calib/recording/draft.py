"""The first draft of a manifest, with its guesses and comments: of a bag's topics or of tables' columns."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.column_guesses import TIMES, Guess, guessed, plain
from fsm_calib.recording.csv_table import header_of
from fsm_calib.recording.manifest_schema import FORMAT

ROBOT = """robot:
  name: robot                 # the same in all recordings of one robot
  # wheel_radius: 0.0318      # m
  # axle_length: 0.1          # m, between the wheels' middles
  # max_wheel_rate: 20.0      # rad/s at command 1, for normalized commands
  # urdf: robot.urdf          # or a file that says the first two
"""


ROBOTS = (
    "robot",
    "robotid",
    "robotname",
    "name",
    "id",
    "body",
    "rigidbody",
    "vehicle",
    "agent",
    "object",
    "subject",
)
"""What people call the column that says whose row it is."""
SEVERAL = "  # several robots in it? add to its channels: only: {{{column}: NAME}}"
UNKNOWN = "  # no time, or no column that is known by its name"
"""What a draft says of a table of which it can make nothing."""
MOVES = frozenset(("command", "wheel_angle", "wheel_rate", "wheel_speed"))
SEES = frozenset(("pose", "yaw_rate", "displacement"))
MISSING = (
    (
        MOVES,
        "  # no commands and no wheels are known by their names; if columns hold them, one of these:\n"
        "  # command: {{file: {file}, time: COLUMN, left: COLUMN, right: COLUMN, unit: normalized}}\n"
        "  # command: {{file: {file}, time: COLUMN, v: COLUMN, omega: COLUMN, unit: twist}}",
    ),
    (
        SEES,
        "  # no poses are known by their names; if columns hold them:\n"
        "  # pose: {{file: {file}, time: COLUMN, x: COLUMN, y: COLUMN, theta: COLUMN}}",
    ),
)
"""Channels of which a robot's identification needs one, and what a draft says that found none of them."""


def draft_of_tables(paths: Sequence[Path], beside: Path) -> str:
    """Return a manifest of CSV files whose names count from the folder `beside`.

    Raises
    ------
    InputError
        A file cannot be read, or none holds a channel that is known by its columns' names.
    """
    lines, seen, doubtful = [f"format: {FORMAT}", ROBOT + "channels:"], set(), ""
    for path in paths:
        header = header_of(path)
        file = str(path.relative_to(beside)) if path.is_relative_to(beside) else str(path.resolve())
        lines.append(f"  # {file}: {', '.join(header)}")
        guesses = guessed(file, header)
        for guess in guesses:
            lines += _section(guess, comment=guess.channel in seen)
            seen.add(guess.channel)
        several = next((name for name in header if plain(name)[0] in ROBOTS), None)
        lines += [SEVERAL.format(column=_quoted(several))] if several else []
        lines += _left_over(header, guesses) if guesses else [UNKNOWN]
        doubtful = file if not guesses else doubtful or file
    if not seen:
        raise _nothing_known(paths[0])
    lines += [said.format(file=_quoted(doubtful)) for wanted, said in MISSING if not seen & wanted]
    return "\n".join(lines) + "\n"


def _left_over(header: Sequence[str], guesses: Sequence[Guess]) -> list[str]:
    """Return a line with the columns that no guess reads."""
    read = [name for guess in guesses for value in guess.section.values() for name in _listed(value)]
    rest = [name for name in header if name not in read]
    return [f"  # not read: {', '.join(rest)}"] if rest else []


def _listed(value: object) -> Sequence[object]:
    """Return a value of a section as the names that it may hold: a quaternion has four."""
    return value if isinstance(value, list) else [value]


def _nothing_known(path: Path) -> InputError:
    """Return the error for a table of which no column is known: what it has, and what a table needs."""
    header = header_of(path)
    timed = any(plain(name)[0] in TIMES for name in header)
    problem = "beside the time no column is known by its name" if timed else "no column is a time by its name"
    return InputError(
        f"{problem}: {', '.join(header)}",
        where=str(path),
        cure="A table needs a time, and x, y or left, right or v, omega: rename columns in the header line, or write "
        "the manifest by hand (docs/recordings.md).",
    )


def draft_of_bag(path: Path, beside: Path) -> str:
    """Return a manifest over a bag: what is found without one, and the other topics as comments.

    Raises
    ------
    InputError
        The bag cannot be read.
    """
    # bags need a heavy library that tables do not
    from fsm_calib.recording.bag_topics import read_topics
    from fsm_calib.recording.bags import topics_used

    topics, _ = read_topics(path)
    used, doubts = topics_used(topics, str(path))
    file = str(path.relative_to(beside)) if path.is_relative_to(beside) else str(path.resolve())
    lines = [f"format: {FORMAT}", f"bag: {_quoted(file)}", ROBOT + "channels:"]
    names = {"wheels": "wheel_angle"}
    for channel, topic in used.items():
        lines.append(f"  {names.get(channel, channel)}: {{topic: {_quoted(topic.name)}}}   # {topic}")
    lines += [f"  # {line}" for doubt in doubts for line in doubt.splitlines()]
    taken = {topic.name for topic in used.values()}
    lines += [f"  # not read: {topic}" for name, topic in sorted(topics.items()) if name not in taken]
    return "\n".join(lines if used else [*lines[:-1], "channels: {}", lines[-1]]) + "\n"


def _section(guess: Guess, comment: bool) -> list[str]:
    """Return a channel as one line of YAML, commented out where the channel was found already."""
    words = ", ".join(f"{key}: {_quoted(value)}" for key, value in guess.section.items())
    mark = "  # or: " if comment else "  "
    return [f"{mark}{guess.channel}: {{{words}}}", *(f"  # assumed: {said}" for said in guess.assumed)]


def _quoted(value: object) -> str:
    """Return a value as YAML writes it in one line: JSON is YAML."""
    return json.dumps(value, ensure_ascii=False)
