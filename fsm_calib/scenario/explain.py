"""Makes sentences of what pydantic found wrong: place, found, expected, the nearest name."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from fsm_calib.errors import InputError, ManyErrors, UnknownNameError, nearest_names
from fsm_calib.scenario.yaml_source import YamlDocument

Location = Sequence[str | int]
SHOWN_CHARACTERS = 60
"""A wrong value is quoted up to this length."""


def input_error(error: ValidationError, document: YamlDocument, model: type[BaseModel]) -> InputError:
    """Return every error of a validation as one, in the order of the file."""
    details = error.errors(include_url=False)
    found = [_one(one, document, model) for one in details if not _follows(one, details)]
    found.sort(key=_line_column)
    return found[0] if len(found) == 1 else ManyErrors(found)


def _follows(one: Any, others: Sequence[Any]) -> bool:
    """Tell whether a "too short" only says that items inside were wrong, which is told by itself."""
    path = one["loc"]
    return one["type"] == "too_short" and any(
        len(other["loc"]) > len(path) and other["loc"][: len(path)] == path for other in others
    )


def _line_column(error: InputError) -> tuple[int, ...]:
    """Return the place of an error as numbers, for sorting."""
    parts = getattr(error, "where", "").rsplit(":", 2)[1:]
    return tuple(int(part) for part in parts if part.isdigit())


def _one(details: Any, document: YamlDocument, model: type[BaseModel]) -> InputError:
    """Return one error as a sentence with its place."""
    path: Location = details["loc"]
    name = dotted(path)
    kind = details["type"]
    if kind == "extra_forbidden":
        where = document.where(path, key=True)
        what = f"{dotted(path[:-1])} setting" if path[:-1] else "setting"
        return UnknownNameError(what, str(path[-1]), known_names(model, path[:-1]), where=where)
    where = document.where(path)
    if kind == "missing":
        return InputError(f"the setting {name!r} is missing", where=where, cure="Add it.")
    if kind == "union_tag_invalid":
        known = [part.strip(" '") for part in details["ctx"]["expected_tags"].split(",")]
        where = document.where([*path, "kind"])
        return UnknownNameError(f"kind of {name}", details["ctx"]["tag"], known, where=where)
    if kind == "union_tag_not_found":
        return InputError(f"{name} has no 'kind'", where=where, cure="Say which kind it is.")
    if kind in ("literal_error", "enum"):
        expected = [part.strip(" '\"") for part in details["ctx"]["expected"].replace(" or ", ",").split(",")]
        problem = f"{name} is {quoted(details['input'])}"
        return InputError(problem, where=where, cure=nearest_names(str(details["input"]), expected))
    if kind == "unbuildable":
        ctx = details["ctx"]
        return InputError(
            ctx["problem"], where=document.where([*path, *ctx["field"].split(".")]), cure=ctx["cure"]
        )
    problem = details["msg"].removeprefix("Value error, ").rstrip(".")
    return InputError(
        f"{name}: {problem[:1].lower()}{problem[1:]}, got {quoted(details['input'])}", where=where
    )


def quoted(value: Any) -> str:
    """Return a value as text of bounded length."""
    text = repr(value)
    return text if len(text) <= SHOWN_CHARACTERS else text[: SHOWN_CHARACTERS - 3] + "..."


def dotted(path: Location) -> str:
    """Return a location as `robot.camera.fx` or `faults[1].side`."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.lstrip(".") or "the file"


def known_names(model: Any, path: Location) -> tuple[str, ...]:
    """Return the names that may stand at `path` inside `model`."""
    models = list(_models(model))
    for part in path:
        models = [inner for outer in models for inner in _step(outer, part)]
    return tuple(dict.fromkeys(name for one in models for name in one.model_fields))


def _step(model: type[BaseModel], part: str | int) -> Iterable[type[BaseModel]]:
    """Return the models below `part` of `model`; an index or a union's tag stays where it is."""
    if isinstance(part, str) and part in model.model_fields:
        return _models(model.model_fields[part].annotation)
    return (model,) if isinstance(part, int) or _has_tag(model, part) else ()


def _has_tag(model: type[BaseModel], tag: str) -> bool:
    """Tell whether a union names `model` by `tag` (its literal `kind`)."""
    kind = model.model_fields.get("kind")
    return kind is not None and tag in typing.get_args(kind.annotation)


def _models(hint: Any) -> Iterator[type[BaseModel]]:
    """Yield the models inside a type hint."""
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        yield hint
    for part in typing.get_args(hint):
        yield from _models(part)
