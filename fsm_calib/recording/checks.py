"""The checks that a person would make on a recording: what is impossible is refused, what is odd is told.

Rows that neighbours overtook are sorted; others whose time goes backwards are dropped; of two commands at one instant
the later holds; everything else stays as it was recorded and is told as a `Finding`.
"""

from __future__ import annotations

import dataclasses
from bisect import bisect_right
from collections.abc import Collection, Mapping
from typing import Any, Protocol

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording.channels import Channel
from fsm_calib.recording.ended_commands import without_unlogged_commands
from fsm_calib.recording.held_rows import without_held_rows
from fsm_calib.recording.interpolated_rows import without_interpolated_rows
from fsm_calib.recording.lost_tracker import without_lost_poses
from fsm_calib.recording.oddities import findings_of
from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.recording.two_clocks import with_one_clock
from fsm_calib.recording.unit_guesses import with_guessed_units

HELD = ("command", "twist", "state")  # channels whose rows hold until the next
LARGEST_NUMBER = (
    1e12  # s, m, rad or ticks: a clock in microseconds since 1970 is refused, one in s or ms is not
)
LARGEST_COMMAND = 2.0  # a logger may note what is clipped later, but not twice the largest command
REFUSED = ("mirrored", "heading", "impossible")  # kinds of findings after which nothing can be trusted
LONGEST_HOLE = 3_600.0  # s between two rows of one drive
FARTHEST_OVERTAKEN = 10  # rows: a network or a logger's threads exchange neighbours, not parts of a drive
MOST_BACKWARDS = 0.02  # share of rows with time going backwards above which the column is no clock


class Rows(Protocol):
    """Where a row of a channel came from."""

    def where(self, row: int) -> str:
        """Return ``file:line`` (or a bag's topic) of a row."""
        ...


def checked(
    recording: Recording, sources: Mapping[str, Rows], stated: Collection[str] | None = ()
) -> Recording:
    """Return the recording with impossible rows dropped and all findings; raise InputError for what is no data.

    Units and clocks that are clearly off are guessed and told; `stated` names what keeps its unit (keys of
    `unit_guesses.COLUMNS`), None keeps everything.
    """
    findings: list[Finding] = list(recording.checks)
    changes: dict[str, Any] = {}
    for name, channel in recording.channels.items():
        _refuse_no_numbers(name, channel, sources[name])
        channel, found = _increasing(name, channel, sources[name])
        changes[name] = channel
        findings += found
    recording = without_held_rows(dataclasses.replace(recording, **changes, checks=tuple(findings)))
    recording = without_interpolated_rows(recording)
    if stated is not None:
        recording = with_guessed_units(with_one_clock(recording), stated)
    recording = without_lost_poses(without_unlogged_commands(recording))
    odd = findings_of(recording)
    _refuse_impossible(recording, odd, sources)
    return dataclasses.replace(recording, checks=(*recording.checks, *odd))


def _refuse_no_numbers(name: str, channel: Channel, source: Rows) -> None:
    """Raise InputError for columns of different lengths, and for numbers that are none: nan, infinite, beyond any unit.

    A heading may be nan: it was not measured.
    """
    for field in dataclasses.fields(channel):
        values = getattr(channel, field.name)
        if not isinstance(values, np.ndarray):
            continue
        if len(values) != len(channel):
            raise InputError(
                f"{name}: {field.name} has {len(values)} rows, time {len(channel)}", where=source.where(0)
            )
        sound = np.abs(values) < LARGEST_NUMBER
        bad = ~(sound | np.isnan(values)) if (name, field.name) == ("pose", "theta") else ~sound
        if bad.any():
            row = int(np.argmax(bad))
            problem = f"{name}: {field.name} is {values[row]:g}; expected a number below {LARGEST_NUMBER:g}"
            raise InputError(problem, where=source.where(row))


def _refuse_impossible(recording: Recording, odd: list[Finding], sources: Mapping[str, Rows]) -> None:
    """Raise InputError for columns that cannot be what the manifest calls them."""
    command = recording.command
    if command is not None and len(command) and command.unit == "normalized":
        size = np.maximum(np.abs(command.left), np.abs(command.right))
        if float(np.median(size)) > 1.0 or float(size.max()) > LARGEST_COMMAND:
            raise InputError(
                f"a normalized command of {float(size.max()):g} lies far beyond -1 to 1",
                where=sources["command"].where(int(np.argmax(size))),
                cure="Say what full command is (full: 100 for percent, full: 255 for eight bits). Wheel rates have "
                "unit: rad/s or rpm; measured ones are a wheel_rate. Or are columns swapped?",
            )
    for finding in odd:
        if finding.kind in REFUSED:
            raise InputError(
                finding.sentence.removesuffix("?"),
                where=sources[finding.channel].where(0),
                cure="Check the columns, time_unit and length_unit of the manifest.",
            )


