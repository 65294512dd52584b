"""YAML with places: plain values, and for each the file, line and column where it stands.

YAML 1.2 numbers (``1e-3`` is a number, ``on`` is a word), no duplicate keys, no tags, no aliases: a manifest
is a flat thing, and what it does not need cannot surprise anybody.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from fsm_calib.errors import InputError
from fsm_calib.recording.csv_table import read_lines

LARGEST_MANIFEST = 100_000  # characters; a manifest has about a thousand
KEY = "(key)"  # appended to a path, it names the place of the key in place of the value's
DEEPEST = 20  # levels of nesting; a manifest has three
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?$")


@dataclass(frozen=True)
class PlacedYaml:
    """`data`: plain dicts, lists, numbers, words, booleans, None; `places`: path of keys ->
    ``file:line:column``.
    """

    data: Any
    places: dict[tuple[str | int, ...], str]
    file: str

    def place(self, path: tuple[str | int, ...]) -> str:
        """Return the place of the value at `path`, or of its nearest parent."""
        while path and path not in self.places:
            path = path[:-1]
        return self.places.get(path, f"{self.file}:1:1")


def read_yaml(path: Path) -> PlacedYaml:
    """Read one YAML document; InputError with file:line:column for whatever is wrong."""
    text = "\n".join(read_lines(path))
    if len(text) > LARGEST_MANIFEST:
        raise InputError(
            f"the file has more than {LARGEST_MANIFEST} characters; no manifest", where=f"{path}:1:1"
        )
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{path}:{mark.line + 1}:{mark.column + 1}" if mark else f"{path}:1:1"
        raise InputError(f"not YAML: {error.problem or error.context}", where=place) from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise InputError(
            "not YAML: a character or a nesting that YAML does not allow", where=f"{path}:1:1"
        ) from error
    places: dict[tuple[str | int, ...], str] = {}
    return PlacedYaml(_plain(path, node, (), places), places, str(path))


def _plain(file: Path, node: yaml.Node | None, path: tuple[str | int, ...], places: dict) -> Any:
    if node is None:
        return None
    place = f"{file}:{node.start_mark.line + 1}:{node.start_mark.column + 1}"
    if len(path) > DEEPEST:
        raise InputError("nested too deeply (an alias that holds itself?)", where=place)
    places[path] = place
    if isinstance(node, yaml.MappingNode):
        return _mapping(file, node, path, places)
    if isinstance(node, yaml.SequenceNode):
        return [_plain(file, item, (*path, i), places) for i, item in enumerate(node.value)]
    return _scalar(node)


def _mapping(file: Path, node: yaml.MappingNode, path: tuple[str | int, ...], places: dict) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key_node, value_node in node.value:
        place = f"{file}:{key_node.start_mark.line + 1}:{key_node.start_mark.column + 1}"
        if not isinstance(key_node, yaml.ScalarNode):
            raise InputError("a key must be a word", where=place)
        key = str(key_node.value)
        if key in result:
            raise InputError(f"key {key!r} occurs twice", where=place)
        result[key] = _plain(file, value_node, (*path, key), places)
        places[(*path, key, KEY)] = place
    return result


def _scalar(node: yaml.Node) -> Any:
    value = str(node.value)
    if getattr(node, "style", None) in ("'", '"', "|", ">"):
        return value
    if value in ("", "~", "null"):
        return None
    if value in ("true", "false"):
        return value == "true"
    if NUMBER.match(value):
        return int(value) if re.fullmatch(r"[-+]?\d{1,18}", value) else float(value)
    return value
