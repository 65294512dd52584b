"""YAML read without surprises, with the place of every value.

PyYAML follows YAML 1.1, where `on` is true, `1e-3` a string, `010` is eight and the last of two equal keys
wins. Here plain scalars follow the YAML 1.2 core schema (https://yaml.org/spec/1.2.2/, section 10.3.2), a
repeated key is an error, keys are strings, and every value can be traced back to its line and column.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from fsm_calib.errors import InputError, ManyErrors

MAX_BYTES = 4_000_000
"""A file larger than this [bytes] is no scenario: refused before it is parsed."""
MAX_VALUES = 200_000
"""More values than this after aliases are expanded are refused (an alias bomb)."""

CORE_SCHEMA: tuple[tuple[str, Callable[[str], Any]], ...] = (
    (r"~|null|Null|NULL|", lambda text: None),
    (r"true|True|TRUE", lambda text: True),
    (r"false|False|FALSE", lambda text: False),
    (r"[-+]?[0-9]+", int),
    (r"0o[0-7]+", lambda text: int(text[2:], 8)),
    (r"0x[0-9a-fA-F]+", lambda text: int(text[2:], 16)),
    (r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", float),
    (r"[-+]?\.(inf|Inf|INF)", lambda text: float(text.replace(".", ""))),
    (r"\.(nan|NaN|NAN)", lambda text: float("nan")),
)
"""YAML 1.2 core schema: pattern of a plain scalar and what it means; anything else is text."""

PATTERNS = tuple((re.compile(rf"(?:{pattern})\Z"), convert) for pattern, convert in CORE_SCHEMA)
PLAIN_TAGS = frozenset({"!", *(f"tag:yaml.org,2002:{kind}" for kind in ("str", "seq", "map"))})
"""What untagged values carry; any other tag would ask the reader to build something."""
MAX_DIGITS = 400
"""A number with more characters than this is refused: no setting needs it and `int` is slow on it."""


class _PlainLoader(yaml.SafeLoader):
    """A loader that resolves nothing: scalars keep their text and their style."""

    yaml_implicit_resolvers: dict = {}  # noqa: RUF012 - declared so by the base class


@dataclass(frozen=True)
class YamlDocument:
    """One parsed file.

    Parameters
    ----------
    name : str
        How errors call the file.
    data : object
        Plain Python values: dict with str keys, list, str, int, float, bool, None.
    root : yaml.Node or None
        The tree that remembers places.
    """

    name: str
    data: Any
    root: yaml.Node | None

    def where(self, path: Sequence[str | int] = (), *, key: bool = False) -> str:
        """Return ``file:line:column`` (from 1) of the value at `path`, or of its key.

        Parts of `path` that the file does not hold (a missing field, a union's tag) are skipped, so that the
        nearest enclosing value is named.
        """
        mark = _mark(self.root, path, key)
        return self.name if mark is None else f"{self.name}:{mark.line + 1}:{mark.column + 1}"


def read_yaml(path: str | Path) -> YamlDocument:
    """Read a YAML file.

    Parameters
    ----------
    path : str or Path
        The file, UTF-8.

    Returns
    -------
    YamlDocument

    Raises
    ------
    InputError
        The file cannot be read or is no YAML; `ManyErrors` when several keys are repeated.
    """
    file = Path(path)
    try:
        raw = file.read_bytes()
    except OSError as error:
        cause = error.strerror or "it cannot be read"
        raise InputError(
            f"cannot read the file ({cause})", where=str(path), cure="Check the path."
        ) from error
    if len(raw) > MAX_BYTES:
        raise InputError(f"the file has {len(raw)} bytes, at most {MAX_BYTES} are read", where=str(path))
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            "the file is not UTF-8 text", where=f"{path}:{line}:1", cure="Save it as UTF-8."
        ) from error
    return parse_yaml(text, str(path))


def parse_yaml(text: str, name: str = "<text>") -> YamlDocument:
    """Parse YAML text; see `read_yaml` for the errors. `name` stands for the file in errors."""
    try:
        root = yaml.compose(text, Loader=_PlainLoader)
    except yaml.MarkedYAMLError as error:
        raise _syntax_error(error, name) from error
    except yaml.YAMLError as error:
        raise InputError(f"not YAML: {' '.join(str(error).split())}", where=name) from error
    except RecursionError as error:
        raise InputError("values are nested too deeply", where=name) from error
    if root is None:
        return YamlDocument(name, None, None)
    builder = _Builder(name)
    try:
        data = builder.value(root)
    except RecursionError as error:
        raise InputError("values are nested too deeply", where=name) from error
    if builder.errors:
        raise builder.errors[0] if len(builder.errors) == 1 else ManyErrors(builder.errors)
    return YamlDocument(name, data, root)


class _Builder:
    """Turns a tree into plain values and collects what is wrong on the way."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.errors: list[InputError] = []
        self.open: set[int] = set()
        self.values = 0

    def value(self, node: yaml.Node) -> Any:
        """Return the plain value of `node`."""
        self.values += 1
        if self.values > MAX_VALUES:
            raise InputError(f"more than {MAX_VALUES} values", where=self.place(node))
        if node.tag not in PLAIN_TAGS:
            self.fault(f"the tag {node.tag!r} is not accepted", node, "Remove the tag.")
        if isinstance(node, yaml.ScalarNode):
            return self.scalar(node)
        if id(node) in self.open:
            self.fault("an alias that contains itself", node, "Write the value out.")
            return None
        self.open.add(id(node))
        result = self.sequence(node) if isinstance(node, yaml.SequenceNode) else self.mapping(node)
        self.open.discard(id(node))
        return result

    def scalar(self, node: yaml.ScalarNode) -> Any:
        """Return the value of a scalar: quoted text is text, plain text follows the core schema."""
        if node.style is not None:
            return node.value
        for pattern, convert in PATTERNS:
            if pattern.match(node.value):
                if len(node.value) > MAX_DIGITS:
                    self.fault("a number with too many digits", node, "Round it.")
                    return None
                return convert(node.value)
        return node.value

    def sequence(self, node: yaml.SequenceNode) -> list[Any]:
        """Return the list of a sequence node."""
        return [self.value(child) for child in node.value]

    def mapping(self, node: yaml.Node) -> dict[str, Any]:
        """Return the dict of a mapping node; repeated and non-text keys are errors."""
        result: dict[str, Any] = {}
        first: dict[str, str] = {}
        for key, child in node.value:
            if not isinstance(key, yaml.ScalarNode):
                self.fault("a key that is not text", key, "Write keys as plain words.")
                continue
            if key.value in result:
                cure = f"Keep one of them; the first is at {first[key.value]}."
                self.fault(f"the key {key.value!r} is given twice", key, cure)
            first.setdefault(key.value, self.place(key))
            result[key.value] = self.value(child)
        return result

    def place(self, node: yaml.Node) -> str:
        """Return ``file:line:column`` of `node`."""
        return f"{self.name}:{node.start_mark.line + 1}:{node.start_mark.column + 1}"

    def fault(self, problem: str, node: yaml.Node, cure: str) -> None:
        """Keep one error."""
        self.errors.append(InputError(problem, where=self.place(node), cure=cure))


def _syntax_error(error: yaml.MarkedYAMLError, name: str) -> InputError:
    """Return the parser's complaint as one sentence with its place."""
    mark = error.problem_mark or error.context_mark
    where = name if mark is None else f"{name}:{mark.line + 1}:{mark.column + 1}"
    problem = " ".join(part for part in (error.context, error.problem) if part)
    return InputError(f"not YAML: {problem}", where=where, cure="Check indentation, colons and quotes.")


def _children(node: yaml.Node | None, part: str | int) -> Iterator[tuple[yaml.Node, yaml.Node]]:
    """Yield (key node, value node) of the child called `part`."""
    if isinstance(node, yaml.MappingNode):
        yield from ((key, child) for key, child in node.value if key.value == part)
    elif isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        yield node.value[part], node.value[part]


def _mark(root: yaml.Node | None, path: Sequence[str | int], key: bool) -> Any:
    """Return the mark of the deepest node along `path`."""
    if root is None:
        return None
    node, mark = root, root.start_mark
    for part in path:
        for key_node, child in _children(node, part):
            node, mark = child, (key_node if key else child).start_mark
    return mark
