"""One family of errors: each takes data and makes the sentence a user reads.

A sentence says what is wrong, where, what was found, what was expected and the cure. Expected failures of the
robot (no board in sight) are no errors: they are outcomes (`fsm_calib.outcome`).

What a sentence quotes from a file is a stranger's: a terminal is shown its control characters, never obeys them, and a
sentence ends after a line or two.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST_PART = 300
"""Characters of a sentence's problem, of its place and of a quoted name."""
LONGEST_NAME = 60
"""Characters of a known name that is offered: a damaged table's header may be one name."""
LONGEST_SENTENCE = 1200
"""Characters of a whole sentence, its cure with it (a cure may list all known names)."""
MOST_SENTENCES = 40
"""Errors of one file that are told; the rest is counted."""


def shown(text: str, longest: int | None = None) -> str:
    r"""Return text as one line that a terminal only shows: what does not print is written as ``\x1b``, ``\u202e``;
    the middle of what is longer than `longest` characters is left out.
    """
    text = _cut(str(text), longest)
    return _cut("".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text), longest)


def _cut(text: str, longest: int | None) -> str:
    if longest is None or len(text) <= longest:
        return text
    kept = (longest - 5) // 2
    return f"{text[:kept]} ... {text[-kept:]}"


def shown_lines(text: str) -> str:
    """Return text of several lines as lines that a terminal only shows (see `shown`)."""
    return "\n".join(shown(line) for line in text.split("\n"))


class FsmCalibError(Exception):
    """The root of every error of this project; `exit_code` is what the command line returns."""

    exit_code = 2

    def __str__(self) -> str:
        """Return the sentence, safe to print (see `shown`)."""
        return shown(super().__str__(), LONGEST_SENTENCE)


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
        where, problem = shown(where, LONGEST_PART), shown(problem, LONGEST_PART)
        super().__init__(f"{where + ': ' if where else ''}{problem}.{' ' + cure if cure else ''}")


class UnknownNameError(InputError):
    """A name that is not among the known ones; the sentence offers the nearest."""

    def __init__(self, kind: str, name: str, known: Iterable[str], *, where: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(sorted(known))
        name = shown(name, LONGEST_PART)
        super().__init__(f"unknown {kind} {name!r}", where=where, cure=nearest_names(name, self.known))


class DataError(FsmCalibError):
    """Data that was read but cannot answer the question asked (too few boards, no motion, ...)."""

    exit_code = 1

    def __init__(self, problem: str, *, cure: str = "") -> None:
        self.problem, self.cure = problem, cure
        super().__init__(f"{shown(problem, 2 * LONGEST_PART)}.{' ' + cure if cure else ''}")


class RobotLost(FsmCalibError):
    """A real robot cannot be driven any further; a port may raise it, and the runner makes it an outcome.

    Parameters
    ----------
    problem : str
        What happened, without a full stop.
    cure : str
        What the operator can do about it.
    """

    exit_code = 1

    def __init__(self, problem: str, *, cure: str = "") -> None:
        self.problem, self.cure = problem, cure
        super().__init__(f"{problem}.{' ' + cure if cure else ''}")


class LinkLost(RobotLost):
    """The robot, its camera, its wheel driver or the guard of its wheels does not answer any more."""


class EmergencyStopped(RobotLost):
    """The wheels were stopped for safety: the stop button, a foreign command, the fence, a flat battery."""


class MissingExtraError(FsmCalibError):
    """An optional package is needed and not installed."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is not installed. Run: python3 -m pip install 'fsm-calib[{extra}]'")


class ManyErrors(InputError):
    """Every error found in one file, one a line; `errors` holds all of them, the text the first `MOST_SENTENCES`."""

    def __init__(self, errors: Iterable[InputError]) -> None:
        self.errors = tuple(errors)
        Exception.__init__(self, str(self))

    def __str__(self) -> str:
        """Return the sentences, one a line."""
        lines = [str(error) for error in self.errors[:MOST_SENTENCES]]
        more = len(self.errors) - len(lines)
        return "\n".join([*lines, *([f"and {more} more errors"] if more else [])])


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Return a sentence that offers the known names nearest to `name`, or lists them all."""
    names = [shown(one, LONGEST_NAME) for one in known]
    near = difflib.get_close_matches(name[:LONGEST_PART], names, n=3, cutoff=0.6)
    return f"Did you mean {' or '.join(near)}?" if near else f"Known: {', '.join(names)}."
