"""What the actions compute: headings from markers, the marker map, k of a drive, the lane's judgement."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from fsm_calib.actions import ActionSettings, Bench, Notebook, with_published
from fsm_calib.actions.heading_adjustment import adjust_headings
from fsm_calib.actions.marker_map import extend, place
from fsm_calib.actions.notebook import CameraFigures, MarkerReading, WheelRun
from fsm_calib.actions.ratio import combined_ratio, run_from_readings
from fsm_calib.actions.refining import judge, judge_refinement
from fsm_calib.actions.settings import DriveSettings, RatioSettings, TurnSettings
from fsm_calib.actions.wheel_runs import path_length, update_ratio
from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.journal import encode
from fsm_calib.types import BoardView, CameraModel, Pose2, TagObservation

SD = math.radians(0.1)


def field_of(rng, columns=9, rows=3, sd=0.009):
    """A marker field along +x: number -> pose, orientations off by `sd`."""
    return {
        10 * row + column: Pose2(0.25 + 0.15 * column, 0.15 * (row - 1), rng.normal(0.0, sd))
        for row in range(rows)
        for column in range(columns)
    }


def reading_from(robot: Pose2, markers: dict, rng=None, farthest=0.5, noise=SD) -> MarkerReading:
    """What a robot at a pose would measure."""
    tags = []
    for number, pose in markers.items():
        seen = robot.inverse().then(pose)
        distance = math.hypot(seen.x, seen.y)
        if seen.x > 0.15 and distance < farthest:
            error = rng.normal(0.0, noise) if rng is not None else 0.0
            tags.append(TagObservation(number, seen.x, seen.y, seen.theta + error, distance))
    tags.sort(key=lambda tag: tag.distance)
    return MarkerReading(tuple(tags), tags[0].heading, 0.0)


def constant_noise(tag: TagObservation) -> float:
    return SD


class NoRobot:
    """A port that no estimate may use."""


def bench_with(**changes) -> Bench:
    bench = Bench(NoRobot())
    for name, value in changes.items():
        setattr(bench.notebook, name, value)
    return bench


def test_a_marker_seen_before_and_after_tells_the_turn_without_its_own_error():
    markers = {7: Pose2(0.4, 0.0, 0.2)}
    readings = [reading_from(Pose2(0, 0, 0.0), markers), reading_from(Pose2(0.1, 0, 0.03), markers)]
    turned, sd = adjust_headings(readings, constant_noise, 0.5).turned(0, 1)
    assert turned == pytest.approx(0.03, abs=1e-9)
    assert sd == pytest.approx(math.sqrt(2.0) * SD, rel=1e-3)


def test_the_stated_deviation_of_a_turn_is_the_scatter_of_repeated_turns():
    errors, stated = [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        markers = field_of(rng)
        readings = [reading_from(Pose2(x, 0, a), markers, rng) for x, a in ((0, 0), (0.35, 0.1), (0.7, 0.2))]
        turned, sd = adjust_headings(readings, constant_noise, math.radians(0.5)).turned(0, 2)
        errors.append(turned - 0.2)
        stated.append(sd)
    assert np.std(errors) == pytest.approx(np.mean(stated), rel=0.2)


def test_one_wrong_marker_hardly_moves_the_turn():
    rng = np.random.default_rng(3)
    markers = field_of(rng, sd=0.0)
    start, end = reading_from(Pose2(), markers), reading_from(Pose2(0.1, 0, 0.05), markers)
    bad = end.tags[-1]
    spoilt = (*end.tags[:-1], TagObservation(bad.tag_id, bad.x, bad.y, bad.heading + 0.3, bad.distance))
    end = MarkerReading(spoilt, end.heading, 0.0)
    turned, _ = adjust_headings([start, end], constant_noise, math.radians(0.5)).turned(0, 1)
    assert turned == pytest.approx(0.05, abs=math.radians(0.3))


def test_headings_near_half_a_turn_do_not_wrap_apart():
    markers = {1: Pose2(0.3, 0.0, math.pi - 0.01), 2: Pose2(0.3, 0.1, -math.pi + 0.01)}
    readings = [reading_from(Pose2(), markers), reading_from(Pose2(0.0, 0.0, 0.02), markers)]
    turned, _ = adjust_headings(readings, constant_noise, math.radians(0.5)).turned(0, 1)
    assert turned == pytest.approx(0.02, abs=1e-6)


def test_the_map_places_a_robot_that_shares_markers_with_it():
    markers = field_of(np.random.default_rng(1))
    known: dict[int, Pose2] = {}
    extend(known, reading_from(Pose2(), markers))
    robot = extend(known, reading_from(Pose2(0.2, 0.02, 0.1), markers))
    assert robot is not None
    assert (robot.x, robot.y, robot.theta) == pytest.approx((0.2, 0.02, 0.1), abs=1e-9)


def test_the_map_reaches_as_far_as_readings_overlap():
    markers = field_of(np.random.default_rng(1))
    known: dict[int, Pose2] = {}
    for x in (0.0, 0.2, 0.4, 0.6):
        extend(known, reading_from(Pose2(x, 0, 0), markers))
    robot = place(known, reading_from(Pose2(0.69, 0.0, 0.0), markers))
    assert robot is not None
    assert robot.x == pytest.approx(0.69, abs=1e-9)


def test_a_reading_without_known_markers_is_not_placed():
    known = {99: Pose2()}
    assert place(known, reading_from(Pose2(), field_of(np.random.default_rng(0)))) is None


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.2])
def test_the_path_between_two_poses_is_the_arc(angle):
    length = 0.6
    if angle:
        end = Pose2(length / angle * math.sin(angle), length / angle * (1 - math.cos(angle)), angle)
    else:
        end = Pose2(length, 0.0, 0.0)
    start = Pose2(1.0, 2.0, 0.7)
    assert path_length(start, start.then(end)) == pytest.approx(length)


def drive_readings(mismatch: float, distance: float = 0.69, axle: float = 0.1):
    """Readings before and after an arc of a robot whose right wheel is faster by `mismatch` (relative)."""
    turned = mismatch * distance / axle
    markers = field_of(np.random.default_rng(0), columns=12, rows=9, sd=0.0)
    radius = distance / turned if turned else math.inf
    end = (
        Pose2(radius * math.sin(turned), radius * (1 - math.cos(turned)), turned)
        if turned
        else Pose2(distance)
    )
    return [reading_from(Pose2(), markers), reading_from(end, markers)], turned


def test_k_i_asks_the_right_wheel_for_as_much_less_as_it_is_faster():
    readings, _ = drive_readings(0.02)
    bench = bench_with(readings=readings, last_duration=3.5, last_ratio=1.0)
    run = run_from_readings(bench, 0.69)
    assert run.k_i - 1.0 == pytest.approx(-0.02, abs=1e-6)


def test_straight_driving_is_the_fixed_point_of_the_corrected_equation_whatever_k_is():
    readings, _ = drive_readings(0.0)
    for ratio in (0.8, 1.0, 1.2):
        bench = bench_with(readings=readings, last_duration=3.5, last_ratio=ratio)
        assert run_from_readings(bench, 0.69).k_i == pytest.approx(1.0, abs=1e-9)


def test_the_published_equation_has_another_fixed_point_than_straight_driving():
    readings, _ = drive_readings(0.0)
    settings = with_published(ActionSettings(), "equation_3")
    bench = Bench(NoRobot(), settings)
    bench.notebook.readings, bench.notebook.last_ratio, bench.notebook.last_duration = readings, 1.2, 3.25
    assert run_from_readings(bench, 0.69).k_i == pytest.approx(1.0 / 1.2)


def test_the_published_equation_reads_the_turn_off_one_marker_s_angle():
    """k_i = (w1 + Delta_m L / (t R)) / (k w1), Delta_m the change of the marker's angle (docs/method.md)."""
    settings = with_published(ActionSettings(), "equation_3", "last_marker")
    bench = Bench(NoRobot(), settings)
    tags = (TagObservation(3, 0.3, 0.0, 0.0, 0.3),)
    bench.notebook.readings = [MarkerReading(tags, 0.05, 0.0), MarkerReading(tags, 0.02, 5.0)]
    bench.notebook.last_ratio, bench.notebook.last_duration = 1.1, 3.25
    run, left = run_from_readings(bench, 0.6), settings.drive.command
    turned = 0.03  # the marker went clockwise by so much: the robot turned counter-clockwise
    rate = -turned * settings.ratio.axle_length / (3.25 * settings.ratio.published_radius)
    assert run.turned == pytest.approx(turned)
    assert run.k_i == pytest.approx((left + rate) / (1.1 * left))


