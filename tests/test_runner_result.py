"""Each figure of result.json, for a robot whose truth is known and for one of which nobody knows it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fsm_calib.actions.notebook import CameraFigures, Notebook, WheelRun
from fsm_calib.errors import DataError
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.runner import result
from fsm_calib.world2d.parameters import parameter_table

FIGURES = CameraFigures(
    0.2,
    0.1,
    0.3,
    0.4,
    0.25,
    20,
    {"0": 12, "2": 8},
    expected_px=0.24,
    target_px=0.35,
    weakest="left",
    advice="go",
)


def wheel_run(ratio: float = 1.0, residual: float = 0.0) -> WheelRun:
    """A drive of the wheel iteration with this k, which found that k is off by `residual`."""
    return WheelRun(ratio, 2.0, 0.3, 0.0, 0.002, 1.0 + residual)


def session(
    *,
    is_real: bool = False,
    state: str = "done",
    phase: str = "",
    plan: tuple[str, ...] = (),
    **found: object,
):
    """A session whose notebook holds what was found."""
    parameters = parameter_table().null
    truth = SimpleNamespace(wheel_ratio=1.04, odometer=7.5, camera=fleet_camera(), parameters=parameters)
    machine = SimpleNamespace(state=state, books=SimpleNamespace(phase=phase))
    path = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 3.0, 4.0, 0.0], [2.0, 3.0, 5.0, 0.0]])
    return SimpleNamespace(
        scenario=SimpleNamespace(plan=plan),
        spec=SimpleNamespace(scene=SimpleNamespace(boards=(None,) * 3)),
        connection=SimpleNamespace(track=lambda: path),
        truth=None if is_real else truth,
        run=SimpleNamespace(bench=SimpleNamespace(notebook=Notebook(**found)), machine=machine),
    )


@pytest.mark.parametrize(
    ("state", "outcome"),
    [("done", "done"), ("aborted", "aborted"), ("failed/wall_hit", "failed"), ("scan/turning", "unfinished")],
)
def test_an_outcome_is_the_end_that_a_run_came_to(state: str, outcome: str) -> None:
    assert result.outcome_of(state) == outcome


@pytest.mark.parametrize("found", [{}, {"camera": fleet_camera()}, {"figures": FIGURES}])
def test_a_camera_without_its_figures_is_no_result(found: dict) -> None:
    assert result.camera_result(session(**found)) is None


def test_a_camera_s_figures_are_told_with_its_true_error() -> None:
    told = result.camera_result(session(camera=fleet_camera(), figures=FIGURES))
    assert told is not None
    assert told["true_px"] == pytest.approx(0.0, abs=1e-9)
    assert told["views_per_board"] == [12, 0, 8]
    assert (told["rms_px"], told["predicted_px"], told["expected_px"], told["reached"]) == (
        0.2,
        0.4,
        0.24,
        False,
    )


def test_nobody_knows_the_true_error_of_a_real_camera() -> None:
    told = result.camera_result(session(is_real=True, camera=fleet_camera(), figures=FIGURES))
    assert told is not None
    assert "true_px" not in told


def test_wheels_that_were_not_driven_are_no_result() -> None:
    assert result.wheels_result(session()) is None


def test_wheels_are_told_as_they_were_before_the_lane() -> None:
    told = result.wheels_result(session(runs=[wheel_run()], wheel_ratio=1.02, lane_before=1.03))
    assert told is not None
    assert (told["wheel_ratio"], told["true_wheel_ratio"], told["iterations"]) == (1.03, 1.04, 1)


def test_wheels_without_a_lane_are_told_as_they_are() -> None:
    told = result.wheels_result(session(runs=[wheel_run()], wheel_ratio=1.02))
    assert told is not None
    assert told["wheel_ratio"] == 1.02


def test_a_real_robot_s_k_has_the_standard_error_of_its_last_drives() -> None:
    runs = [wheel_run(1.5), wheel_run(1.0, 0.01), wheel_run(1.01, 0.02), wheel_run(1.02, 0.03)]
    error = np.std([1.01, 1.03, 1.05], ddof=1) / np.sqrt(3)
    assert result.true_ratio(session(is_real=True, runs=runs)) == {"wheel_ratio_error": pytest.approx(error)}


def test_two_drives_tell_no_standard_error() -> None:
    assert result.true_ratio(session(is_real=True, runs=[wheel_run(), wheel_run(1.01)])) == {}
    assert result.true_ratio(session(is_real=True, runs=[wheel_run(), wheel_run(1.01), wheel_run()])) != {}


def test_the_way_is_the_true_one_where_it_is_known_else_the_dead_reckoned() -> None:
    assert result.distance(session()) == 7.5
    assert result.distance(session(is_real=True)) == pytest.approx(6.0)


def test_a_lane_that_was_not_begun_is_no_result() -> None:
    assert result.lane_result(session(wheel_ratio=1.02)) is None


@pytest.mark.parametrize(("after", "applied"), [(1.03, False), (1.035, True)])
def test_a_refinement_in_the_lane_says_whether_it_was_applied(after: float, applied: bool) -> None:
    told = result.lane_result(
        session(lane_before=1.03, wheel_ratio=after, lane_runs=[wheel_run(), wheel_run()])
    )
    assert told is not None
    assert told["applied"] is applied
    assert (told["wheel_ratio_before"], told["wheel_ratio_after"], told["markers"]) == (1.03, after, 2)
    assert told["true_wheel_ratio"] == 1.04


def test_nobody_knows_the_true_k_or_the_deviation_of_a_real_robot_in_the_lane() -> None:
    told = result.lane_result(session(is_real=True, lane_before=1.03))
    assert told is not None
    assert "true_wheel_ratio" not in told
    assert told["deviation_before_m"] is told["deviation_after_m"] is None


@pytest.mark.parametrize(
    ("state", "phase", "plan", "told"),
    [
        ("done", "", ("wheels",), None),
        ("done", "", ("exit",), {"handed_over": True}),
        ("lane/driving", "lane", ("exit", "lane"), {"handed_over": True}),
        ("exit/leaving", "exit", ("exit", "lane"), {"handed_over": False}),
        ("failed/lane_missing", "exit", ("exit",), {"handed_over": False}),
    ],
)
def test_a_field_is_left_where_the_run_came_to_its_end_or_to_the_lane(
    state: str, phase: str, plan: tuple[str, ...], told: object
) -> None:
    assert result.exit_result(session(state=state, phase=phase, plan=plan)) == told


def test_a_robot_that_cannot_drive_two_metres_has_no_deviation(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(parameters: object, ratio: float) -> float:
        raise DataError("the robot does not move")

    monkeypatch.setattr(result, "straight_deviation", refuse)
    assert result.deviation(session(), 1.0) is None


@pytest.mark.parametrize(
    ("found", "names"),
    [
        ({}, ["before"]),
        ({"runs": [wheel_run()]}, ["before", "after"]),
        ({"runs": [wheel_run()], "lane_before": 1.0}, ["before", "after", "after lane"]),
    ],
)
def test_test_drives_are_drawn_of_each_k_that_a_run_had(
    monkeypatch: pytest.MonkeyPatch, found: dict, names: list[str]
) -> None:
    monkeypatch.setattr(result, "test_path", lambda parameters, ratio: ratio)
    assert list(result.test_drives(session(**found))) == names


def test_a_real_robot_has_no_test_drive() -> None:
    assert result.test_drives(session(is_real=True, runs=[wheel_run()])) == {}


def test_a_test_drive_ends_after_two_metres() -> None:
    path = result.test_path(session().truth.parameters, 1.0)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert path.shape[1] == 2
    assert result.TEST_DISTANCE - 2.0 * steps.max() < steps.sum() <= result.TEST_DISTANCE
