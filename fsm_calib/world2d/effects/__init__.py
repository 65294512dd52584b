"""One physical effect a file; the world, the roll-out and the diagnosis read them all from here.

`registry()` finds every module of this package that declares an `EFFECT`: to add physics is to add one file.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from fsm_calib.errors import UnknownNameError
from fsm_calib.world2d.effects.effect import Effect, Parameter

__all__ = ["Effect", "Parameter", "effect", "registry"]


@cache
def registry() -> Mapping[str, Effect]:
    """Return all effects by name, in alphabetical order of their files."""
    found = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda entry: entry.name):
        declared = getattr(importlib.import_module(f"{__name__}.{module.name}"), "EFFECT", None)
        if declared is not None:
            found[declared.name] = declared
    return MappingProxyType(found)


def effect(name: str) -> Effect:
    """Return the effect of that name.

    Raises
    ------
    UnknownNameError
        When the catalogue has none of that name; offers the nearest.
    """
    try:
        return registry()[name]
    except KeyError:
        raise UnknownNameError("effect", name, registry()) from None
