"""Treads that skid also wind up, stick or drift: the wheels' difference reaches the body late, curves are wider."""

import numpy as np
import pytest
from sticking_treads import turned as turned_through

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording.channels import WheelPair, YawRateTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, simulate

AXLE, STRETCH = 0.555, 0.5
MEASURED = {"tau_forward": 0.005, "tau_turn": 0.005, "axle_length": AXLE, "skid_steer.stretch": STRETCH}


def turned(speed, duration=8.0, **windup):
    """Return times [s] and heading [rad] of a robot whose wheels differ by 0.1 m/s from t = 1 s on."""
    grid = np.arange(0.0, duration, 0.01)
    drive = Drive(np.array([0.0, 1.0]), np.array([speed, speed - 0.05]), np.array([speed, speed + 0.05]))
    values = {
        **MEASURED,
        "gain_left": 1.0,
        "gain_right": 1.0,
        **{f"skid_steer.{n}": v for n, v in windup.items()},
    }
    return grid, simulate(parameters(values), drive, grid, (0.0, 0.0, 0.0, speed, 0.0, 0.0))[:, 2]


def lost(speed, **windup):
    """Return by how much less [rad] the robot has turned in the end than one that does not wind up."""
    return turned(speed)[1][-1] - turned(speed, **windup)[1][-1]


def test_a_lag_loses_what_turns_within_it_at_any_speed():
    rate = 0.1 / (AXLE * (1.0 + STRETCH))
    for speed in (0.2, 0.8):
        assert lost(speed, trail=0.5) == pytest.approx(0.5 * rate, rel=0.02)


def test_a_way_loses_what_turns_over_it_less_where_wheels_roll_fast():
    rate = 0.1 / (AXLE * (1.0 + STRETCH))
    for speed in (0.2, 0.8):
        assert lost(speed, way=0.2) == pytest.approx(0.2 / speed * rate, rel=0.02)


def test_in_the_end_it_turns_as_it_would_at_once():
    (time, plain), (_, wound) = turned(0.4), turned(0.4, trail=0.3)
    late = time > 5.0
    np.testing.assert_allclose(np.diff(wound[late]), np.diff(plain[late]), rtol=1e-3)


def test_long_steps_of_the_lag_are_exact():
    grid = np.arange(0.0, 4.0, 0.1)
    drive = Drive(np.array([0.0, 1.0]), np.array([0.3, 0.2]), np.array([0.3, 0.4]))
    values = parameters({**MEASURED, "gain_left": 1.0, "gain_right": 1.0, "skid_steer.trail": 0.2})
    start = (0.0, 0.0, 0.0, 0.3, 0.0, 0.0)
    coarse, fine = (simulate(values, drive, grid, start, dt=dt)[:, 2] for dt in (0.05, 0.001))
    np.testing.assert_allclose(coarse, fine, atol=2e-4)


def rocked(twist, speed=0.3, dt=None):
    """Return times [s] and heading [rad] of a robot whose wheels differ by 0.1 m/s to the left, then to the right."""
    grid = np.arange(0.0, 8.0, 0.01)
    left, right = speed - np.array([0.05, -0.05]), speed + np.array([0.05, -0.05])
    drive = Drive(np.array([0.0, 4.0]), left, right)
    values = parameters({**MEASURED, "gain_left": 1.0, "gain_right": 1.0, "skid_steer.twist": twist})
    more = {} if dt is None else {"dt": dt}
    return grid, simulate(values, drive, grid, (0.0, 0.0, 0.0, speed, 0.0, 0.0), **more)[:, 2]


def test_treads_that_stick_turn_the_body_once_they_are_twisted_and_back_after_twice_as_much():
    rate, twist = 0.1 / (AXLE * (1.0 + STRETCH)), 0.05
    for speed in (0.2, 0.8):
        (time, free), (_, stuck) = rocked(0.0, speed), rocked(twist, speed)
        before, after = np.searchsorted(time, [3.9, 7.9])
        assert free[before] - stuck[before] == pytest.approx(twist, rel=0.01)
        assert stuck[after] - free[after] == pytest.approx(twist, rel=0.01)
        held = (time > 4.05) & (time < 4.0 + 2.0 * twist / rate - 0.05)
        assert np.ptp(stuck[held]) < 1e-3


