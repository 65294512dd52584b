"""Tells how much of a run is spent inside OpenCV, by timing every call into the library.

While `watched` is active, each function of `cv2` and `cv2.aruco` and the detector classes used here call
`enter` before and `leave` after; 0.2 us per call. Afterwards the library is as it was.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import BuiltinFunctionType, ModuleType
from typing import Any

import cv2

from fsm_calib.perception import tags

WATCHED_CLASSES: tuple[tuple[ModuleType, str, tuple[str, ...]], ...] = (
    (cv2.aruco, "ArucoDetector", ("detectMarkers",)),
)
"""Classes whose methods are timed: module, class, methods."""


@contextmanager
def watched(enter: Callable[[], None], leave: Callable[[], None]) -> Iterator[None]:
    """Call `enter` and `leave` around every call into OpenCV inside the `with` block."""
    kept: list[tuple[ModuleType, str, Any]] = []
    tags._detector.cache_clear()
    for module in (cv2, cv2.aruco):
        for name, function in list(vars(module).items()):
            if isinstance(function, BuiltinFunctionType):
                kept.append((module, name, function))
                setattr(module, name, _timed(function, enter, leave))
    for module, name, methods in WATCHED_CLASSES:
        original = getattr(module, name)
        kept.append((module, name, original))
        setattr(module, name, _timed_class(original, methods, enter, leave))
    try:
        yield
    finally:
        for module, name, original in reversed(kept):
            setattr(module, name, original)
        tags._detector.cache_clear()


def _timed(function: Callable, enter: Callable[[], None], leave: Callable[[], None]) -> Callable:
    """Return `function` with `enter` and `leave` around it."""

    @functools.wraps(function)
    def timed(*arguments: Any, **named: Any) -> Any:
        enter()
        try:
            return function(*arguments, **named)
        finally:
            leave()

    return timed


class _Delegate:
    """Stands in for an object of OpenCV and times some of its methods.

    A subclass would be shorter; OpenCV's classes are not made to be subclassed (the process crashes at its
    end).
    """

    def __init__(self, inner: Any, methods: tuple[str, ...], wrap: Callable[[Callable], Callable]) -> None:
        self._inner = inner
        self._timed = {name: wrap(getattr(inner, name)) for name in methods}

    def __getattr__(self, name: str) -> Any:
        """Return the timed method, or whatever the object itself has."""
        return self._timed.get(name) or getattr(self._inner, name)


def _timed_class(
    original: type, methods: tuple[str, ...], enter: Callable[[], None], leave: Callable[[], None]
) -> Callable[..., _Delegate]:
    """Return a maker of objects of an OpenCV class whose `methods` are timed."""

    def make(*arguments: Any, **named: Any) -> _Delegate:
        inner = original(*arguments, **named)
        return _Delegate(inner, methods, lambda method: _timed(method, enter, leave))

    return make
