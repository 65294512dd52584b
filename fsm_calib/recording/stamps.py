"""Times as loggers write them, read exactly: a recording's clock begins at its first stamp, whatever that is.

Seconds since 1970 leave a float64 no more than 0.2 us; so the first stamp is taken off in whole decimal numbers, before
anything becomes a float, and a clock that begins at 1.7e9 s gives the digits of one that begins at zero.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from decimal import Decimal

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording.recording import Finding
from fsm_calib.types import FloatArray

LARGEST = 1e100  # far beyond any clock
LONGEST_DRIVE = 30 * 86_400.0  # s: stamps that lie further apart come from a clock that was set in between
TOLD_FROM = 60.0  # s: a clock that begins later is told to the reader
APART = 60  # s: channels whose stamps lie further apart run on different clocks
EPOCH = (0.9e9, 3.0e9)  # s since 1970: the years 1998 to 2065
SMALLER_UNITS = (
    Decimal("1e-3"),
    Decimal("1e-6"),
    Decimal("1e-9"),
)  # s: what epoch stamps are counted in besides
ISO = re.compile(
    r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:[.,](\d{1,12}))? ?(Z|UTC|[+-]\d\d:?\d\d)?", re.ASCII
)


@dataclass(frozen=True, eq=False)
class Stamps:
    """One channel's times: numbers of `unit` [s] exactly as written, shape (n,), and the same as floats."""

    exact: tuple[str, ...] | tuple[Decimal, ...]
    rough: FloatArray
    unit: Decimal

    @property
    def first(self) -> Decimal:
        """The earliest stamp [s]."""
        return Decimal(self.exact[int(np.argmin(self.rough))]) * self.unit

    @property
    def last(self) -> Decimal:
        """The latest stamp [s]."""
        return Decimal(self.exact[int(np.argmax(self.rough))]) * self.unit

    def since(self, zero: Decimal) -> FloatArray:
        """Return the times [s] after `zero` [s], shape (n,), each rounded once."""
        if not zero:
            return self.rough * float(self.unit)
        begin = zero / self.unit
        return np.array([float(Decimal(cell) - begin) for cell in self.exact]) * float(self.unit)


def read_stamps(cells: Sequence[str], unit: float | None) -> Stamps:
    """Return the stamps of a column of numbers or of ISO 8601 times (UTC where no zone is given).

    `unit` [s] per number; None: it is guessed, seconds unless the numbers are an epoch's milli-, micro- or nanoseconds.

    Raises
    ------
    ValueError
        A cell is neither; its argument is the number of the row.
    """
    rough = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells):
        try:
            rough[row] = float(cell) if "_" not in cell else np.nan
        except ValueError:
            if ISO.fullmatch(cell) is None:
                raise ValueError(row) from None
            return _iso_stamps(cells)
        if not abs(rough[row]) < LARGEST:
            raise ValueError(row)
    return Stamps(tuple(cells), rough, Decimal(repr(unit)) if unit else _unit_of(rough))


def _unit_of(numbers: FloatArray) -> Decimal:
    """Return the unit [s] in which numbers without a stated one count: epoch stamps show it by their size."""
    typical = float(np.median(numbers))
    return next((u for u in SMALLER_UNITS if EPOCH[0] < typical * float(u) < EPOCH[1]), Decimal(1))


def _iso_stamps(cells: Sequence[str]) -> Stamps:
    exact = []
    for row, cell in enumerate(cells):
        try:
            exact.append(_iso_seconds(cell))
        except ValueError:
            raise ValueError(row) from None
    return Stamps(tuple(exact), np.array([float(value) for value in exact]), Decimal(1))


def _iso_seconds(cell: str) -> Decimal:
    """Return seconds since 1970 of an ISO 8601 time with any number of decimals."""
    found = ISO.fullmatch(cell)
    if found is None:
        raise ValueError(cell)
    day, clock, fraction, zone = found.groups()
    zone = "+00:00" if zone in (None, "Z", "UTC") else zone
    whole = datetime.fromisoformat(f"{day}T{clock}{zone}")
    return Decimal(int(whole.timestamp())) + Decimal(f"0.{fraction or 0}")


def zeros_of(channels: Mapping[str, Stamps], intervals: bool) -> dict[str, Decimal]:
    """Return for each channel the stamp [s] at which its clock is to read zero.

    Channels whose stamps overlap, or lie less than a minute apart, share a clock, which begins at its earliest stamp.
    Where a channel counts intervals, whose first begins at 0, beside stamps that begin within a minute of 0, the two
    count from the same instant, and zero it stays.
    """
    spans = sorted((stamps.first, stamps.last, name) for name, stamps in channels.items())
    found: dict[str, Decimal] = {}
    zero = end = Decimal(0)
    for first, last, name in spans:
        if not found or first > end + APART:
            zero, end = first, last
            if intervals and 0 <= first < APART:
                zero = Decimal(0)
        found[name], end = zero, max(end, last)
    return found


def refuse_long(rough: FloatArray, where: str) -> None:
    """Refuse stamps [s] that lie further apart than any drive lasts: they would need memory without end.

    Raises
    ------
    InputError
        They do.
    """
    span = float(np.ptp(rough)) if len(rough) else 0.0
    if span > LONGEST_DRIVE:
        raise InputError(
            f"the stamps of one channel span {span / 86_400.0:.4g} days: the clock was set meanwhile, or it is no time",
            where=where,
            cure="Remove the rows from before the clock was set, or name the time column and time_unit.",
        )


def zero_told(zero: float) -> list[Finding]:
    """Return what to tell of a clock whose zero [s] was taken off."""
    if abs(zero) < TOLD_FROM:
        return []
    date = ""
    if EPOCH[0] < zero < EPOCH[1]:
        date = datetime.fromtimestamp(zero, UTC).strftime(" (%Y-%m-%d %H:%M:%S UTC)")
    return [Finding("clock", "zero", f"times count from its first stamp, {zero:.3f} s{date}")]
