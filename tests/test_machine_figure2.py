"""The scan against an independent reading of the paper's Figure 2 (section 3.2), as a table of numbers.

The table here is written from the figure, in the paper's own terms (clockwise, visible, recovery, board),
without the machine's states; both must agree frame by frame on every sequence of hits and misses.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np
import pytest

from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.limits import Limits, with_published
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.runtime import Machine

PUBLISHED = ("single_miss_flip", "late_bound_check")


def figure2(boards: int, start: int, passes: int, hits: Iterable[bool]) -> list[tuple[int, bool, bool]]:
    """The figure's rules: after each frame the board, whether clockwise and whether in recovery."""
    board, clockwise, recovery, changes = start, True, False, 0
    rows = []
    for hit in hits:
        before = clockwise
        if board > boards - 1:
            clockwise, recovery, board = True, True, board - 1
        elif board < 0:
            clockwise, recovery, board = False, True, board + 1
        elif not recovery and not hit:
            recovery, board = True, board - 1 if clockwise else board + 1
        elif recovery and hit:
            recovery = False
        changes += clockwise != before
        rows.append((board, clockwise, recovery))
        if changes >= passes + 1:
            return rows
    return rows


def machine_rows(limits: Limits, hits: Iterable[bool]) -> list[tuple[int, bool, bool]]:
    """The same from the machine; the run is cut where the camera is solved."""
    books = Books(board=limits.start_board)
    machine = Machine(CALIBRATION, limits, books=books, state="scan/clockwise/collecting")
    rows = []
    for hit in hits:
        machine.fire(Outcome("board_seen" if hit else "board_missed"))
        if not machine.state.startswith(("scan/clockwise", "scan/counterclockwise")):
            break
        rows.append((books.board, "/clockwise/" in machine.state, machine.state.endswith("searching")))
    return rows


@pytest.mark.parametrize(("boards", "passes"), list(product(range(1, 7), (1, 2))))
def test_published_limits_reproduce_figure_2_frame_by_frame(boards: int, passes: int) -> None:
    rng = np.random.default_rng(boards * 10 + passes)
    for _ in range(20):
        limits = with_published(
            Limits(boards=boards, passes=passes, start_board=int(rng.integers(boards)),
                   views_per_board=10**6, search_steps=10**6, search_angle=1e9),
            *PUBLISHED,
        )  # fmt: skip
        hits = list(rng.random(60) < rng.choice([0.3, 0.5, 0.8]))
        assert machine_rows(limits, hits) == figure2(boards, limits.start_board, passes, hits)


def sweep(
    boards: int, start: int, passes: int, limits: Limits, missed: set[int] = frozenset()
) -> dict[int, int]:
    """Turn an ideal robot by 5 degrees a step before boards every 40 degrees, visible within 12.

    Return the views of each board; `missed` are frames in which the detector fails.
    """
    books = Books(board=start)
    machine = Machine(CALIBRATION, limits, books=books, state="scan/clockwise/collecting")
    angle, views = 40.0 * start, dict.fromkeys(range(boards), 0)
    for frame in range(500):
        angle += -5.0 if "/clockwise/" in machine.state else 5.0
        seen = [board for board in range(boards) if abs(angle - 40.0 * board) <= 12.0]
        if seen and frame not in missed:
            machine.fire(Outcome("board_seen"))
            views[books.board] += 1
            assert books.board == seen[0], "a view was filed under another board"
        else:
            machine.fire(Outcome("board_missed"))
        if machine.state == "scan/solving":
            return views
    raise AssertionError(f"no end: {machine.state} {views}")


@pytest.mark.parametrize(("boards", "passes"), [(n, p) for n in range(1, 7) for p in (1, 2, 3)])
def test_an_ideal_turn_sees_every_board_in_every_pass_and_files_each_view_rightly(
    boards: int, passes: int
) -> None:
    for start in range(boards):
        views = sweep(boards, start, passes, Limits(boards=boards, passes=passes, start_board=start))
        assert min(views.values()) >= 5 * passes


@pytest.mark.parametrize("glitch", range(3, 30))
def test_two_misses_anywhere_cost_no_board_where_the_published_table_can_lose_one(glitch: int) -> None:
    limits = Limits(boards=3, start_board=0)
    assert min(sweep(3, 0, 1, limits, {glitch, glitch + 1}).values()) >= 3


def test_published_table_files_views_under_a_wrong_board_after_one_miss() -> None:
    limits = with_published(Limits(boards=3, start_board=1), *PUBLISHED)
    with pytest.raises(AssertionError, match="another board"):
        sweep(3, 1, 1, limits, {0})
