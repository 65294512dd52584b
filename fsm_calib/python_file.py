"""A Python file that a user names, as a module: loaded once, from its text as it stands."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

from fsm_calib.errors import InputError


class _AsItStands(SourceFileLoader):
    """Reads a file's code from its text each time: bytecode kept beside it may be of an edit in the same second."""

    def get_code(self, fullname: str) -> CodeType:
        """Return the module's code."""
        return self.source_to_code(self.get_data(self.path), self.path)


def module_of(file: Path, *, declares: str) -> ModuleType:
    """Return the file as a module, loaded once; its name is made of the file's name and place.

    `declares` is what the file is expected to declare, for the cure of an error.

    Raises
    ------
    InputError
        There is no such Python file, or its code fails: with the line.
    """
    place = hashlib.sha256(str(file).encode()).hexdigest()[:8]
    name = "fsm_calib_outside_" + "".join(c if c.isalnum() else "_" for c in file.stem) + f"_{place}"
    if name in sys.modules:
        return sys.modules[name]
    if not file.is_file() or file.suffix != ".py":
        problem = "is no Python file" if file.exists() else "no such file"
        raise InputError(problem, where=str(file), cure=f"Give a Python file that declares {declares}.")
    spec = importlib.util.spec_from_loader(name, _AsItStands(name, str(file)))
    if spec is None or spec.loader is None:
        raise InputError("cannot be loaded", where=str(file))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except InputError as error:
        del sys.modules[name]
        raise InputError(error.problem, where=f"{file}: {error.where}", cure=error.cure) from error
    except Exception as error:  # any code may raise anything
        del sys.modules[name]
        raise unloadable(error, f"{file}{_line(error, file)}", "Run it with python3 to see where.") from error
    return module


def unloadable(error: Exception, where: str, cure: str) -> InputError:
    """Return the error of code that cannot be loaded."""
    said = f"cannot be loaded ({type(error).__name__}: {getattr(error, 'msg', error)})"
    return InputError(said, where=where, cure=cure)


def _line(error: Exception, file: Path) -> str:
    """Return ``:line`` of the file's own line that failed; empty when none did."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f":{error.lineno}"
    line, trace = 0, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(file):
            line = trace.tb_lineno
        trace = trace.tb_next
    return f":{line}" if line else ""
