"""Identification of simulated robots whose truth is known."""

import importlib.util

import numpy as np
import pytest
from recording_samples import ROOT

from fsm_calib.diagnosis.identify.filter import BY_COMMANDS, innovations, settling_noise, sway
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.diagnosis.identify.result import Estimate, Identification, combined
from fsm_calib.diagnosis.identify.robust_rows import jacobian_of, robust_fit
from fsm_calib.diagnosis.identify.scoring import Problem, maximise
from fsm_calib.diagnosis.replay.kinematics import arc, body_motion, dead_reckon, sensor_motion
from fsm_calib.diagnosis.replay.wheels import Wheels
from fsm_calib.errors import DataError
from fsm_calib.recording import PoseTrack, Recording, RobotFacts, WheelPair
from fsm_calib.recording.channels import YawRateTrack

_spec = importlib.util.spec_from_file_location("coverage", ROOT / "benchmarks" / "identify_coverage.py")
coverage = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(coverage)


def wheels_drive(seed=0, kind="wheels"):
    rng = np.random.default_rng(seed)
    truth = coverage.robot(rng)
    return truth, coverage.pose_drive(truth, rng, kind).window(0.0, 20.0)


def test_arc_agrees_with_many_small_straight_steps():
    x, y, theta = dead_reckon(np.full(20000, 0.5 / 20000), np.full(20000, 1.2 / 20000), (0.0, 0.0, 0.0))
    dx, dy = arc(np.array([0.5]), np.array([1.2]))
    assert (x[-1], y[-1], theta[-1]) == pytest.approx((dx[0], dy[0], 1.2), abs=1e-9)


def test_where_no_command_is_known_the_robot_is_lost_as_fast_as_robots_drive():
    unknown, seconds, tau = 1.0, 0.1, 0.2
    steps = np.array(
        [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]] + [[seconds, 0.3, 0.0, 0.0, k, 0.0] for k in range(1, 40)]
    )
    steps[-1, 3] = unknown
    seen = np.column_stack([0.03 * np.arange(40), np.zeros(40), np.zeros(40)])
    every = np.ones(40, dtype=bool)
    observed = np.array([0.0, 0.0, 0.0, 1e-6, 1e-6, 0.0])
    dynamics = np.array([tau, tau, 1e-4, 1e-4, 0.0])
    _, S = innovations(BY_COMMANDS, steps, seen, every, every, np.zeros(4), observed, dynamics)
    known, lost = np.sqrt(S[-2]), np.sqrt(S[-1])
    assert known[0, 0] < 0.005
    assert 0.1 * 0.5 * seconds < lost[0, 0] < 0.5 * seconds
    assert 0.1 * 5.0 * seconds < lost[2, 2] < 5.0 * seconds


def test_sensor_motion_agrees_with_transforms():
    sensor = (0.03, -0.02, 0.7)
    d, turn = body_motion(np.array([2.0]), np.array([5.0]), 0.03, 0.031, 0.1)
    dx, dy = arc(d, turn)
    matrix = coverage.transform(*sensor)
    seen = np.linalg.inv(matrix) @ coverage.transform(dx[0], dy[0], turn[0]) @ matrix
    assert sensor_motion(d, turn, np.array(sensor))[0, :2] == pytest.approx(seen[:2, 2])


def test_robust_fit_is_unmoved_by_wild_rows():
    rng = np.random.default_rng(3)
    x = rng.uniform(-1, 1, 400)
    y = (2.0 * x + 1.0 + rng.normal(0, 0.01, 400))[:, None]
    y[:12] += 5.0
    fit = robust_fit(lambda p: (p[0] * x + p[1])[:, None], y, np.zeros(2), np.ones(2))
    assert fit.parameters == pytest.approx([2.0, 1.0], abs=0.005)
    assert fit.outliers >= 12


@pytest.mark.parametrize(("pull", "caused"), [(0.0, False), (5.0, True)])
def test_outliers_that_err_to_one_side_have_a_cause(pull, caused):
    rng = np.random.default_rng(4)
    x = rng.uniform(-1, 1, 600)
    y = np.stack([2.0 * x, x], axis=1) + rng.normal(0, 0.01, (600, 2))
    y[:24] += rng.normal(pull, 1.0, (24, 2))
    fit = robust_fit(lambda p: np.stack([p[0] * x, p[1] * x], axis=1), y, np.zeros(2), np.ones(2))
    assert fit.outliers_have_a_cause is caused


