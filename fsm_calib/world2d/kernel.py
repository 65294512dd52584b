"""Weave the hooks of all effects and the loop into one module, compile it once, and keep it for later
processes.

The woven text is compiled from memory; what numba makes of it is kept in a folder whose name is the hash of
everything that goes into the text, beside a copy of the text: a changed effect compiles anew, an unchanged catalogue
starts at once, and where the copy differs from what was just woven all of the folder is thrown away. The folder is
private (`fsm_calib.world2d.private_folder`), below ``FSM_CALIB_CACHE`` when set, else ``$XDG_CACHE_HOME/fsm_calib`` or
``~/.cache/fsm_calib``; where there is no such place, every process compiles for itself and says so.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import shutil
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numba

from fsm_calib.world2d import arithmetic, dynamics, forces, loop, plain, slots, tyres
from fsm_calib.world2d.effects import Effect, hooked, per_catalogue, registry
from fsm_calib.world2d.effects.code import constants_of, files_of, texts_of
from fsm_calib.world2d.effects.vocabulary import COMPILED_HOOKS, STEPPED
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.private_folder import private_folder

logger = logging.getLogger(__name__)

NOT_KEPT = (
    "the compiled simulation is not kept, so that every process compiles it again: there is no folder that is this "
    "user's alone. Set FSM_CALIB_CACHE to a folder that only you can write to."
)

COMPILED = ("integrate_levels", "look_at_track", "keep", "run", "run_many", "single_step", "ride")
CACHED = ("run_many", "ride", "begin", "shape", "delay")
"""Functions that are called from Python and therefore kept on disk."""

HEADER = '''"""Woven by fsm_calib.world2d.kernel from the catalogue of effects; do not edit. {digest}"""
import math
from numba import njit
from fsm_calib.world2d.arithmetic import EXACT, ARITHMETIC
from fsm_calib.world2d.dynamics import *
from fsm_calib.world2d.plain import glide, is_plain
from fsm_calib.world2d.slots import *
OUTPUTS = {outputs}
'''


@per_catalogue
def memory_places() -> tuple[dict[str, int], int]:
    """Return the place in S of each effect's memory, and how many slots all of them need."""
    places, total = {}, 0
    for effect in registry().values():
        places[effect.name] = slots.MEMORY + total
        total += effect.memory
    return places, total


@per_catalogue
def flag_places() -> dict[str, int]:
    """Return the place of each effect in the array of flags."""
    return {name: i for i, name in enumerate(registry())}


def _hooked(stage: str, bare: bool) -> tuple[Effect, ...]:
    """Return the effects that have a hook for the stage, in the order in which they act; none of a bare robot."""
    return () if bare else hooked(stage)


def _calls(stage: str, bare: bool, template: str, indent: str = "    ") -> str:
    """Return one guarded line a hook; the template knows name, o (first parameter), m (memory) and i
    (flag).
    """
    table, (places, _), flags = parameter_table(), memory_places(), flag_places()
    lines = []
    for effect in _hooked(stage, bare):
        call = template.format(
            name=f"{effect.name}_{stage}", o=table.first[effect.name], m=places[effect.name]
        )
        lines.append(f"{indent}if on[{flags[effect.name]}]:\n{indent}    {call}\n")
    return "".join(lines)


def _imports(bare: bool) -> str:
    """Return the import lines of all compiled hooks."""
    lines = []
    for stage in COMPILED_HOOKS:
        for effect in _hooked(stage, bare):
            hook = effect.hooks[stage]
            lines.append(f"from {hook.__module__} import {hook.__name__} as {effect.name}_{stage}\n")
    return "".join(lines)


