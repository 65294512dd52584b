"""The scan by information: what a view adds, when the scan has seen enough, what is said when it has not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from camera_views import BOARD, SIZE, TRUTH, scanned

from fsm_calib.actions import ActionSettings, Bench, Notebook, with_published
from fsm_calib.actions.judging import ADDS_TOO_LITTLE, judge_views, offer_view
from fsm_calib.actions.settings import CameraSettings
from fsm_calib.actions.solving import solve_camera
from fsm_calib.commands.run import summary
from fsm_calib.perception.information import (
    ScanProgress,
    StopRule,
    advice,
    begin_scan,
    is_enough,
    solve_scan,
    weakest_region,
    weigh_view,
)
from fsm_calib.perception.lens import camera_model
from fsm_calib.perception.prediction import GRID, ImageError, projection_difference
from fsm_calib.report.camera_words import scan_verdict
from fsm_calib.types import BoardView

VIEWS = scanned(0.05)
BOARDS = 3


@pytest.fixture(scope="module")
def solved() -> ScanProgress:
    """What is known after a whole scan."""
    return solve_scan(VIEWS, BOARD, begin_scan(SIZE, BOARDS))


def bench_with(**camera: float) -> Bench:
    settings = ActionSettings(camera=replace(CameraSettings(), **camera))
    return Bench(object(), settings, Notebook(), {"boards": BOARDS})  # type: ignore[arg-type]


def offered(bench: Bench, views: list[BoardView]) -> list[dict]:
    return [offer_view(bench, view) for view in views]


def test_a_weighed_view_predicts_what_a_solve_with_it_finds(solved: ScanProgress) -> None:
    before = solve_scan(VIEWS[:-1], BOARD, solved)
    weighed = weigh_view(VIEWS[-1], BOARD, before)
    assert weighed.progress.predicted_px == pytest.approx(solved.predicted_px, rel=0.05)
    assert weighed.progress.views_per_board == solved.views_per_board
    assert 0.0 <= weighed.gain < 1.0


def test_the_same_view_adds_less_a_second_time(solved: ScanProgress) -> None:
    first = weigh_view(VIEWS[0], BOARD, solved)
    assert weigh_view(VIEWS[0], BOARD, first.progress).gain < first.gain


def test_a_view_is_wanted_for_its_gain_or_because_its_board_lacks_views(solved: ScanProgress) -> None:
    gain = weigh_view(VIEWS[0], BOARD, solved).gain
    some = StopRule(views_per_board=0, smallest_gain=gain)
    more = replace(some, smallest_gain=gain * 1.01)
    lacking = replace(more, views_per_board=solved.views_per_board[VIEWS[0].board] + 1)
    assert weigh_view(VIEWS[0], BOARD, solved, some).is_wanted
    assert not weigh_view(VIEWS[0], BOARD, solved, more).is_wanted
    assert weigh_view(VIEWS[0], BOARD, solved, lacking).is_wanted


def test_the_prediction_falls_along_a_scan_and_covers_the_true_error(solved: ScanProgress) -> None:
    part = solve_scan(VIEWS[: len(VIEWS) // 2], BOARD, begin_scan(SIZE, BOARDS))
    assert solved.predicted_px < part.predicted_px < begin_scan(SIZE, BOARDS).predicted_px
    true = projection_difference(camera_model(TRUTH, SIZE), solved.camera).rms
    assert true <= 2.5 * solved.predicted_px


def test_a_scan_is_over_only_when_precise_with_enough_views_of_every_board(solved: ScanProgress) -> None:
    fewest = min(solved.views_per_board)
    rule = StopRule(solved.predicted_px, views_per_board=fewest, views=solved.views)
    assert is_enough(solved, rule)
    assert not is_enough(solved, replace(rule, predicted_px=np.nextafter(solved.predicted_px, 0.0)))
    assert not is_enough(solved, replace(rule, views_per_board=fewest + 1))
    assert not is_enough(solved, replace(rule, views=solved.views + 1))


@pytest.mark.parametrize("region", ["top left", "centre", "bottom right"])
def test_the_weakest_part_of_the_image_is_named(region: str) -> None:
    row = {"top": 2, "centre": 9, "bottom": 16}[region.split()[0]]
    column = {"left": 3, "centre": 12, "right": 21}[region.split()[-1]]
    grid = np.full(GRID[::-1], 0.1)
    grid[row, column] = 5.0
    assert weakest_region(ImageError(grid)) == region


def test_the_advice_is_a_board_on_the_floor_for_the_bottom_and_a_leaned_one_elsewhere() -> None:
    grid = np.full(GRID[::-1], 0.1)
    bottom, top = grid.copy(), grid.copy()
    bottom[-1, 0], top[0, 0] = 5.0, 5.0
    assert "flat on the floor" in advice(ImageError(bottom))
    assert "Lean one board back" in advice(ImageError(top))


def test_a_refused_view_is_counted_and_said_and_not_kept() -> None:
    bench = bench_with(smallest_gain=0.9, least_views_per_board=1)
    said = offered(bench, VIEWS[:12])
    refused = [item for item in said if not item["kept"]]
    assert refused
    assert {item["refused"] for item in refused} == {ADDS_TOO_LITTLE}
    assert bench.notebook.views_refused == len(refused) == 12 - len(bench.notebook.views)
    assert bench.notebook.fresh_views == 12


def test_the_published_rule_keeps_every_view_unweighed() -> None:
    settings = with_published(ActionSettings(), "sweep_count")
    bench = Bench(object(), settings, Notebook(), {"boards": BOARDS})  # type: ignore[arg-type]
    assert offered(bench, VIEWS[:12]) == [{"kept": True}] * 12
    assert bench.notebook.progress is None
    assert len(bench.notebook.views) == 12


def test_a_judgement_is_precise_exactly_when_the_rule_says_so() -> None:
    bench = bench_with(target_px=10.0, least_views_per_board=1, least_views=10)
    offered(bench, VIEWS[:9])
    assert not judge_views(bench).evidence["precise"]
    offered(bench, VIEWS[9:])
    outcome = judge_views(bench)
    assert outcome.evidence["precise"]
    assert outcome.evidence["views"] == len(bench.notebook.views)
    assert bench.notebook.fresh_views == 0


def test_a_scan_goes_on_from_a_checkpoint_to_the_last_bit() -> None:
    bench = bench_with()
    offered(bench, VIEWS[:8])
    judge_views(bench)
    offered(bench, VIEWS[8:12])
    other = bench_with()
    other.from_state(json.loads(json.dumps(bench.to_state())))
    assert offered(bench, VIEWS[12:]) == offered(other, VIEWS[12:])
    assert judge_views(bench) == judge_views(other)
    assert bench.to_state() == other.to_state()


@pytest.mark.parametrize(("target", "trigger"), [(10.0, "camera_solved"), (1e-4, "camera_imprecise")])
def test_the_final_solve_says_whether_the_target_was_reached_and_what_to_do(
    target: float, trigger: str
) -> None:
    bench = bench_with(target_px=target)
    offered(bench, VIEWS)
    outcome = solve_camera(bench)
    figures = bench.notebook.figures
    assert outcome.trigger == trigger
    assert figures is not None
    assert figures.is_reached == (trigger == "camera_solved")
    assert figures.weakest
    assert bool(figures.advice) == (trigger == "camera_imprecise")
    assert ("not reached" in outcome.sentence) == (trigger == "camera_imprecise")


CAMERA = {
    "predicted_px": 0.31,
    "target_px": 0.2,
    "weakest_part": "top left",
    "advice": "Lean one board back.",
}


@pytest.mark.parametrize(
    ("reached", "words"),
    [
        (True, "Reached: predicted error 0.310 px, 0.2 px asked for; least certain at the top left."),
        (False, "Not reached: predicted error 0.310 px, 0.2 px asked for. Lean one board back."),
        (None, ""),
    ],
)
def test_a_run_says_whether_its_scan_reached_what_was_asked_for(reached: bool | None, words: str) -> None:
    assert scan_verdict({**CAMERA, "reached": reached}) == words


def test_the_terminal_names_a_target_that_was_not_reached() -> None:
    camera = {**CAMERA, "reached": False, "true_px": 0.2, "rms_px": 0.05, "views_used": 22}
    seconds = {"simulated": 1.0, "wall": 1.0, "by_part": {}}
    result = {"outcome": "done", "camera": camera, "wheels": None, "in_lane": None, "seconds": seconds}
    assert "Not reached: predicted error 0.310 px" in summary(result, Path("out"))
    assert "reached" not in summary({**result, "camera": {**camera, "reached": True}}, Path("out"))