def _increasing(name: str, channel: Channel, source: Rows) -> tuple[Channel, list[Finding]]:
    """Keep the rows whose time increases."""
    step = np.diff(channel.time)
    if (step > 0).all():
        _refuse_hole(name, channel, source, np.arange(len(channel)))
        return channel, []
    back = np.flatnonzero(step < 0) + 1
    order = np.argsort(channel.time, kind="stable")
    if len(back) and np.abs(order - np.arange(len(order))).max() <= FARTHEST_OVERTAKEN:
        sentence = f"{len(back)} rows were written after later ones; sorted by their times"
        told = Finding(name, "unsorted", sentence, "kept", len(back), float(channel.time[back[0]]))
        sorted_channel, found = _increasing(name, channel.rows(order), source)
        return sorted_channel, [told, *found]
    if len(back) > MOST_BACKWARDS * len(channel):
        raise InputError(
            f"time goes backwards in {len(back)} of {len(channel)} rows of channel {name}",
            where=source.where(int(back[0])),
            cure="Is this the time column? Of several robots in one table, `only` takes one.",
        )
    findings = []
    keep = np.ones(len(channel), dtype=bool)
    if len(back):
        keep = _longest_increasing(channel.time)
        findings.append(_dropped(name, "time_backwards", "time goes backwards", channel, ~keep))
    channel = channel.rows(keep)
    _refuse_hole(name, channel, source, np.flatnonzero(keep))
    if (np.diff(channel.time) > 0).all():
        return channel, findings
    channel, finding = _later_of_two(name, channel) if name in HELD else _spread(name, channel)
    return channel, [*findings, finding]


def _longest_increasing(time: np.ndarray) -> np.ndarray:
    """Return which rows form the longest sequence of stamps [s] that never decreases: the fewest rows are dropped.

    One stamp of another clock costs its own row, not all that follow it. Patience sorting: `smallest[k]` is the row
    with the least stamp that ends a sequence of k + 1 rows, `before` the row that precedes each in its sequence.
    Source: Fredman, "On computing the length of longest increasing subsequences", Discrete Mathematics 11, 1975.
    """
    stamps: list[float] = []
    smallest: list[int] = []
    before = np.full(len(time), -1)
    for row, stamp in enumerate(time.tolist()):
        place = bisect_right(stamps, stamp)
        if place:
            before[row] = smallest[place - 1]
        stamps[place : place + 1], smallest[place : place + 1] = [stamp], [row]
    keep = np.zeros(len(time), dtype=bool)
    row = smallest[-1] if smallest else -1
    while row >= 0:
        keep[row], row = True, int(before[row])
    return keep


def _refuse_hole(name: str, channel: Channel, source: Rows, rows: np.ndarray) -> None:
    """Raise InputError for neighbouring stamps further apart than in any drive: simulating them never ends."""
    step = np.diff(channel.time)
    if not len(step) or float(step.max()) <= LONGEST_HOLE:
        return
    row = int(np.argmax(step)) + 1
    raise InputError(
        f"channel {name} has no row for {float(step[row - 1]):.4g} s: this is no single drive, or one stamp is wrong",
        where=source.where(int(rows[row])),
        cure="Remove the row, or save each drive as a recording of its own.",
    )


def _later_of_two(name: str, channel: Channel) -> tuple[Channel, Finding]:
    """Keep the last of the rows that share an instant: what is held is what came last."""
    last = np.append(np.diff(channel.time) > 0, True)
    return channel.rows(last), _dropped(name, "same_time", "a later row has the same time", channel, ~last)


def _spread(name: str, channel: Channel) -> tuple[Channel, Finding]:
    """Spread measured rows that share an instant evenly up to the next instant: each is a measurement."""
    instants, first, count = np.unique(channel.time, return_index=True, return_counts=True)
    step = np.diff(instants)
    step = np.append(step, np.median(step) if len(step) else 1.0)
    within = np.arange(len(channel)) - np.repeat(first, count)
    time = np.repeat(instants, count) + np.repeat(step / count, count) * within
    rows, at = int((count - 1).sum()), float(instants[int(np.argmax(count > 1))])
    sentence = (
        f"{rows} rows have the time of the row before them (first at {at:.3f} s); spread up to the next time"
    )

    return dataclasses.replace(channel, time=time), Finding(name, "same_time", sentence, "kept", rows, at)


def _dropped(name: str, kind: str, why: str, channel: Channel, rows: np.ndarray) -> Finding:
    count, first = int(rows.sum()), float(channel.time[int(np.argmax(rows))])
    return Finding(
        name, kind, f"{count} rows dropped: {why} (first at {first:.3f} s)", "dropped", count, first
    )
