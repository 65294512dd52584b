"""What the runner sees of the machine: activity, briefing, failure, limits and the plan."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.machines.activities import CONTRACT
from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.failures import FAILURES
from fsm_calib.machines.limits import PUBLISHED, Limits, with_published
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.runtime import Machine


def test_plan_runs_in_the_papers_order_whatever_order_it_was_given_in() -> None:
    machine = Machine(CALIBRATION, plan=["lane", "wheels", "scan"])
    assert machine.books.plan == ["scan", "wheels", "lane"]


def test_run_begins_with_the_wheels_at_zero() -> None:
    machine = Machine(CALIBRATION)
    assert (machine.state, machine.activity) == ("between", "stop_wheels")


def test_empty_plan_is_done_at_once() -> None:
    machine = Machine(CALIBRATION, plan=[])
    machine.fire(Outcome("wheels_stopped"))
    assert (machine.state, machine.activity, machine.failure) == ("done", None, None)


def test_failure_carries_the_activity_s_sentence_and_cure_and_where_it_happened() -> None:
    machine = Machine(CALIBRATION, state="wheels/forward")
    machine.fire(Outcome("wheel_stalled", {}, "The left wheel did not turn at command 0.4.", "Plug it in."))
    failure = machine.failure
    assert failure is not None
    assert (failure.name, failure.state) == ("wheel_dead", "wheels/forward")
    assert (failure.reason, failure.cure) == ("The left wheel did not turn at command 0.4.", "Plug it in.")


def test_failure_without_a_sentence_says_the_declared_one() -> None:
    machine = Machine(CALIBRATION, state="wheels/forward")
    machine.fire(Outcome("robot_blocked"))
    declared = CALIBRATION.leaves["failed/wall_hit"]
    assert machine.failure is not None
    assert (machine.failure.reason, machine.failure.cure) == (declared.reason, declared.cure)


def test_failure_of_a_spent_budget_tells_the_numbers_and_the_table_s_cure() -> None:
    books = Books(board=1, steps=30, angle=2.5)
    machine = Machine(CALIBRATION, Limits(), books=books, state="scan/clockwise/searching")
    machine.fire(Outcome("board_missed", {"turned": 1.0}, "The board is not in sight.", "Look elsewhere."))
    assert machine.failure is not None
    assert "Chessboard 1 was not found" in machine.failure.reason
    assert "30 steps, 2.5 rad" in machine.failure.reason
    assert machine.failure.cure == CALIBRATION.leaves["failed/board_missing"].cure


def test_failure_is_in_the_books_and_so_in_the_checkpoint() -> None:
    machine = Machine(CALIBRATION, state="wheels/forward")
    machine.fire(Outcome("wheel_stalled", {}, "The left wheel stands.", "Plug it in."))
    books = Books.from_dict(machine.books.to_dict())
    resumed = Machine(CALIBRATION, books=books, state="failed/wheel_dead")
    assert resumed.is_terminal
    assert resumed.failure == machine.failure


@pytest.mark.parametrize("state", FAILURES, ids=lambda state: state.name)
def test_every_failure_has_a_reason_and_a_cure_that_are_sentences(state) -> None:
    reason = state.reason.format(**(asdict(Limits()) | Books().to_dict()))
    for text in (state.about, reason, state.cure):
        assert text[0].isupper()
        assert text.endswith(".")


def test_aborted_run_has_no_failure() -> None:
    machine = Machine(CALIBRATION, state="lane/following")
    machine.fire(Outcome("abort"))
    assert (machine.state, machine.is_terminal, machine.failure) == ("aborted", True, None)


def test_lost_frames_are_forgiven_only_in_a_row() -> None:
    machine = Machine(CALIBRATION, Limits(frame_retries=1), state="exit/leaving")
    for _ in range(3):
        machine.fire(Outcome("frame_missing"))
        machine.fire(Outcome("marker_seen", {"heading": 0.0}))
    machine.fire(Outcome("frame_frozen"))
    machine.fire(Outcome("frame_frozen"))
    assert machine.state == "failed/camera_frozen"


def test_briefing_tells_the_board_and_cannot_change_the_books() -> None:
    machine = Machine(CALIBRATION, Limits(boards=3, start_board=2), plan=["scan"])
    machine.fire(Outcome("wheels_stopped"))
    assert machine.briefing["board"] == 2
    assert machine.briefing["state"] == "scan/starting"
    machine.briefing["board"] = 0
    machine.briefing["plan"].append("lane")
    assert (machine.books.board, machine.books.plan) == (2, [])


def test_every_activity_is_described_for_the_actions() -> None:
    used = {state.do for state in CALIBRATION.leaves.values() if state.do}
    assert used == set(CONTRACT)
    assert all(activity.does.endswith(".") for activity in CONTRACT.values())


def test_published_behaviours_change_only_their_limits() -> None:
    assert with_published(Limits()) == Limits()
    assert with_published(Limits(), "single_miss_flip") == Limits(misses_before_lost=1)
    assert with_published(Limits(), *PUBLISHED).late_bound_check
    with pytest.raises(UnknownNameError, match="single_miss_flip"):
        with_published(Limits(), "single_mis_flip")


@pytest.mark.parametrize(
    ("name", "value"),
    [("boards", 0), ("passes", -1), ("aligned_within", 0.0), ("search_angle", float("nan"))],
)
def test_limits_that_no_run_could_keep_are_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        Limits(**{name: value})


def test_start_board_must_be_one_of_the_row() -> None:
    with pytest.raises(InputError, match=r"start_board is 2 of 2.*numbered from 0 to 1"):
        Limits(boards=2, start_board=2)


def test_every_phase_of_the_plan_is_entered_and_left_in_a_smooth_run() -> None:
    smooth = {
        "wheels_stopped": {}, "sharpness_measured": {"sharp": True}, "camera_solved": {},
        "marker_seen": {"heading": 0.0},
        "marker_measured": {"heading": 0.0}, "drive_finished": {}, "ratio_measured": {},
        "ratio_updated": {"quiet": True}, "control_handed": {}, "lane_seen": {}, "first_marker_seen": {},
        "next_marker_reached": {}, "ratio_kept": {},
    }  # fmt: skip
    machine, phases = Machine(CALIBRATION), []
    while not machine.is_terminal:
        if machine.books.phase not in phases[-1:]:
            phases.append(machine.books.phase)
        board = "board_missed" if machine.books.views else "board_seen"
        exits = "marker_missed" if machine.state == "exit/leaving" else board
        trigger = next((name for name in smooth if name in machine.triggers and exits == board), exits)
        machine.fire(Outcome(trigger, smooth.get(trigger, {})))
    assert (machine.state, phases) == ("done", ["", *PHASES])
