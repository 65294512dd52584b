"""One family of errors: each takes data and makes the sentence a user reads.

A sentence says what is wrong, where, what was found, what was expected and the cure. Expected failures of the
robot (no board in sight) are no errors: they are outcomes (`fsm_calib.outcome`).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class FsmCalibError(Exception):
    """The root of every error of this project; `exit_code` is what the command line returns."""

    exit_code = 2


class InputError(FsmCalibError):
    """A file or an argument that cannot be used as it stands.

    Parameters
    ----------
    problem : str
        What is wrong, without a full stop.
    where : str
        ``file:line:column``, a file, or an argument's name; may be empty.
    cure : str
        What the user can do about it, a sentence.
    """

    def __init__(self, problem: str, *, where: str = "", cure: str = "") -> None:
        self.problem, self.where, self.cure = problem, where, cure
        super().__init__(f"{where + ': ' if where else ''}{problem}.{' ' + cure if cure else ''}")


class UnknownNameError(InputError):
    """A name that is not among the known ones; the sentence offers the nearest."""

    def __init__(self, kind: str, name: str, known: Iterable[str], *, where: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(sorted(known))
        super().__init__(f"unknown {kind} {name!r}", where=where, cure=nearest_names(name, self.known))


class DataError(FsmCalibError):
    """Data that was read but cannot answer the question asked (too few boards, no motion, ...)."""

    exit_code = 1

    def __init__(self, problem: str, *, cure: str = "") -> None:
        self.problem, self.cure = problem, cure
        super().__init__(f"{problem}.{' ' + cure if cure else ''}")


class MissingExtraError(FsmCalibError):
    """An optional package is needed and not installed."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is not installed. Run: python3 -m pip install 'fsm-calib[{extra}]'")


class ManyErrors(InputError):
    """Every error found in one file, one a line."""

    def __init__(self, errors: Iterable[InputError]) -> None:
        self.errors = tuple(errors)
        Exception.__init__(self, "\n".join(str(error) for error in self.errors))


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Return a sentence that offers the known names nearest to `name`, or lists them all."""
    names = list(known)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.6)
    return f"Did you mean {' or '.join(near)}?" if near else f"Known: {', '.join(names)}."