def test_a_drive_that_veers_right_raises_k():
    readings, turned = drive_readings(-0.05)
    bench = bench_with(readings=readings, last_duration=3.5, last_ratio=1.0)
    bench.notebook.runs.append(run_from_readings(bench, 0.69))
    outcome = update_ratio(bench)
    assert turned < 0.0
    assert bench.notebook.wheel_ratio == pytest.approx(1.025, abs=1e-4)
    assert outcome.evidence["quiet"] is False


@pytest.mark.parametrize(("combine", "ratio"), [(False, 1.0), (True, 0.996)])
def test_a_quiet_drive_leaves_the_iterate_as_published_and_is_combined_otherwise(combine, ratio):
    readings, _ = drive_readings(0.004)
    settings = ActionSettings(ratio=RatioSettings(combine=combine), drive=DriveSettings(distance=0.69))
    bench = Bench(NoRobot(), settings)
    bench.notebook.readings, bench.notebook.last_duration = readings, 3.5
    bench.notebook.runs.append(run_from_readings(bench, 0.69))
    outcome = update_ratio(bench)
    assert outcome.evidence["quiet"] is not combine  # one drive alone does not know k well enough
    assert bench.notebook.wheel_ratio == pytest.approx(ratio, abs=1e-4)


def test_a_short_drive_is_never_quiet():
    readings, _ = drive_readings(0.0, distance=0.2)
    bench = bench_with(readings=readings, last_duration=1.0, last_ratio=1.0)
    bench.notebook.runs.append(run_from_readings(bench, 0.2))
    assert update_ratio(bench).evidence["quiet"] is False


