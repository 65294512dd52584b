"""One physical effect a file; the world, the roll-out and the diagnosis read them all from here.

`registry()` finds every module of this package that declares an `EFFECT`, then those from outside (`outside`): to add
physics is to add one file, here or anywhere.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.outside import effects_of, name_files, outside_effects

__all__ = ["Closure", "Effect", "Parameter", "add_effects", "effect", "hooked", "per_catalogue", "registry"]

Function = TypeVar("Function", bound=Callable[..., Any])
_MADE_OF_IT: list[Any] = []


def per_catalogue(function: Function) -> Function:
    """Keep what a function returns until the catalogue changes (`add_effects`)."""
    kept = cache(function)
    _MADE_OF_IT.append(kept)
    return kept  # type: ignore[return-value]


@per_catalogue
def registry() -> Mapping[str, Effect]:
    """Return all effects by name: this package's in alphabetical order of their files, then those from outside.

    Raises
    ------
    InputError
        An effect from outside cannot be loaded, or has a name that is taken.
    """
    found = {effect.name: effect for effect in _own_effects()}
    for effect in outside_effects():
        if effect.name in found:
            raise InputError(
                "there are two effects of this name", where=f"effect {effect.name}", cure="Rename yours."
            )
        found[effect.name] = effect
    return MappingProxyType(found)


@per_catalogue
def hooked(stage: str) -> tuple[Effect, ...]:
    """Return the effects that have a hook for a stage, in the order in which they act."""
    effects = [effect for effect in registry().values() if stage in effect.hooks]
    return tuple(sorted(effects, key=lambda effect: (effect.order, effect.name)))


def _own_effects() -> list[Effect]:
    names = sorted(entry.name for entry in pkgutil.iter_modules(__path__))
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    return [module.EFFECT for module in modules if isinstance(getattr(module, "EFFECT", None), Effect)]


def add_effects(files: Iterable[str | Path]) -> None:
    """Add the effects of Python files to the catalogue of this process and of those that it starts.

    To be called before parameter vectors are made: their numbers move apart. Sections of scenarios are made when
    their room is first imported, and know the effects that were there then.

    Raises
    ------
    InputError
        A file cannot be loaded, declares no effect, or one of a name that is taken; nothing is added then.
    """
    paths = [Path(file).resolve() for file in files]
    taken = set(registry())
    for path in paths:
        for effect in effects_of(path):
            if effect.name in taken and registry()[effect.name] is not effect:
                raise InputError(
                    f"there is an effect of the name {effect.name!r}", where=str(path), cure="Rename yours."
                )
            taken.add(effect.name)
    name_files(paths)
    for kept in _MADE_OF_IT:
        kept.cache_clear()


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
