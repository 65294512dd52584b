"""Checks an effect's declaration when it is made: words, bounds, names, hooks. Errors say what to write instead."""

from __future__ import annotations

import keyword
import re
from typing import TYPE_CHECKING

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.world2d import units
from fsm_calib.world2d.effects.closure import Closure
from fsm_calib.world2d.effects.code import names_used
from fsm_calib.world2d.effects.parameter import Parameter
from fsm_calib.world2d.effects.vocabulary import (
    ACTS,
    CHANNELS,
    COMPILED_HOOKS,
    FAMILIES,
    HOOKS,
    INPUTS,
    READS,
    REGIMES,
    STEPPED,
    WHEN,
    WHERE,
    require,
)

if TYPE_CHECKING:
    from fsm_calib.world2d.effects.effect import Effect

NAME = re.compile(r"[a-z][a-z0-9_]*$")


def check_declaration(effect: Effect) -> None:
    """Refuse a declaration that contradicts itself (InputError) or uses unknown words (UnknownNameError)."""
    if not NAME.match(effect.name) or keyword.iskeyword(effect.name):
        raise _wrong(
            effect, f"the name {effect.name!r} is no lower-case word", "Use letters, digits and underscores."
        )
    _check_words(effect)
    for parameter in effect.parameters:
        _check_parameter(effect, parameter)
    _check_kind(effect)
    _check_closures(effect)
    _check_hooks(effect)


def _wrong(effect: Effect, problem: str, cure: str = "") -> InputError:
    return InputError(problem, where=f"effect {effect.name}", cure=cure)


def _check_words(effect: Effect) -> None:
    for kind, words, known in (
        ("family", (effect.family,), FAMILIES),
        ("regime", effect.regimes, REGIMES),
        ("channel", effect.channels, CHANNELS),
        ("input", (effect.input,), INPUTS),
        ("where", (effect.where,), WHERE),
        ("when", (effect.when,), WHEN),
        ("acts_on", (effect.acts_on,), ACTS),
        ("word in reads", effect.reads, READS),
        ("hook", effect.hooks, HOOKS),
    ):
        require(kind, words, known, effect.name)


def _check_parameter(effect: Effect, p: Parameter) -> None:
    try:
        units.dimension(p.unit)
    except UnknownNameError as error:
        raise UnknownNameError(
            "unit", error.name, error.known, where=f"effect {effect.name}, parameter {p.name}"
        ) from None
    if p.along and p.along not in {other.name for other in effect.parameters}:
        raise _wrong(
            effect, f"{p.name}: no parameter is called {p.along!r}", "Name the angle that it lies along."
        )
    tried = (*(("starts", x) for x in p.starts), *(("searched", x) for x in p.searched))
    for name, value in (("null", p.null), ("typical", p.typical), *tried):
        if not p.low <= value <= p.high:
            raise _wrong(
                effect, f"{p.name}: {name} is {value:g}, not within {p.low:g} to {p.high:g} {p.unit}"
            )


def _check_kind(effect: Effect) -> None:
    """Refuse a place, a time or a scanned quantity without the parameters that say which."""
    names = {p.name for p in effect.parameters}
    if len(names) < len(effect.parameters):
        raise _wrong(effect, "two parameters have one name")
    if not effect.strengths:
        raise _wrong(
            effect,
            "no parameter is a strength",
            "Leave `strength` true for those that are null when it is off.",
        )
    if effect.where != "anywhere" and effect.when != "always":
        raise _wrong(effect, "it has a place and a time", "Declare `where` or `when`, not both.")
    for kind, wanted, measures in (
        (f"where={effect.where!r}", WHERE[effect.where], units.is_length),
        (f"when={effect.when!r}", WHEN[effect.when], units.is_time),
        (f"acts_on={effect.acts_on!r}", ACTS[effect.acts_on], None),
    ):
        missing = [name for name in wanted if name not in names]
        if missing:
            raise _wrong(
                effect, f"{kind} needs parameters {', '.join(wanted)}; missing: {', '.join(missing)}"
            )
        for name in wanted:
            p = effect.parameter(name)
            if measures is not None and (p.strength or not measures(p.unit)):
                raise _wrong(
                    effect,
                    f"{kind}: {name} says where or when",
                    "Give it the unit m or s, and strength=False.",
                )


def _check_closures(effect: Effect) -> None:
    known = [p.name for p in effect.parameters]
    choices = [p.name for p in effect.parameters if not p.fitted]
    seen = set()
    for closure in effect.closures:
        where = f"effect {effect.name}, closure {closure.name!r}"
        for name in closure.frees:
            if name not in known:
                raise UnknownNameError("parameter", name, known, where=where)
            if name in choices:
                raise InputError(f"{name} is not fitted", where=where, cure="Put it into `fixes`.")
        for name, value in closure.fixes.items():
            if name not in choices:
                raise UnknownNameError("choice", name, choices, where=where)
            if not effect.parameter(name).low <= value <= effect.parameter(name).high:
                raise InputError(f"{name} is held at {value:g}, outside its bounds", where=where)
        _check_alike(effect, closure, where)
        for name in closure.extends:
            smaller = [other.name for other in effect.closures if not other.extends]
            if name not in smaller:
                raise UnknownNameError("closure", name, smaller, where=where)
        for name in re.findall(r"{(\w+)(?::[^}]*)?}", closure.sentence or effect.sentence):
            if name not in known:
                raise UnknownNameError("parameter in the sentence", name, known, where=where)
        if closure.name in seen:
            raise InputError("two closures have one name", where=where, cure="Name them apart.")
        seen.add(closure.name)


def _check_alike(effect: Effect, closure: Closure, where: str) -> None:
    """Refuse an event that comes alike in every drive and shares what is no number of a recording that it frees."""
    own = [name for name in closure.frees if effect.parameter(name).per_recording]
    for name in closure.alike:
        if name not in own:
            raise UnknownNameError("number of a recording", name, own, where=where)
    if closure.alike and effect.when == "always":
        raise InputError("what acts always comes in no drive", where=where, cure="Leave `alike` empty.")


def _check_hooks(effect: Effect) -> None:
    """Refuse hooks that cannot be woven, and a step that reads whereabouts which are not declared."""
    for stage, hook in effect.hooks.items():
        if stage in COMPILED_HOOKS and not hasattr(hook, "py_func"):
            raise _wrong(
                effect,
                f"the hook {stage} is not compiled",
                "Put @njit(error_model='numpy') of numba above it.",
            )
    used = names_used([hook for stage, hook in effect.hooks.items() if stage in STEPPED])
    for word, slots in READS.items():
        if used & set(slots) and word not in effect.reads:
            raise _wrong(effect, f"its step reads {' and '.join(slots)}", f"Declare reads=({word!r}, ...).")