def test_as_published_a_short_drive_may_be_quiet():
    readings, _ = drive_readings(0.0, distance=0.2)
    bench = Bench(NoRobot(), with_published(ActionSettings(), "equation_3"))
    bench.notebook.readings, bench.notebook.last_duration, bench.notebook.last_ratio = readings, 1.0, 1.0
    bench.notebook.runs.append(run_from_readings(bench, 0.2))
    outcome = update_ratio(bench)
    assert outcome.evidence["quiet"] is True
    assert outcome.sentence.endswith(", quiet.")


def test_all_drives_together_find_the_ratio_that_each_drive_halves():
    true_ratio, readings, runs = 1.03, [], []
    bench = bench_with()
    for ratio in (1.01, 1.02, 1.025):
        pair, _ = drive_readings((ratio - true_ratio) * 0.9)
        readings += pair
        bench.notebook.readings, bench.notebook.last_ratio, bench.notebook.last_duration = (
            readings,
            ratio,
            3.5,
        )
        runs.append(run_from_readings(bench, 0.69))
    bench.notebook.runs = runs
    assert combined_ratio(bench).ratio == pytest.approx(true_ratio, abs=6e-4)


def lane_bench(mismatch: float | tuple[float, ...], drives: int = 5, seed: int = 0) -> Bench:
    """A bench after `drives` of 0.15 m in a marked lane, squared up again by hand after each."""
    of_each = mismatch if isinstance(mismatch, tuple) else (mismatch,) * drives
    rng = np.random.default_rng(seed)
    markers = {
        400 + n: Pose2(0.25 + 0.15 * n, 0.0, rng.normal(0, math.radians(0.3))) for n in range(drives + 4)
    }
    bench = bench_with()
    for n, mismatch in enumerate(of_each):
        start = Pose2(0.15 * n, 0.0, rng.normal(0.0, 0.02))
        end = start.then(Pose2(0.15, 0.0, mismatch * 0.15 / 0.1))
        bench.notebook.lane_readings += [reading_from(start, markers, rng), reading_from(end, markers, rng)]
        bench.notebook.lane_runs.append(WheelRun(1.0, 0.75, 0.15, mismatch * 1.5, SD, 1.0 - mismatch))
    return bench


