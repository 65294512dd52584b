"""What an investigation counts, what it may spend, and the guards that compare the two."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.statechart.books import Books
from fsm_calib.statechart.machinery import Action, Evidence, Guard


@dataclass(frozen=True, slots=True)
class InvestigateLimits:
    """What an investigation may spend in events; time and distance are judged by the activity that knows them.

    drives : designed drives. returns : moves in a row towards the middle of the area; five bring a robot back over a
    metre that misses half of every move. misses : looks in a row that do not tell
    where the robot is; twelve turns on the spot are more than a whole one.
    places : in a row from which no drive could be made: other ones are tried, towards the middle of the area.
    """

    drives: int = 12
    returns: int = 8
    misses: int = 12
    places: int = 3


@dataclass(slots=True)
class InvestigateBooks(Books):
    """What an investigation counts: drives; returns, misses, and places without a drive, in a row."""

    drives: int = 0
    returns: int = 0
    misses: int = 0
    places: int = 0


def is_roomy(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether there is room for a drive around the robot."""
    return bool(evidence["roomy"])


def is_sure(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether the answer is as sure as was asked for."""
    return bool(evidence["sure"])


def has_returns_left(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether one more move back is within the budget."""
    return books.returns < limits.returns


def has_misses_left(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether one more look without the robot is forgiven."""
    return books.misses + 1 < limits.misses


def has_drives_left(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether one more drive is within the budget."""
    return books.drives < limits.drives


def has_places_left(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether one more place may be tried."""
    return books.places + 1 < limits.places


def may_look_elsewhere(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether bounds refused drives here, and one more place may be tried."""
    return bool(evidence["cramped"]) and has_places_left(books, limits, evidence)


def may_go_on(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> bool:
    """Whether time, distance and drives are left."""
    return bool(evidence["time_left"]) and has_drives_left(books, limits, evidence)


def see_robot(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> None:
    """The robot is seen, where there is room: returns and misses begin anew."""
    books.returns = books.misses = 0


def count_return(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> None:
    """One more move back; the robot is seen."""
    books.returns += 1
    books.misses = 0


def count_miss(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> None:
    """One more look without the robot."""
    books.misses += 1


def count_drive(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> None:
    """One more drive; the places that had none are forgotten."""
    books.drives += 1
    books.places = 0


def count_place(books: InvestigateBooks, limits: InvestigateLimits, evidence: Evidence) -> None:
    """One more place from which no drive could be made."""
    books.places += 1


GUARDS: dict[str, Guard] = {
    guard.__name__: guard
    for guard in (
        is_roomy,
        is_sure,
        has_returns_left,
        has_misses_left,
        has_drives_left,
        may_go_on,
        has_places_left,
        may_look_elsewhere,
    )
}
ACTIONS: dict[str, Action] = {
    action.__name__: action for action in (see_robot, count_return, count_miss, count_drive, count_place)
}
