"""What a compiled hook is made of: the functions that it calls, the files that hold them, the constants that it uses.

The compiled program keeps machine code on disk; it is the right one only while all of these are unchanged.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

PLAIN = (bool, int, float, complex, str, bytes, tuple, frozenset, type(None))
"""Constants whose value is compiled in."""


def plain_function(function: Any) -> Any:
    """Return the Python function behind a compiled one."""
    return getattr(function, "py_func", function)


def names_in(code: CodeType) -> set[str]:
    """Return the global names and attributes that a piece of code speaks of, those inside it included."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= names_in(constant)
    return names


def functions_of(hooks: Iterable[Callable[..., Any]]) -> list[Any]:
    """Return the Python functions of the hooks and of all compiled functions that they call, each once."""
    found: dict[int, Any] = {}
    waiting = [plain_function(hook) for hook in hooks]
    while waiting:
        function = waiting.pop()
        if id(function) in found or not hasattr(function, "__code__"):
            continue
        found[id(function)] = function
        waiting += [plain_function(used) for _, used in _used(function) if hasattr(used, "py_func")]
    return list(found.values())


def _used(function: Any) -> Iterator[tuple[str, Any]]:
    """Yield what a function's names stand for: globals, attributes of modules, and closed-over values."""
    names = names_in(function.__code__)
    for name in sorted(names & function.__globals__.keys()):
        value = function.__globals__[name]
        yield name, value
        if isinstance(value, ModuleType):
            yield from (
                (f"{name}.{inner}", getattr(value, inner)) for inner in names if hasattr(value, inner)
            )
    if function.__closure__:
        yield from zip(function.__code__.co_freevars, (cell.cell_contents for cell in function.__closure__))


def names_used(hooks: Iterable[Callable[..., Any]]) -> set[str]:
    """Return the global names that the hooks and the compiled functions that they call speak of."""
    return {name for function in functions_of(hooks) for name in names_in(function.__code__)}


def files_of(hooks: Iterable[Callable[..., Any]]) -> set[Path]:
    """Return the files that hold the hooks and the compiled functions that they call."""
    return {Path(inspect.getfile(function)) for function in functions_of(hooks)}


def texts_of(hooks: Iterable[Callable[..., Any]]) -> list[str]:
    """Return what each function does, as text, sorted: its file may have changed since it was read."""
    return sorted(_text_of(function.__code__) for function in functions_of(hooks))


def _text_of(code: CodeType) -> str:
    inner = (_text_of(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts)
    return f"{code.co_name} {code.co_code.hex()} {code.co_names} {' '.join(inner)}"


def constants_of(hooks: Iterable[Callable[..., Any]]) -> list[str]:
    """Return the constants that are compiled in, as ``module.function.name=value``, sorted."""
    found = []
    for function in functions_of(hooks):
        where = f"{function.__module__}.{function.__qualname__}"
        found += [f"{where}.{name}={value!r}" for name, value in _used(function) if isinstance(value, PLAIN)]
    return sorted(found)