def test_long_steps_of_sticking_treads_are_exact():
    (_, coarse), (_, fine) = rocked(0.05, dt=0.05), rocked(0.05, dt=0.001)
    np.testing.assert_allclose(coarse, fine, atol=1e-3)


def test_treads_that_drift_go_outwards_by_their_share_of_the_centripetal_acceleration():
    drive = Drive(np.array([0.0]), np.array([0.45]), np.array([0.55]))
    grid, speed, rate, drift = np.arange(0.0, 6.0, 0.01), 0.5, 0.1 / (AXLE * (1.0 + STRETCH)), 0.1
    values = {**MEASURED, "gain_left": 1.0, "gain_right": 1.0}
    start = (0.0, 0.0, 0.0, speed, 0.0, rate)

    def leftwards(**more):
        """Return the speed [m/s] to the robot's left in the end."""
        states = simulate(parameters({**values, **more}), drive, grid, start)
        x, y, theta = states[-2:, :3].T
        return (np.diff(y)[0] * np.cos(theta[0]) - np.diff(x)[0] * np.sin(theta[0])) / 0.01

    outwards = leftwards() - leftwards(**{"skid_steer.drift": drift})
    assert outwards == pytest.approx(drift * speed * rate, rel=0.05)


def stuck_wheels_and_gyro(seed, twist):
    """Return measured wheels and a gyro of a robot that skids and whose treads stick until twisted by `twist` [rad]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 44.0, 0.02)
    edges = np.arange(0.0, 44.0, 1.5)
    half = rng.uniform(-0.1, 0.1, edges.size)[np.searchsorted(edges, time, side="right") - 1]
    heading = turned_through(2.0 * half[:-1] * np.diff(time) / (AXLE * (1.0 + STRETCH)), twist)
    rows = slice(None, None, 5)
    noise = 0.005 * rng.normal(size=len(time[rows]))
    return Recording(
        robot=RobotFacts("sticking", wheel_radius=0.165, axle_length=AXLE),
        wheel_speed=WheelPair(time[rows], 0.3 - half[rows], 0.3 + half[rows], "m/s"),
        yaw_rate=YawRateTrack(time[rows], np.gradient(heading, time)[rows] + noise),
    )


def wheels_and_gyro(seed, way):
    """Return measured wheels and a gyro of a robot that skids and winds up over `way` [m]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 44.0, 0.1)
    edges = np.arange(0.0, 44.0, 2.0)
    held = np.searchsorted(edges, time, side="right") - 1
    mean = rng.uniform(0.15, 0.6, edges.size)[held]
    half = rng.uniform(-0.1, 0.1, edges.size)[held]
    wound, rate = 0.0, np.empty_like(time)
    for i, (v, d) in enumerate(zip(mean, 2.0 * half, strict=True)):
        rate[i] = wound / (AXLE * (1.0 + STRETCH))
        wound = d + (wound - d) * np.exp(-v * 0.1 / way)
    return Recording(
        robot=RobotFacts("soft", wheel_radius=0.165, axle_length=AXLE),
        wheel_speed=WheelPair(time, mean - half, mean + half, "m/s"),
        yaw_rate=YawRateTrack(time, rate + 0.005 * rng.normal(size=time.size)),
    )


def test_a_robot_that_winds_up_is_named_by_its_way():
    result = diagnose([wheels_and_gyro(seed, 0.12) for seed in (0, 1)])
    (found,) = [e for e in result.verdict.effects if e.name == "skid_steer"]
    assert found.closure == "winding up"
    assert found.parameters["stretch"].value == pytest.approx(STRETCH, abs=0.05)
    assert found.parameters["way"].value == pytest.approx(0.12, rel=0.3)


def test_a_robot_whose_treads_stick_is_named_by_their_twist():
    result = diagnose([stuck_wheels_and_gyro(seed, 0.04) for seed in (0, 1)])
    (found,) = [e for e in result.verdict.effects if e.name == "skid_steer"]
    assert found.closure.startswith("sticking")
    assert found.parameters["stretch"].value == pytest.approx(STRETCH, abs=0.05)
    assert found.parameters["twist"].value == pytest.approx(0.04, rel=0.1)
