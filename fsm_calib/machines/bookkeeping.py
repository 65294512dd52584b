"""The bookkeeping: what a transition writes into the books, from the evidence of the outcome alone.

Every action takes ``(books, limits, evidence)``, changes only the books and cannot fail.
"""

from __future__ import annotations

from collections.abc import Callable

from fsm_calib.machines.books import Books
from fsm_calib.machines.limits import Limits
from fsm_calib.statechart.machinery import Evidence

Action = Callable[[Books, Limits, Evidence], None]


def begin_phase(books: Books, limits: Limits, evidence: Evidence) -> None:
    """Take the next phase from the plan with empty counts; the scan's board is the start board."""
    books.phase = books.plan.pop(0)
    books.clear()
    books.board = limits.start_board


def end_plan(books: Books, limits: Limits, evidence: Evidence) -> None:
    """No phase runs any more."""
    books.phase = ""
    books.clear()


def count_look(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more look at the sharpness."""
    books.looks += 1


def count_lost_frame(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more lost frame in a row."""
    books.lost_frames += 1


def count_view(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more step with the present board in sight; the misses begin anew."""
    books.views += 1
    books.misses = 0


def count_judgement(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more judgement of the camera; precise ones are counted in a row."""
    books.precise = books.precise + 1 if evidence["precise"] else 0


def count_miss(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more miss in a row."""
    books.misses += 1


def begin_search(books: Books, limits: Limits, evidence: Evidence) -> None:
    """A search begins: no steps, no angle, no views of what will be found."""
    books.steps, books.angle, books.misses, books.views = 0, 0.0, 0, 0


def count_search(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more step of a search, and the angle it turned by as far as known."""
    books.steps += 1
    books.angle += abs(evidence.get("turned", 0.0))


def begin_collecting(books: Books, limits: Limits, evidence: Evidence) -> None:
    """The search found its board: its first view of this sweep."""
    begin_search(books, limits, evidence)
    count_view(books, limits, evidence)


def pass_board_clockwise(books: Books, limits: Limits, evidence: Evidence) -> None:
    """The present board is behind; the next one clockwise has the number below."""
    books.board -= 1
    begin_search(books, limits, evidence)


def pass_board_counterclockwise(books: Books, limits: Limits, evidence: Evidence) -> None:
    """The present board is behind; the next one counter-clockwise has the number above."""
    books.board += 1
    begin_search(books, limits, evidence)


def turn_back(books: Books, limits: Limits, evidence: Evidence) -> None:
    """The end of the row: change the direction and look for the same board again."""
    books.changes += 1
    begin_search(books, limits, evidence)


def return_to_row(books: Books, limits: Limits, evidence: Evidence) -> None:
    """As published, the end of the row was passed: change the direction and take the last board's number
    again.
    """
    turn_back(books, limits, evidence)
    books.board = min(max(books.board, 0), limits.boards - 1)


def count_standpoint(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more standpoint."""
    books.standpoints += 1


def count_camera(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more standpoint whose views gave a camera, if not one as precise as wanted."""
    books.cameras += 1


def begin_sweep(books: Books, limits: Limits, evidence: Evidence) -> None:
    """At a new standpoint the sweeps and the judgements begin anew, at a board of the row."""
    books.changes, books.precise = 0, 0
    begin_search(books, limits, evidence)
    books.board = min(max(books.board, 0), limits.boards - 1)


def _begin_seeking(books: Books, limits: Limits, evidence: Evidence) -> None:
    """A search for markers or the lane begins."""
    books.steps, books.angle, books.misses = 0, 0.0, 0


def count_seeking(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more step of a search for markers or the lane."""
    count_search(books, limits, evidence)


def begin_squaring(books: Books, limits: Limits, evidence: Evidence) -> None:
    """An alignment begins: no turns, no overshoots, no search."""
    books.turns, books.overshoots = 0, 0
    _begin_seeking(books, limits, evidence)


def count_turn(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more small turning step."""
    books.turns += 1


def count_overshoot(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more small turning step, back: the step before went too far."""
    books.turns += 1
    books.overshoots += 1


def count_recovery(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more loss that is followed by a search."""
    books.recoveries += 1
    _begin_seeking(books, limits, evidence)


def count_iteration(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more wheel iteration; quiet ones are counted in a row."""
    books.iterations += 1
    books.quiet = books.quiet + 1 if evidence["quiet"] else 0


def count_leaving(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more step out of the field with a marker in sight."""
    books.leaving += 1
    books.misses = 0


def begin_following(books: Books, limits: Limits, evidence: Evidence) -> None:
    """The lane is in sight: the misses begin anew."""
    books.misses = 0


def count_following(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more step in the lane."""
    books.following += 1
    books.misses = 0


def count_marker(books: Books, limits: Limits, evidence: Evidence) -> None:
    """One more marker of the marked section has refined k."""
    books.markers += 1


ACTIONS: dict[str, Action] = {
    name: value
    for name, value in list(globals().items())
    if name.startswith(("begin_", "end_", "count_", "pass_", "turn_", "return_"))
}
"""Every bookkeeping action by its name in the tables."""
