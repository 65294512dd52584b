"""Sections of a scenario: strict, frozen, and mirrored from the frozen settings of the rooms.

A setting is declared once, in the room that uses it, as a field of a frozen dataclass. `mirror` turns such a
class into a section of the scenario file with the same names, types and defaults, so that a new setting can
be given in a scenario, is checked, and appears in the JSON Schema without being written again.
"""

from __future__ import annotations

import dataclasses
import enum
import inspect
import re
import types
import typing
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator
from pydantic_core import PydanticCustomError

from fsm_calib.errors import InputError


class Section(BaseModel):
    """A part of a scenario: unknown names are errors, values are frozen, numbers are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=False)


class Mirror(Section):
    """A section that mirrors a frozen dataclass of another room."""

    _target: typing.ClassVar[type]

    @model_validator(mode="after")
    def _buildable(self) -> Self:
        """Let the dataclass check its own values."""
        try:
            self.build()
        except InputError as error:
            details = {"problem": error.problem, "cure": error.cure, "field": error.where}
            raise PydanticCustomError("unbuildable", "{problem}", details) from error
        return self

    def build(self, **extra: Any) -> Any:
        """Return the dataclass with these values; `extra` gives the fields that the mirror leaves out."""
        known = {field.name for field in dataclasses.fields(self._target)}
        values = {name: _built(getattr(self, name)) for name in type(self).model_fields if name in known}
        return self._target(**(values | extra))


def mirror(
    target: type, *, skip: Collection[str] = (), kind: str | None = None, **constraints: Mapping[str, Any]
) -> type[Mirror]:
    """Return a section class with the fields of the dataclass `target`.

    Parameters
    ----------
    target : type
        A dataclass; fields may be numbers, text, literals, enums, tuples of these and other dataclasses.
    skip : collection of str
        Fields that a scenario cannot set; they must have defaults.
    kind : str or None
        What the section's `kind` must say, where several kinds may stand in one place.
    **constraints
        By field name: further arguments of `pydantic.Field`, such as ``gt=0``.
    """
    hints = typing.get_type_hints(target)
    texts = field_texts(inspect.getdoc(target) or "")
    fields: dict[str, Any] = {}
    if kind is not None:
        fields["kind"] = (Literal[kind], Field(..., description=f"Which kind it is: `{kind}`."))
    for field in dataclasses.fields(target):
        if field.name in skip or not field.init:
            continue
        details = dict(constraints.get(field.name, {}))
        if field.name in texts:
            details.setdefault("description", texts[field.name])
        fields[field.name] = (_mirrored(hints[field.name]), _field(field, details))
    section = create_model(f"{target.__name__}Section", __base__=Mirror, __doc__=_summary(target), **fields)
    section._target = target
    return section


def field_texts(docstring: str) -> dict[str, str]:
    """Return what a numpy docstring says of each parameter or attribute, on one line each."""
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in docstring.splitlines():
        entry = re.match(r"(\w+(?:, \w+)*) :\s*(.*)$", line)
        if entry:
            names = entry[1].split(", ")
        elif names and line.startswith("    "):
            for name in names:
                texts[name] = f"{texts.get(name, '')} {line.strip()}".strip()
        elif line.strip():
            names = []
    return texts


def _summary(target: type) -> str:
    """Return the first line of a class's docstring."""
    return (inspect.getdoc(target) or target.__name__).splitlines()[0]


def _field(field: dataclasses.Field, details: Mapping[str, Any]) -> Any:
    """Return the pydantic field with the dataclass's default."""
    if field.default_factory is not dataclasses.MISSING:
        factory = field.default_factory
        return Field(default_factory=lambda: _section_value(factory()), **details)
    if field.default is not dataclasses.MISSING:
        return Field(default=_section_value(field.default), **details)
    return Field(..., **details)


def _section_value(value: Any) -> Any:
    """Return a dataclass value as its section, of which nothing counts as given; other values as they are."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inner = {item.name: _section_value(getattr(value, item.name)) for item in dataclasses.fields(value)}
        return mirror_of(type(value)).model_construct(_fields_set=set(), **inner)
    if isinstance(value, tuple):
        return tuple(_section_value(item) for item in value)
    return value


_MIRRORS: dict[type, type[Mirror]] = {}


def mirror_of(target: type) -> type[Mirror]:
    """Return the mirror of `target`, made once."""
    if target not in _MIRRORS:
        _MIRRORS[target] = mirror(target)
    return _MIRRORS[target]


def _mirrored(hint: Any) -> Any:
    """Return a type hint with every dataclass in it replaced by its mirror."""
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return mirror_of(hint)
    arguments = typing.get_args(hint)
    origin = typing.get_origin(hint)
    if not arguments or origin is typing.Literal:
        return hint
    parts = tuple(part if part is Ellipsis else _mirrored(part) for part in arguments)
    if origin in (types.UnionType, typing.Union):
        return typing.Union[parts]  # noqa: UP007 - built from parts
    return origin[parts]


def _built(value: Any) -> Any:
    """Return a section's value as the room wants it: mirrors become dataclasses, lists tuples."""
    if isinstance(value, Mirror):
        return value.build()
    if isinstance(value, enum.Enum | str):
        return value
    if isinstance(value, Mapping):
        return {key: _built(item) for key, item in value.items()}
    if isinstance(value, Sequence):
        return tuple(_built(item) for item in value)
    return value