def _stages(bare: bool) -> str:
    """Return the text of begin, shape, delay and step with the hooks in their places.

    A robot without any effect that acts in a step asks once a step, not once an effect; the bare one not at all.
    """
    njit = "@njit(**ARITHMETIC{})\n"
    kept, plain = njit.format(", cache=True"), njit.format("")
    acting = dict.fromkeys(effect.name for stage in STEPPED for effect in _hooked(stage, bare))
    any_on = " or ".join(f"on[{flag_places()[name]}]" for name in acting)
    noted = f"    W[HOOKED] = 1.0 if {any_on} else 0.0\n" if any_on else ""
    calls = "".join(_calls(stage, bare, "{name}(P, {o}, S, {m}, W)", " " * 8) for stage in STEPPED)
    hooks = f"    if W[HOOKED] > 0.0:\n{calls}" if any_on else ""
    return (
        f"{kept}def begin(P, on, W):\n    begin_base(P, W)\n"
        f"{_calls('begin', bare, '{name}(P, {o}, W)')}    share_load(P, W)\n"
        f"{noted}\n\n"
        f"{kept}def shape(P, on, u, side):\n"
        f"{_calls('shape', bare, 'u = {name}(P, {o}, u, side)')}    return u\n\n\n"
        f"{kept}def delay(P, on):\n    late = 0.0\n"
        f"{_calls('delay', bare, 'late += {name}(P, {o})')}    return late\n\n\n"
        f"{plain}def step(P, on, S, W):\n    begin_step(P, W)\n"
        f"{hooks}    finish_step(S, W)\n\n\n"
    )


def _loop_text() -> str:
    """Return the text of the loop's functions, those called from Python marked for keeping on disk."""
    parts = []
    for name in COMPILED:
        text = inspect.getsource(getattr(loop, name).py_func)
        if name in CACHED:
            text = text.replace("ARITHMETIC)", "ARITHMETIC, cache=True)").replace(
                "EXACT)", "EXACT, cache=True)"
            )
        parts.append(text)
    return "\n\n".join(parts)


def _digest(text: str, bare: bool) -> str:
    """Return a hash of the woven text, of every file whose code it calls wherever it lies, and of the constants in it.

    The files are those of the hooks and of all compiled functions that they call: an effect from outside that was
    edited never runs its old machine code.
    """
    digest = hashlib.sha256(text.encode())
    digest.update(f"{sys.version} {numba.__version__}".encode())
    hooks = [effect.hooks[stage] for stage in COMPILED_HOOKS for effect in _hooked(stage, bare)]
    files = {Path(inspect.getfile(m)) for m in (arithmetic, dynamics, forces, tyres, plain, slots, loop)}
    for file in sorted(files | files_of(hooks)):
        digest.update(file.read_bytes())
    digest.update("\n".join([*texts_of(hooks), *constants_of(hooks)]).encode())
    return digest.hexdigest()[:20]


def woven_source(bare: bool = False) -> str:
    """Return the text of the whole module."""
    text = _imports(bare) + "\n\n" + _stages(bare) + _loop_text()
    return HEADER.format(digest=_digest(text, bare), outputs=loop.OUTPUTS) + text


@per_catalogue
def kernel(bare: bool = False) -> ModuleType:
    """Return the woven module (`run_many`, `ride`, `begin`, `shape`, `delay`); compiles on
    first call. The bare one knows no effect: the same arithmetic, and a fraction of the code to compile.
    """
    source = woven_source(bare)
    name = f"fsm_calib_kernel_{hashlib.sha256(source.encode()).hexdigest()}"
    module = ModuleType(name)
    file = _kept_text(name, source)
    if file is None:
        logger.warning(NOT_KEPT)
        source = source.replace(", cache=True)", ")")
    module.__file__ = str(file or f"<{name}>")
    sys.modules[name] = module
    settings: Any = numba.config
    elsewhere, settings.CACHE_DIR = settings.CACHE_DIR, ""  # beside the text, wherever others are kept
    try:
        exec(compile(source, module.__file__, "exec"), module.__dict__)
    finally:
        settings.CACHE_DIR = elsewhere
    return module


def _kept_text(name: str, source: str) -> Path | None:
    """Return the file beside which the compiled code of exactly this text is kept; None where none can be.

    The file is never executed: it says what the code beside it was compiled from.
    """
    folder = private_folder(name)
    if folder is None:
        return None
    file = folder / "kernel.py"
    try:
        if file.exists() and file.read_bytes() != source.encode():
            shutil.rmtree(folder)
            return _kept_text(name, source)
        if not file.exists():
            part = file.with_name(f"kernel.{os.getpid()}.part")
            part.write_text(source, encoding="utf-8", newline="")
            part.replace(file)
    except OSError:
        return None
    return file