def test_jacobian_agrees_with_its_formula():
    x = np.linspace(0.0, 1.0, 5)
    jacobian = jacobian_of(lambda p: np.exp(p[0] * x)[:, None], np.array([0.7]), np.ones(1))
    assert jacobian[:, 0, 0] == pytest.approx(x * np.exp(0.7 * x), rel=1e-6)


def test_intervals_of_displacement_fits_hold_the_truth():
    errors = np.array([list(coverage.errors("displacement", 1000 + seed).values()) for seed in range(25)])
    # 150 numbers, six of a robot depend on each other: 0.90 +- 0.03
    assert 0.80 <= (np.abs(errors) < coverage.INSIDE).mean() <= 0.98


@pytest.mark.parametrize("kind", ["wheels", "position", "command"])
def test_estimates_lie_within_five_deviations_of_the_truth(kind):
    errors = coverage.errors(kind, 2)
    assert all(abs(error) < 5.0 for error in errors.values())


def test_position_without_heading_cannot_tell_the_sensors_heading():
    _, recording = wheels_drive(kind="position")
    estimate = identify([recording]).estimates["sensor.theta"]
    assert estimate.value is None
    assert "no heading" in estimate.reason


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda a: (-a.left, -a.right), "the signs of both wheel channels are reversed"),
        (lambda a: (a.right, a.left), "exchanged"),
        (lambda a: (a.left, -a.right), "the sign of the right one"),
    ],
)
def test_reversed_and_exchanged_wheels_are_said(change, words):
    truth, recording = wheels_drive()
    angle = recording.wheel_angle
    left, right = change(angle)
    wrong = Recording(recording.robot, wheel_angle=WheelPair(angle.time, left, right), pose=recording.pose)
    found = identify([wrong])
    assert any(words in note for note in found.notes)
    assert found.value("axle_length") == pytest.approx(truth["axle_length"], rel=0.01)


def test_wrong_axle_of_the_manifest_is_said():
    _, recording = wheels_drive()
    facts = RobotFacts("simulated", 0.0318, 0.05)
    found = identify([Recording(facts, wheel_angle=recording.wheel_angle, pose=recording.pose)])
    assert any("stated axle_length of 0.05 m is wrong" in note for note in found.notes)


def test_yaw_rate_alone_tells_only_the_ratio():
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 40.0, 0.1)
    left, right = np.repeat(rng.uniform(-2, 8, (2, 40)), 10, axis=1)
    omega = 0.3 * right - 0.32 * left + 0.01 + rng.normal(0.0, 0.02, 400)
    recording = Recording(
        RobotFacts("gyro", 0.03, 0.1),
        wheel_rate=WheelPair(t, left, right, "rad/s"),
        yaw_rate=YawRateTrack(t, omega),
    )
    found = identify([recording])
    assert found.value("wheel_radius_left") is None
    assert "only the ratio" in found.estimates["axle_length"].reason
    for side, truth in (("left", 0.32), ("right", 0.30)):
        estimate = found.estimates[f"wheel_radius_over_axle_{side}"]
        assert abs(estimate.value - truth) < 5.0 * estimate.sd < 0.01


def test_a_robot_that_spins_at_one_rate_tells_neither_the_gyros_bias_nor_a_wheel_alone():
    """What slips more or less by the minute is no bias: the ratio of both wheels is told, as well as a bias allows."""
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 60.0, 0.1)
    slip = np.interp(t, np.arange(0.0, 61.0, 6.0), rng.normal(0.0, 0.03, 11))
    half = 3.0 + 0.3 * slip + 0.01 * rng.normal(size=len(t))
    recording = Recording(
        RobotFacts("gyro", 0.03, 0.1),
        wheel_rate=WheelPair(t, -half, half, "rad/s"),
        yaw_rate=YawRateTrack(t, 0.3 * (1.0 + slip) * 2.0 * half + 0.01 + rng.normal(0.0, 0.02, len(t))),
    )
    found = identify([recording])
    assert "at about one rate" in found.estimates["yaw_rate_bias"].reason
    for side in ("left", "right"):
        estimate = found.estimates[f"wheel_radius_over_axle_{side}"]
        assert abs(estimate.value - 0.3) < 2.0 * estimate.sd < 0.02


def test_robot_at_rest_is_refused_with_a_cure():
    t = np.arange(0.0, 10.0, 0.1)
    rng = np.random.default_rng(0)
    still = PoseTrack(t, *rng.normal(0.0, 0.001, (3, 100)))
    with pytest.raises(DataError, match="hardly moved"):
        identify([Recording(wheel_angle=WheelPair(t, np.zeros(100), np.zeros(100)), pose=still)])


