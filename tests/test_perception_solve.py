"""The camera solve: two routes to the answer, honest uncertainty, model choice, outliers, refusals, static boards."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_views import BOARD, MOUNT, SIZE, TRUTH, hand_held, scanned

from fsm_calib.errors import DataError, InputError
from fsm_calib.perception.bundle import fit
from fsm_calib.perception.fleet_camera import FLEET_MEDIAN, fleet_start, why_not_a_duckiebot
from fsm_calib.perception.free_boards import FreeBoards, fitted_poses, start_poses
from fsm_calib.perception.intrinsics import calibrate, views_per_board
from fsm_calib.perception.lens import camera_model, intrinsics_vector, project
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.perception.rotations import rotation_from_vector
from fsm_calib.perception.solve_settings import SolveSettings
from fsm_calib.perception.stages import held_intrinsics
from fsm_calib.perception.static_boards import calibrate_scan, calibrate_static, frames_of
from fsm_calib.perception.static_problem import StaticBoards, StaticState
from fsm_calib.perception.static_start import vertical_in_camera
from fsm_calib.types import BoardSpec, BoardView

QUICK = SolveSettings(coefficients=(4,), all_but_one_up_to=0, folds=2)
TRUE_CAMERA = camera_model(TRUTH, SIZE)


def al(camera: object) -> float:
    return projection_difference(TRUE_CAMERA, camera).rms  # type: ignore[arg-type]


def test_the_solve_finds_the_truth_of_views_without_noise() -> None:
    result = calibrate(hand_held(12, 0.0), BOARD, SIZE, settings=QUICK)
    np.testing.assert_allclose(intrinsics_vector(result.camera)[:8], TRUTH[:8], atol=1e-4)


def test_the_solve_agrees_with_opencv() -> None:
    views = hand_held(15, 0.1)
    ours = calibrate(views, BOARD, SIZE, settings=QUICK)
    points = [BOARD.points_board().astype(np.float32)] * len(views)
    corners = [view.corners_image.astype(np.float32)[:, None] for view in views]
    start = camera_model(FLEET_MEDIAN, SIZE)
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3
    rms, matrix, distortion, *_ = cv2.calibrateCamera(
        points, corners, SIZE, start.matrix.copy(), start.distortion.copy(), flags=flags
    )
    assert ours.rms_px == pytest.approx(rms, rel=2e-3)
    theirs = replace(start, matrix=matrix, distortion=distortion.ravel())
    assert projection_difference(ours.camera, theirs).rms < 0.1


def test_the_covariance_is_the_spread_of_many_solves() -> None:
    solves = [calibrate(hand_held(10, 0.2, seed=0), BOARD, SIZE, settings=QUICK)]
    clean, rng = hand_held(10, 0.0), np.random.default_rng(3)
    values = []
    for _ in range(25):
        noisy = [replace(v, corners_image=v.corners_image + rng.normal(size=(35, 2)) * 0.2) for v in clean]
        values.append(intrinsics_vector(calibrate(noisy, BOARD, SIZE, settings=QUICK).camera))
    spread = np.std(values, axis=0, ddof=1)[:8]
    told = np.sqrt(np.diag(solves[0].covariance))[:8]
    assert np.all((told / spread > 0.6) & (told / spread < 1.7))


def test_noise_is_estimated_and_the_three_figures_relate_as_defined() -> None:
    result = calibrate(hand_held(20, 0.2), BOARD, SIZE, settings=QUICK)
    assert result.noise_px == pytest.approx(0.2, rel=0.06)
    assert result.paper_px == pytest.approx(result.rms_px / math.sqrt(35), rel=0.05)
    assert result.mean_px < result.rms_px


def test_no_coefficient_is_added_where_four_suffice() -> None:
    result = calibrate(hand_held(12, 0.15), BOARD, SIZE)
    assert result.camera.distortion[4] == 0.0
    assert [trial.coefficients for trial in result.models] == [4, 5, 8]


def test_a_lens_that_needs_more_coefficients_gets_them() -> None:
    wide = FLEET_MEDIAN.copy()
    wide[4:] = 0.35, 0.02, 0.0, 0.0, 0.0, 0.75, 0.12, 0.01
    result = calibrate(hand_held(20, 0.05, vector=wide), BOARD, SIZE)
    chosen = next(t for t in result.models if t.cross_validated_px == result.cross_validated_px)
    assert chosen.coefficients > 4
    assert result.cross_validated_px <= min(t.cross_validated_px for t in result.models) * 1.001


def test_a_wrong_view_is_dropped_and_named() -> None:
    views = hand_held(14, 0.1)
    views[5] = replace(
        views[5], corners_image=views[5].corners_image[::-1] + 40.0 * np.sin(np.arange(70)).reshape(35, 2)
    )
    result = calibrate(views, BOARD, SIZE, settings=QUICK)
    assert [drop.source for drop in result.views_dropped] == ["frame 5"]
    assert "do not fit" in result.views_dropped[0].reason


#: a lens of the fleet's edge, and a tilted board near the image's border: with the median lens its mirror image fits
SHORT_LENS = np.array([298.9, 301.0, 318.5, 241.3, -0.2878, 0.0569, -0.0016, -0.0004, 0.0, 0.0, 0.0, 0.0])
BORDER_POSE = (np.array([-0.09, -0.20, -0.12]), np.array([-0.43, -0.19, 0.29]))


def border_view(seed: int = 3) -> BoardView:
    turn, shift = BORDER_POSE
    image = project(SHORT_LENS, BOARD.points_board() @ rotation_from_vector(turn).T + shift)
    return BoardView(image + np.random.default_rng(seed).normal(size=image.shape) * 0.03, 0, "border")


def test_a_view_whose_mirror_image_fitted_the_first_lens_is_posed_again_and_kept() -> None:
    views = [*hand_held(20, 0.03, vector=SHORT_LENS), border_view()]
    result = calibrate(views, BOARD, SIZE, settings=QUICK)
    assert not result.views_dropped
    np.testing.assert_allclose(result.shift[-1], BORDER_POSE[1], atol=2e-3)
    assert projection_difference(camera_model(SHORT_LENS, SIZE), result.camera).rms < 0.2


def test_the_pose_that_fits_is_found_from_the_mirror_image_too() -> None:
    problem = FreeBoards(border_view().corners_image[None], BOARD.points_board())
    mirrored = start_poses(SHORT_LENS, problem.corners_image, problem.points_board, 1)
    assert np.linalg.norm(mirrored.shift[0] - BORDER_POSE[1]) > 0.05
    found = fitted_poses(SHORT_LENS, problem)
    np.testing.assert_allclose(found.shift[0], BORDER_POSE[1], atol=2e-3)


def test_a_start_is_found_where_the_plane_based_one_is_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    corners = np.stack([view.corners_image for view in hand_held(4, 0.05)])
    wanted = start_poses(TRUTH, corners, BOARD.points_board())
    nothing = (2, [np.full((3, 1), np.nan)] * 2, [np.full((3, 1), np.nan)] * 2, None)
    monkeypatch.setattr(cv2, "solvePnPGeneric", lambda *_, **__: nothing)
    found = start_poses(TRUTH, corners, BOARD.points_board())
    np.testing.assert_allclose(found.shift, wanted.shift, atol=3e-3)
    np.testing.assert_allclose(found.rotation, wanted.rotation, atol=0.02)


def test_a_wrong_corner_is_left_out_and_its_view_kept() -> None:
    views = hand_held(14, 0.1)
    corners = views[3].corners_image.copy()
    corners[7] += 6.0
    views[3] = replace(views[3], corners_image=corners)
    result = calibrate(views, BOARD, SIZE, settings=QUICK)
    assert result.views_used == 14
    assert np.isnan(result.residuals[3, 7]).all()
    assert al(result.camera) < 0.6


def test_a_camera_unlike_a_duckiebot_is_solved_by_default_and_refused_on_request() -> None:
    long = np.array([900.0, 905.0, 320.0, 240.0, -0.1, 0.05, 0, 0, 0, 0, 0, 0])
    views = hand_held(14, 0.05, vector=long)
    free = calibrate(views, BOARD, SIZE, settings=QUICK)
    assert not free.refused
    assert free.camera.matrix[0, 0] == pytest.approx(900.0, rel=0.01)
    gated = calibrate(views, BOARD, SIZE, settings=QUICK, is_duckiebot=True)
    assert gated.refused
    assert "fleet" in gated.reason


def test_too_few_views_are_refused_with_a_cure() -> None:
    with pytest.raises(DataError, match="too few"):
        calibrate(hand_held(4, 0.1), BOARD, SIZE)


def test_views_of_another_board_are_refused() -> None:
    with pytest.raises(InputError, match="35 corners"):
        calibrate(hand_held(8, 0.1), BoardSpec(9, 6), SIZE)


def test_the_fleet_start_scales_with_the_image() -> None:
    assert fleet_start((1280, 960))[0] == pytest.approx(2.0 * FLEET_MEDIAN[0])
    assert why_not_a_duckiebot(FLEET_MEDIAN, SIZE) == ""


def test_free_boards_step_is_the_derivative() -> None:
    views = hand_held(3, 0.3)
    problem = FreeBoards(np.stack([view.corners_image for view in views]), BOARD.points_board())
    state = start_poses(TRUTH, problem.corners_image, problem.points_board)
    exact, step = problem.linearize(state), 1e-6
    for unknown in range(6):
        local = np.zeros((3, 6))
        local[:, unknown] = step
        ahead = problem.residuals(problem.moved(state, np.zeros(12), local))
        back = problem.residuals(problem.moved(state, np.zeros(12), -local))
        np.testing.assert_allclose(
            exact.local[..., unknown], (ahead - back) / (2 * step), rtol=1e-4, atol=1e-3
        )


def test_static_boards_step_is_the_derivative() -> None:
    rng = np.random.default_rng(2)
    problem = StaticBoards(
        rng.uniform(100, 400, (4, 35, 2)),
        BOARD.points_board(),
        np.array([0, 1, 0, 1]),
        np.array([0, 0, 1, 2]),
    )
    face = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    state = StaticState(
        TRUTH, np.array([0.4, 0.02]), np.stack([face, face]), np.array([[0.6, 0.1, 0.0], [0.7, -0.1, 0.1]]),
        rng.normal(size=(3, 3)) * 0.05,
    )  # fmt: skip
    exact, step = problem.linearize(state), 1e-6
    for unknown in range(12, 26):
        shared = np.zeros(26)
        shared[unknown] = step
        ahead = problem.residuals(problem.moved(state, shared, np.zeros((3, 3))))
        back = problem.residuals(problem.moved(state, -shared, np.zeros((3, 3))))
        np.testing.assert_allclose(
            exact.shared[..., unknown], (ahead - back) / (2 * step), rtol=1e-4, atol=1e-3
        )
    for unknown in range(3):
        local = np.zeros((3, 3))
        local[:, unknown] = step
        ahead = problem.residuals(problem.moved(state, np.zeros(26), local))
        back = problem.residuals(problem.moved(state, np.zeros(26), -local))
        np.testing.assert_allclose(
            exact.local[..., unknown], (ahead - back) / (2 * step), rtol=1e-4, atol=1e-3
        )


def test_static_boards_give_tilt_and_height_with_the_camera() -> None:
    views = scanned(0.1)
    result = calibrate_scan(views, BOARD, SIZE, settings=QUICK)
    assert result.is_static
    assert result.pitch == pytest.approx(MOUNT.pitch, abs=math.radians(0.1))
    assert result.roll == pytest.approx(MOUNT.roll, abs=math.radians(0.05))
    assert result.height == pytest.approx(MOUNT.height, abs=1e-3)
    assert result.calibration.mount is not None


def test_static_boards_are_ahead_of_free_ones_in_the_median() -> None:
    pairs = []
    for seed in range(4):
        views = scanned(0.15, seed)
        free = calibrate(views, BOARD, SIZE, settings=QUICK)
        static = calibrate_static(views, frames_of(views), BOARD, free, settings=QUICK)
        assert static.calibration.predicted_px < free.predicted_px
        pairs.append((al(free.camera), al(static.calibration.camera)))
    free_median, static_median = np.median(pairs, axis=0)
    assert static_median < free_median


def test_a_board_that_moved_makes_the_static_answer_give_way_to_the_free_one() -> None:
    views = scanned(0.1)
    middle = (5 * len(views)) // 6
    moved = [
        replace(view, corners_image=view.corners_image + np.array([0.0, 4.0]))
        if view.board == 2 and i > middle
        else view
        for i, view in enumerate(views)
    ]
    free = calibrate(moved, BOARD, SIZE, settings=QUICK)
    result = calibrate_static(moved, frames_of(moved), BOARD, free, settings=QUICK)
    assert not result.is_static
    assert result.calibration is free
    assert result.sentence


def test_views_of_another_board_that_stands_nearly_alike_are_left_out() -> None:
    views = [replace(view, source=f"frame {i}") for i, view in enumerate(scanned(0.1, step=3.0))]
    last = [i for i, view in enumerate(views) if view.board == 1][-3:]
    raised = [
        replace(view, corners_image=view.corners_image - np.array([0.0, 1.2])) if i in last else view
        for i, view in enumerate(views)
    ]
    result = calibrate_scan(raised, BOARD, SIZE, settings=QUICK)
    assert result.is_static
    left_out = set(range(len(views))) - set(result.calibration.used.tolist())
    assert left_out >= set(last)
    assert len(left_out) <= 2 * len(last)  # those beside them on the board were pulled along
    assert al(result.calibration.camera) < 2.0 * result.calibration.predicted_px


def scanned_twice(second: dict[int, int]) -> list[BoardView]:
    """Return the views of two sweeps; in the second one, boards are filed under the numbers of `second`."""
    again = [replace(view, source=f"again, {view.source}") for view in scanned(0.1, 1)]
    return scanned(0.1) + [replace(view, board=second.get(view.board, view.board)) for view in again]


@pytest.mark.parametrize("second", [{0: 1}, {1: 2}, {2: 1}, {0: 1, 1: 2}, {0: 2, 2: 0}], ids=str)
def test_views_filed_under_the_wrong_board_are_laid_at_the_door_of_the_right_one(
    second: dict[int, int],
) -> None:
    right = calibrate_scan(scanned_twice({}), BOARD, SIZE, settings=QUICK)
    wrong = calibrate_scan(scanned_twice(second), BOARD, SIZE, settings=QUICK)
    assert wrong.is_static
    assert wrong.calibration.views_used == right.calibration.views_used
    assert wrong.calibration.views_per_board == right.calibration.views_per_board
    np.testing.assert_allclose(wrong.calibration.camera.matrix, right.calibration.camera.matrix, rtol=1e-5)


def test_the_vertical_is_the_axis_that_most_rotations_share() -> None:
    axis = np.array([0.0, -0.9, -math.sqrt(0.19)])
    turns = [rotation_from_vector(angle * axis) for angle in np.linspace(0.0, 1.0, 12)]
    other = rotation_from_vector(np.array([1.5, 0.3, 0.0]))
    mixed = np.stack([turn @ other if i % 4 == 3 else turn for i, turn in enumerate(turns)])
    found = vertical_in_camera(mixed, np.zeros(len(mixed), dtype=int))
    np.testing.assert_allclose(found, axis, atol=1e-6)


def test_frames_are_counted_by_source() -> None:
    views = [BoardView(np.zeros((35, 2)), 0, source) for source in ("a", "a", "b", "", "")]
    assert frames_of(views) == [0, 0, 1, 2, 3]


def test_views_are_counted_per_board() -> None:
    views = [BoardView(np.zeros((35, 2)), board) for board in (0, 2, 2)]
    assert views_per_board(views) == (1, 0, 2)


def test_held_intrinsics_do_not_move() -> None:
    views = hand_held(8, 0.1)
    problem = FreeBoards(np.stack([view.corners_image for view in views]), BOARD.points_board())
    start = start_poses(FLEET_MEDIAN, problem.corners_image, problem.points_board)
    solution = fit(problem, start, held_intrinsics(4), np.ones((8, 35)))
    np.testing.assert_array_equal(solution.state.intrinsics[8:], FLEET_MEDIAN[8:])
