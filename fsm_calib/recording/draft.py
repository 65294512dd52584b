"""The first draft of a manifest, with its guesses and comments: of a bag's topics or of tables' columns."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.column_guesses import Guess, guessed, plain
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
UNKNOWN = (
    "  # no time or no column known by its name; if it holds the commands:\n"
    "  # command: {{file: {file}, time: COLUMN, v: COLUMN, omega: COLUMN, unit: twist}}"
)
"""What a draft says of a table of which it can make nothing."""


def draft_of_tables(paths: Sequence[Path], beside: Path) -> str:
    """Return a manifest of CSV files whose names count from the folder `beside`.

    Raises
    ------
    InputError
        A file cannot be read, or none holds a channel that is known by its columns' names.
    """
    lines, seen = [f"format: {FORMAT}", ROBOT + "channels:"], set()
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
        lines += [] if guesses else [UNKNOWN.format(file=_quoted(file))]
    if not seen:
        raise InputError(
            "no column is known by its name; a table needs a time and x, y, or left, right, or v, omega",
            where=str(paths[0]),
            cure="Name the columns in the header line, or write the manifest by hand.",
        )
    return "\n".join(lines) + "\n"


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