def test_channels_that_tell_nothing_are_refused():
    t = np.arange(0.0, 10.0, 0.1)
    with pytest.raises(DataError, match="do not tell the robot"):
        identify([Recording(pose=PoseTrack(t, t, t, t))])


def test_recordings_of_one_robot_are_averaged_by_their_weights():
    parts = [
        Identification("r", "m", {"axle_length": Estimate(value, sd, "m")}, {})
        for value, sd in ((0.1, 0.001), (0.102, 0.002))
    ]
    mean = combined(parts).estimates["axle_length"]
    assert mean.value == pytest.approx(0.1004)
    assert mean.sd == pytest.approx((1e6 + 0.25e6) ** -0.5)


def test_recordings_that_disagree_are_said_to():
    parts = [Identification("r", "m", {"a": Estimate(value, 0.001, "m")}, {}) for value in (0.1, 0.12)]
    found = combined(parts)
    assert any("disagree about a" in note for note in found.notes)
    assert found.estimates["a"].sd == pytest.approx(0.01)


def test_sway_agrees_with_many_small_arcs():
    # speed and turn rate change linearly over 0.1 s: 0.2 to 0.5 m/s, 1 to 4 rad/s
    middle = (np.arange(2000) + 0.5) / 2000
    d, turn = (0.2 + 0.3 * middle) * 0.1 / 2000, (1.0 + 3.0 * middle) * 0.1 / 2000
    x, y, theta = dead_reckon(d, turn, (0.0, 0.0, 0.0))
    aside = sway(d.sum(), turn.sum(), 0.3 * 0.1, 3.0 * 0.1)
    dx, dy = arc(np.array([d.sum()]), np.array([turn.sum()]))
    half = theta[-1] / 2.0
    assert np.hypot(x[-1] - dx[0], y[-1] - dy[0]) > 2e-4
    assert (x[-1], y[-1]) == pytest.approx(
        (dx[0] - aside * np.sin(half), dy[0] + aside * np.cos(half)), abs=1e-5
    )


def test_travel_between_stamps_follows_an_acceleration():
    time = np.arange(0.0, 2.0, 0.05)
    wheels = Wheels(time, 3.0 * time**2, 5.0 * time, "rad", "wheel_radius", "m", None, 0.03)
    travel, gained = wheels.along(np.array([0.5, 0.525, 1.525]))
    assert travel[:, 0] == pytest.approx([3.0 * (0.525**2 - 0.25), 3.0 * (1.525**2 - 0.525**2)], rel=1e-3)
    assert travel[:, 1] == pytest.approx([0.125, 5.0])
    assert gained[1] == pytest.approx([6.0, 0.0], rel=2e-3, abs=1e-9)


def test_noise_level_counts_the_parameters_that_were_fitted():
    # three lines of four points with a slope and an offset each: 12 numbers, 6 fitted
    rng = np.random.default_rng(5)
    design = np.stack([np.ones(4), np.arange(4.0)], axis=1)
    seen = rng.normal(0.0, 0.3, (4, 3))

    def run(p, used):
        e = seen - design @ p[:6].reshape(2, 3)
        return e, np.tile(np.eye(3) * np.exp(2.0 * p[6]), (4, 1, 1))

    free, noise = np.full(8, np.inf), np.arange(8) >= 6
    problem = Problem(
        run, np.ones(8), np.zeros(8), np.where(np.arange(8) == 7, 1.0, free), noise, np.zeros(8)
    )
    found = maximise(problem, np.zeros(8), 4, spare=7).parameters[6]
    left = seen - design @ np.linalg.lstsq(design, seen, rcond=None)[0]
    assert np.exp(2.0 * found) == pytest.approx((left**2).sum() / (12 - 6), rel=0.05)


@pytest.mark.parametrize(("h", "tau"), [(0.05, 0.1), (0.3, 0.1), (0.05, 40.0), (1e-4, 0.2)])
def test_settling_noise_agrees_with_its_integrals(h, tau):
    late = (np.arange(20000) + 0.5) * h / 20000  # age of a push at the end of the step
    way, speed = tau * (1.0 - np.exp(-late / tau)), np.exp(-late / tau)
    expected = [2.0 * h * np.mean(product) for product in (way * way, way * speed, speed * speed)]
    assert settling_noise(h, tau, 2.0) == pytest.approx(expected, rel=1e-4)
