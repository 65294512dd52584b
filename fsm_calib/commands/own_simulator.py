"""`--simulator`: a function or a program of the user's that drives by commands."""

from __future__ import annotations

import importlib
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsm_calib.errors import DataError, InputError
from fsm_calib.python_file import module_of, unloadable

if TYPE_CHECKING:
    from fsm_calib.diagnosis.own_simulator import Commands, OwnSimulator
    from fsm_calib.types import FloatArray

LONGEST = 600.0  # s that a program may take for one drive
COLUMNS = ("time", "x", "y", "theta")
WHERE = "--simulator"
FORM = "Give module:function, FILE.py:function, or a program that takes two file names (docs/diagnosis.md)."


def simulator_of(text: str) -> OwnSimulator:
    """Return the simulator that the text names: ``module:function``, ``FILE.py:function``, or a program's command.

    Raises
    ------
    InputError
        There is no such function or program.
    """
    place, colon, name = text.rpartition(":")
    if colon and name.isidentifier() and not any(c.isspace() for c in place):
        return _function(place, name)
    words = shlex.split(text)
    if not words or shutil.which(words[0]) is None:
        raise InputError(f"there is no program {words[0] if words else ''!r}", where=WHERE, cure=FORM)
    return Program(words)


def _function(place: str, name: str) -> OwnSimulator:
    """Return a function of a module or of a Python file."""
    if place.endswith(".py"):
        module = module_of(Path(place), declares=f"the function {name}")
    else:
        sys.path.insert(0, str(Path.cwd()))
        try:
            module = importlib.import_module(place)
        except ModuleNotFoundError as error:
            raise InputError(f"there is no module {error.name!r}", where=WHERE, cure=FORM) from error
        except Exception as error:  # any code may raise anything
            raise unloadable(error, f"{WHERE} {place}", "Import it with python3 to see where.") from error
        finally:
            sys.path.remove(str(Path.cwd()))
    function = getattr(module, name, None)
    if not callable(function):
        raise InputError(f"{place} has no function {name!r}", where=WHERE, cure=FORM)
    return _guarded(function, f"{place}:{name}")


def _guarded(function: Any, said: str) -> OwnSimulator:
    """Return the function with its errors told as the simulator's own."""

    def call(commands: Commands) -> Any:
        try:
            return function(commands)
        except Exception as error:  # any code may raise anything
            problem = f"the simulator {said} failed: {type(error).__name__}: {error}"
            raise DataError(problem, cure="Call it with a few commands to see where.") from error

    return call


class Program:
    """A program that is called as ``PROGRAM ... COMMANDS.csv POSES.csv``: it reads the first and writes the second."""

    def __init__(self, words: list[str]) -> None:
        self.words = words

    def __call__(self, commands: Commands) -> FloatArray:
        """Return the poses (n, 4) that the program wrote.

        Raises
        ------
        DataError
            It fails, takes too long, or writes no table of poses.
        """
        with tempfile.TemporaryDirectory(prefix="fsm-calib-") as folder:
            asked, answer = Path(folder) / "commands.csv", Path(folder) / "poses.csv"
            _write(asked, commands)
            self._run([*self.words, str(asked), str(answer)])
            return self._read(answer)

    def _run(self, words: list[str]) -> None:
        try:
            done = subprocess.run(
                words, timeout=LONGEST, capture_output=True, text=True, errors="replace", check=False
            )
        except subprocess.TimeoutExpired as error:
            raise DataError(f"the simulator {self.words[0]} took more than {LONGEST:.0f} s") from error
        except OSError as error:
            raise DataError(f"the simulator {self.words[0]} cannot be started: {error.strerror}") from error
        if done.returncode:
            last = (done.stderr or done.stdout).strip().splitlines()[-1:] or ["it says nothing"]
            raise DataError(
                f"the simulator {self.words[0]} ended with {done.returncode}: {last[0]}",
                cure="Run it by hand on a commands.csv.",
            )

    def _read(self, path: Path) -> FloatArray:
        import numpy as np

        try:
            table = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True, dtype=float))
            return np.column_stack([table[name] for name in COLUMNS])
        except (OSError, ValueError, IndexError, TypeError) as error:
            problem = f"the simulator {self.words[0]} wrote no table of poses"
            raise DataError(
                problem, cure=f"Its second argument must become a CSV with {', '.join(COLUMNS)}."
            ) from error


def _write(path: Path, commands: Commands) -> None:
    """Write commands as CSV, to every digit."""
    rows = zip(*commands.values(), strict=True)
    lines = [",".join(commands), *(",".join(repr(float(value)) for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
