"""Read columns of a CSV file (plain or .gz) fast, and say file and line of whatever is wrong with it.

The first line names the columns; the separator is a comma, a semicolon or a tab, whichever the first line
has. Where it is no comma, decimal commas are read as points, unless the table has points too. Blank lines are skipped.
Numbers must be finite: an empty cell, a word or NaN is an error, but for rows of a tracker that lost the robot.
"""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.types import FloatArray

LONGEST_LINE = 65_536  # bytes; a row of numbers has some hundred, so a longer one is no table
LARGEST_TABLE = 1 << 30  # bytes of text after unpacking; 10 h at 1 kHz stays below it
LARGEST_NUMBER = 1e100  # far beyond any unit; larger ones only overflow later
CHUNK = 1 << 20  # bytes read at a time
COMMA, POINT = re.compile(r"(?<=\d),(?=\d)"), re.compile(r"\d\.\d")
MOST_WORDS = 20  # of a column that are listed
LOST = ("", "nan", "none", "null", "n/a")  # what trackers write where they do not see the robot


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of one file: `numbers` by column name, shape (n,); `words` by column name; the line of each
    row; how many rows were left out, as nothing was measured.
    """

    file: str
    numbers: dict[str, FloatArray]
    words: dict[str, tuple[str, ...]]
    lines: tuple[int, ...]
    lost: int = 0

    def where(self, row: int) -> str:
        """Return ``file:line`` of a row."""
        return f"{self.file}:{self.lines[row]}"


def read_table(
    path: Path,
    numeric: Sequence[str],
    text: Sequence[str] = (),
    together: Sequence[str] = (),
    only: Mapping[str, str] | None = None,
) -> Table:
    """Read the named columns.

    only : words by column; other rows are another robot's and are left out.

    together : numeric columns of one measurement; a row in which all of them are empty or NaN was not measured and is
    left out.

    Raises
    ------
    InputError
        The file is missing, empty, truncated, not text, lacks a column, or holds something that is no finite
        number; `where` is ``file:line``.
    """
    lines = read_lines(path)
    numbered = [(i + 1, line) for i, line in enumerate(lines) if line.strip()]
    if not numbered:
        raise InputError("the file is empty; expected a header line and rows", where=f"{path}:1")
    header_line, header = numbered[0]
    separator = _separator(header)
    names = _header_names(path, header_line, header, separator)
    for name in (*numeric, *text, *(only or ())):
        if name not in names:
            raise UnknownNameError("column", name, names, where=f"{path}:{header_line}")
    written = _with_points(numbered[1:], separator)
    for name, word in (only or {}).items():
        written = _with_word(path, written, name, names.index(name), word, separator)
    rows = written
    if together:
        rows = _measured(path, written, [names.index(name) for name in together], separator)
    if not rows:
        raise InputError("the file has a header but no rows", where=f"{path}:{header_line}")
    wanted = [names.index(name) for name in numeric]
    numbers = _numbers(path, rows, wanted, numeric, len(names), separator) if numeric else {}
    words = {name: _words(path, rows, names.index(name), separator) for name in text}
    return Table(str(path), numbers, words, tuple(line for line, _ in rows), len(written) - len(rows))


def header_of(path: Path) -> list[str]:
    """Return the names of a table's columns.

    Raises
    ------
    InputError
        The file is missing, empty, truncated or not text, has no rows, or begins with numbers in place of names.
    """
    written = [(number, line) for number, line in enumerate(read_lines(path), 1) if line.strip()]
    if not written:
        raise InputError("the file is empty; expected a header line and rows", where=f"{path}:1")
    number, line = written[0]
    cells = _split(path, number, line, _separator(line))
    if all(_is_finite_number(cell.strip()) for cell in cells):
        cure = "Write the names above them, such as time,left,right or time,x,y,theta."
        raise InputError(
            "the first line holds numbers, no names of columns", where=f"{path}:{number}", cure=cure
        )
    if len(written) < 2:
        raise InputError("the file has a header but no rows", where=f"{path}:{number}")
    return _header_names(path, number, line, _separator(line))


def read_lines(path: Path) -> list[str]:
    """Read a UTF-8 text file, unpacked if its name ends in .gz, as lines; refuse endless lines and binary
    data.
    """
    data = _read_bytes(path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            "not UTF-8 text", where=f"{path}:{line}", cure="Save the file as UTF-8 text."
        ) from error
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise InputError("the file holds binary data, not text", where=f"{path}:{line}")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _read_bytes(path: Path) -> bytes:
    pieces: list[bytes] = []
    size, since_newline, line = 0, 0, 1
    try:
        with gzip.open(path, "rb") if path.suffix == ".gz" else open(path, "rb") as stream:
            while chunk := stream.read(CHUNK):
                line, since_newline = _measure_lines(path, chunk, line, since_newline)
                size += len(chunk)
                if size > LARGEST_TABLE:
                    raise InputError(
                        f"the file holds more than {LARGEST_TABLE >> 20} MiB of text", where=f"{path}:{line}"
                    )
                pieces.append(chunk)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise InputError(
            "the compressed file is damaged or cut short",
            where=f"{path}:{line}",
            cure="Copy it again from its source.",
        ) from error
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read the file: {_reason(error)}", where=f"{path}:1") from error
    return b"".join(pieces)


def _measure_lines(path: Path, chunk: bytes, line: int, since_newline: int) -> tuple[int, int]:
    """Return the line number and the length of the unfinished line after `chunk`; raise if a line is too
    long.
    """
    start = 0
    for piece in chunk.split(b"\n")[:-1]:
        if since_newline + len(piece) > LONGEST_LINE:
            raise _too_long(path, line)
        start += len(piece) + 1
        since_newline, line = 0, line + 1
    since_newline += len(chunk) - start
    if since_newline > LONGEST_LINE:
        raise _too_long(path, line)
    return line, since_newline


def _too_long(path: Path, line: int) -> InputError:
    return InputError(
        f"the line is longer than {LONGEST_LINE} bytes; a table was expected", where=f"{path}:{line}"
    )


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or "the name or the content is not usable"


def _separator(header: str) -> str:
    return next((mark for mark in ",;\t" if mark in header), ",")


def _with_points(rows: list[tuple[int, str]], separator: str) -> list[tuple[int, str]]:
    """Return the rows with decimal commas as points, where commas do not separate and no point is there."""
    if separator == "," or any(POINT.search(line) for _, line in rows):
        return rows
    return [(number, COMMA.sub(".", line)) for number, line in rows]


def _with_word(
    path: Path, rows: list[tuple[int, str]], name: str, index: int, word: str, separator: str
) -> list[tuple[int, str]]:
    """Return the rows with a word in a column; raise InputError where there is none, with the words that are."""
    words = _words(path, rows, index, separator)
    kept = [row for row, found in zip(rows, words, strict=True) if found == word]
    if rows and not kept:
        raise UnknownNameError(f"{name} in `only`:", word, sorted(set(words))[:MOST_WORDS], where=f"{path}:1")
    return kept


def _measured(
    path: Path, rows: list[tuple[int, str]], places: Sequence[int], separator: str
) -> list[tuple[int, str]]:
    """Return the rows in which not all cells at `places` are empty or NaN."""
    kept = []
    for number, line in rows:
        cells = _split(path, number, line, separator) if '"' in line else line.split(separator)
        seen = len(cells) <= max(places) or any(cells[i].strip().lower() not in LOST for i in places)
        kept += [(number, line)] if seen else []
    return kept


def _split(path: Path, number: int, line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error as error:
        raise InputError(f"the row cannot be split into cells: {error}", where=f"{path}:{number}") from error


def _header_names(path: Path, number: int, header: str, separator: str) -> list[str]:
    names = [name.strip() for name in _split(path, number, header, separator)]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InputError(f"column {doubled[0]!r} occurs twice in the header", where=f"{path}:{number}")
    return names


def _numbers(
    path: Path,
    rows: list[tuple[int, str]],
    wanted: list[int],
    names: Sequence[str],
    width: int,
    separator: str,
) -> dict[str, FloatArray]:
    """Return the wanted columns; the fast reader first, the slow one to find the culprit if it fails."""
    try:
        table = np.loadtxt(
            io.StringIO("\n".join(line for _, line in rows)),
            delimiter=separator,
            usecols=wanted,
            comments=None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError as error:
        raise _culprit(path, rows, wanted, names, width, separator) from error
    if len(table) != len(rows) or not (np.abs(table) < LARGEST_NUMBER).all():
        raise _culprit(path, rows, wanted, names, width, separator)
    return {name: table[:, i] for i, name in enumerate(names)}


def _culprit(
    path: Path,
    rows: list[tuple[int, str]],
    wanted: list[int],
    names: Sequence[str],
    width: int,
    separator: str,
) -> InputError:
    """Find the first row that cannot be read and make the error that says so."""
    for number, line in rows:
        cells = _split(path, number, line, separator)
        where = f"{path}:{number}"
        if len(cells) < width:
            return InputError(f"the row has {len(cells)} cells, the header {width}", where=where)
        for index, name in zip(wanted, names, strict=True):
            cell = cells[index].strip()
            if not _is_finite_number(cell):
                return InputError(
                    f"column {name!r} holds {cell[:40]!r}; expected a finite number", where=where
                )
    return InputError("the rows cannot be read as numbers", where=f"{path}:{rows[0][0]}")


def _is_finite_number(cell: str) -> bool:
    try:
        return abs(float(cell)) < LARGEST_NUMBER and "_" not in cell
    except ValueError:
        return False


def _words(path: Path, rows: list[tuple[int, str]], index: int, separator: str) -> tuple[str, ...]:
    words = []
    for number, line in rows:
        # csv's own reader only where a cell may hold the separator: it takes ten times as long
        cells = _split(path, number, line, separator) if '"' in line else line.split(separator)
        if len(cells) <= index:
            raise InputError(f"the row has only {len(cells)} cells", where=f"{path}:{number}")
        words.append(cells[index].strip())
    return tuple(words)