def test_a_drifted_ratio_is_applied():
    bench = lane_bench(0.04)
    assert judge_refinement(bench).trigger == "ratio_applied"
    assert bench.notebook.wheel_ratio == pytest.approx(0.96, abs=0.003)


def test_an_unchanged_ratio_is_kept_in_all_of_fifty_lanes():
    outcomes = [judge_refinement(lane_bench(0.0, seed=seed)).trigger for seed in range(50)]
    assert outcomes == ["ratio_kept"] * 50


def test_measurements_that_scatter_are_not_applied():
    bench = lane_bench(0.04)
    half = lane_bench(-0.02, seed=1)
    bench.notebook.lane_readings += half.notebook.lane_readings
    bench.notebook.lane_runs += half.notebook.lane_runs
    assert judge_refinement(bench).trigger == "ratio_kept"


def test_what_drives_scatter_is_part_of_the_error_of_their_mean():
    calm, wild = lane_bench(0.009), lane_bench((0.0, 0.018, 0.0, 0.018, 0.009))
    assert judge(wild).correction == pytest.approx(judge(calm).correction, abs=1e-4)
    least = calm.settings.ratio.run_scatter / math.sqrt(5 * 0.15) * math.sqrt(4 / (4 + 5 - 1))
    assert least < judge(calm).error < judge(wild).error / 1.3
    assert judge_refinement(wild).trigger == "ratio_kept"


def test_too_few_measurements_are_not_applied():
    assert judge_refinement(lane_bench(0.04, drives=2)).trigger == "ratio_kept"
    assert judge(bench_with()).readings == 0


def test_the_notebook_survives_json():
    import json

    rng = np.random.default_rng(0)
    readings, _ = drive_readings(0.01)
    notebook = Notebook(
        views=[BoardView(rng.normal(size=(35, 2)), board=1, source="frame 3")],
        camera=CameraModel(np.eye(3), np.zeros(5)),
        figures=CameraFigures(0.2, 0.1, 0.02, 0.4, None, 30, {"0": 30}),
        readings=readings,
        reading=readings[0],
        runs=[WheelRun(1.0, 3.5, 0.69, 0.01, 0.002, 0.99)],
        marker_map={300: Pose2(1.0, 2.0, 3.0)},
        tilt_readings=[(0.3, 0.0, 0.11)],
        panorama=rng.integers(0, 255, (24, 385), dtype=np.uint8),
        start_panorama=rng.integers(0, 255, (24, 385), dtype=np.uint8),
        frame_mark=12345,
    )
    once = json.loads(json.dumps(notebook.to_state()))
    back = Notebook.from_state(once)
    assert json.loads(json.dumps(back.to_state())) == once
    assert back.marker_map == notebook.marker_map
    np.testing.assert_array_equal(back.panorama, notebook.panorama)
    np.testing.assert_array_equal(back.start_panorama, notebook.start_panorama)


def test_an_unknown_published_behaviour_names_the_nearest():
    with pytest.raises(UnknownNameError, match="camera_yaw"):
        with_published(ActionSettings(), "camera_jaw")


def test_a_negative_duration_is_refused():
    with pytest.raises(InputError, match=r"turn\.quantum"):
        ActionSettings(turn=TurnSettings(quantum=-0.1))


def test_every_declared_activity_has_its_action():
    from fsm_calib.actions import ACTIVITIES
    from fsm_calib.machines.activities import CONTRACT

    assert set(ACTIVITIES) == set(CONTRACT)


def test_a_notebook_comes_back_from_its_checkpoint_with_every_reading_exact():
    near, far = TagObservation(3, 0.1, -0.2, 1.0 / 3.0, 0.4, 0.5), TagObservation(4, 0.3, 0.2, -0.1, 0.7)
    reading = MarkerReading((near, far), 1.0 / 3.0, 1.5)
    notebook = Notebook(readings=[reading, MarkerReading((far,), 0.1, 2.0)], reading=reading)
    back = Notebook.from_state(json.loads(encode(notebook.to_state())))
    assert back.readings == notebook.readings
    assert back.reading == reading
