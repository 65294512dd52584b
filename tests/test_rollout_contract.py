"""The roll-out and the pymunk body: what they promise to those who build on them."""

import math
import subprocess
import sys

import numpy as np
import pymunk
import pytest

from fsm_calib.errors import InputError
from fsm_calib.types import Pose2, WheelCommand
from fsm_calib.world2d.body import LARGEST_STEP, RobotBody, largest_stable_step
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import null_parameters, parameter_table, parameters
from fsm_calib.world2d.rollout import COLUMNS, Drive, simulate, simulate_many

TIMES = np.arange(0.0, 5.0, 0.05)
AHEAD = Drive([0.0], [0.4], [0.4])


def column(states, name):
    return states[..., COLUMNS.index(name)]


def test_steady_speed_is_gain_times_command():
    states = simulate(null_parameters(), AHEAD, TIMES, (0, 0, 0))
    assert column(states, "v")[-1] == pytest.approx(0.4 * 0.636, rel=1e-9)


def test_steady_turn_rate_is_difference_of_rims_over_axle():
    states = simulate(null_parameters(), Drive([0.0], [-0.2], [0.2]), TIMES, (0, 0, 0))
    assert column(states, "omega")[-1] == pytest.approx(0.4 * 0.636 / 0.1, rel=1e-6)


def test_speed_rises_with_the_forward_time_constant_on_gripping_tyres():
    """The closed form of a first-order lag; stiff tyres, so that nothing else delays."""
    vector = parameters({"slip_speed": 1e-4, "friction": 20.0})
    states = simulate(vector, AHEAD, TIMES, (0, 0, 0), dt=0.0005)
    expected = 0.4 * 0.636 * (1.0 - np.exp(-TIMES / vector[parameter_table().index["tau_forward"]]))
    np.testing.assert_allclose(column(states, "v"), expected, atol=1e-3)


def test_turn_rate_rises_with_the_turning_time_constant_on_gripping_tyres():
    vector = parameters({"slip_speed": 1e-4, "friction": 20.0})
    states = simulate(vector, Drive([0.0], [-0.2], [0.2]), TIMES, (0, 0, 0), dt=0.0005)
    expected = 2.544 * (1.0 - np.exp(-TIMES / vector[parameter_table().index["tau_turn"]]))
    np.testing.assert_allclose(column(states, "omega"), expected, atol=0.02)


def test_steady_curve_slips_outwards_by_the_tyres_compliance():
    """l = -m v omega / (2 k), k = mu N / s0: the tyres' side forces carry the centripetal force."""
    states = simulate(null_parameters(), Drive([0.0], [0.3], [0.5]), TIMES, (0, 0, 0))
    v, lateral, omega = (column(states, n)[-1] for n in ("v", "v_lateral", "omega"))
    assert lateral == pytest.approx(-0.0125 / (0.75 * 9.80665) * v * omega, rel=0.02)


def test_a_rolling_tyre_slips_outwards_by_its_slip_ratio_too():
    """l = -(s1 / mu g) v omega, s1^2 = s0^2 + kappa^2 (v^2 + (b omega / 2)^2)."""
    states = simulate(parameters({"slip_ratio": 0.1}), Drive([0.0], [0.3], [0.5]), TIMES, (0, 0, 0))
    v, lateral, omega = (column(states, n)[-1] for n in ("v", "v_lateral", "omega"))
    at_half = math.hypot(0.0125, 0.1 * math.hypot(v, 0.05 * omega))
    assert lateral == pytest.approx(-at_half / (0.75 * 9.80665) * v * omega, rel=0.03)


def test_resting_robot_is_exactly_still():
    states = simulate(null_parameters(), Drive([0.0], [0.0], [0.0]), TIMES, (0.1, 0.2, 0.3))
    np.testing.assert_array_equal(states[:, :10], np.tile(states[0, :10], (len(TIMES), 1)))


def test_robot_comes_to_exact_rest():
    states = simulate(null_parameters(), Drive([0.0, 1.0], [0.5, 0.0], [0.4, 0.0]), TIMES, (0, 0, 0))
    assert column(states, "is_moving")[-1] == 0.0
    assert column(states, "is_moving")[10] == 1.0


def test_command_between_two_steps_is_neither_lost_nor_late():
    """A pulse far shorter than a step moves the robot as far as its area says: gain x area."""
    drive = Drive([0.5013, 0.5023], [0.5, 0.0], [0.5, 0.0])
    states = simulate(null_parameters(), drive, TIMES, (0, 0, 0))
    assert column(states, "x")[-1] == pytest.approx(0.636 * 0.5 * 0.001, rel=1e-3)


def test_samples_need_not_lie_on_a_grid():
    uneven = np.union1d(TIMES, np.random.default_rng(0).uniform(0.0, 4.9, 80))
    drive = Drive([0.1, 2.0], [0.4, 0.1], [0.2, 0.3])
    even = simulate(null_parameters(), drive, TIMES, (0, 0, 0), dt=0.001)
    states = simulate(null_parameters(), drive, uneven, (0, 0, 0), dt=0.001)
    np.testing.assert_allclose(states[np.searchsorted(uneven, TIMES), :3], even[:, :3], atol=1e-6)


def test_sample_times_that_go_back_are_refused():
    with pytest.raises(InputError, match="sample times do not increase"):
        simulate(null_parameters(), AHEAD, np.array([0.0, 0.2, 0.1]), (0, 0, 0))


def test_many_vectors_give_what_each_gives_alone():
    drive = Drive([0.1, 2.0], [0.4, 0.1], [0.2, 0.3])
    vectors = np.array([null_parameters(), parameters({"floor_tilt.slope_x": 0.02, "gain_left": 0.7})])
    many = simulate_many(vectors, drive, TIMES, (0, 0, 0.5))
    for vector, states in zip(vectors, many, strict=True):
        np.testing.assert_array_equal(states, simulate(vector, drive, TIMES, (0, 0, 0.5)))


def test_track_stands_in_for_the_simulated_heading():
    """With the track turned round, the same tilt pulls the other way."""
    vector, rest = parameters({"floor_tilt.slope_x": 0.02}), Drive([0.0], [0.0], [0.0])
    track = np.column_stack([TIMES, np.zeros((len(TIMES), 2)), np.full(len(TIMES), math.pi)])
    alone = simulate(vector, rest, TIMES, (0, 0, 0))
    led = simulate(vector, rest, TIMES, (0, 0, 0), track)
    assert column(alone, "v")[-1] < -0.01
    assert column(led, "v")[-1] == pytest.approx(-column(alone, "v")[-1], rel=1e-6)


def test_delayed_commands_and_late_stamps_are_the_same_to_poses():
    drive = Drive([0.5, 2.0, 3.0], [0.4, -0.1, 0.3], [0.2, 0.3, 0.0])
    command = predict(parameters({"command_delay.delay": 0.083}), drive, TIMES, (0, 0, 0), dt=0.001)
    stamps = predict(parameters({"observation_delay.delay": 0.083}), drive, TIMES, (0, 0, 0), dt=0.001)
    np.testing.assert_allclose(command.poses, stamps.poses, atol=2e-5)


def test_encoders_tell_delayed_commands_from_late_stamps():
    drive = Drive([0.5, 2.0, 3.0], [0.4, -0.1, 0.3], [0.2, 0.3, 0.0])
    angles = [
        predict(parameters({f"{name}.delay": 0.083}), drive, TIMES, (0, 0, 0), wheel_times=TIMES).wheel_angles
        for name in ("command_delay", "observation_delay")
    ]
    assert np.abs(angles[0] - angles[1]).max() > 0.3


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (([0.0, 0.0], [0, 0], [0, 0]), "do not increase at row 1"),
        (([0.0], [math.nan], [0]), "left is not finite"),
        (([0.0, 1.0], [0], [0, 0]), "2 times, 1 left and 2 right"),
        (([], [], []), "at least one"),
    ],
)
def test_impossible_drive_is_refused(arrays, message):
    with pytest.raises(InputError, match=message):
        Drive(*arrays)


def test_start_with_a_nan_is_refused():
    with pytest.raises(InputError, match="expected a finite x, y, theta"):
        simulate(null_parameters(), AHEAD, TIMES, (0, math.nan, 0))


@pytest.mark.parametrize("dt", [0.0, -0.001, math.nan, 2 * LARGEST_STEP])
def test_body_refuses_an_impossible_step(dt):
    with pytest.raises(InputError, match="step"):
        RobotBody(pymunk.Space(), null_parameters()).step(WheelCommand(0.1, 0.1), dt)


def test_body_refuses_a_command_that_is_not_a_number():
    with pytest.raises(InputError, match="wheel command"):
        RobotBody(pymunk.Space(), null_parameters()).step(WheelCommand(math.nan, 0.1), 0.002)


def test_body_refuses_a_space_with_gravity():
    space = pymunk.Space()
    space.gravity = (0, -9.81)
    with pytest.raises(InputError, match="gravity"):
        RobotBody(space, null_parameters())


def test_wall_stops_the_body():
    space = pymunk.Space()
    space.collision_slop = 1e-4
    space.add(pymunk.Segment(space.static_body, (0.3, -1), (0.3, 1), 0.01))
    robot = RobotBody(space, null_parameters())
    space.add(pymunk.Poly.create_box(robot.body, (0.18, 0.13)))
    for _ in range(1500):
        robot.step(WheelCommand(0.5, 0.5), 0.002)
    assert robot.pose.x == pytest.approx(0.3 - 0.01 - 0.09, abs=2e-3)
    assert robot.rim_speeds[0] >= 0.0


def test_body_changes_its_physics_on_the_way():
    robot = RobotBody(pymunk.Space(), null_parameters(), Pose2())
    for vector in (null_parameters(), parameters({"gain_left": 0.5})):
        robot.set_parameters(vector)
        for _ in range(500):
            robot.step(WheelCommand(0.4, 0.4), 0.002)
        assert (robot.twist[2] > 0.1) == (vector[0] == 0.5)


def test_stable_step_shrinks_with_the_time_constants():
    assert largest_stable_step(null_parameters()) == LARGEST_STEP
    assert largest_stable_step(parameters({"tau_forward": 0.02})) == pytest.approx(0.004)


def test_a_second_process_finds_the_compiled_program():
    """Same woven source, same file: nothing is compiled twice, and results are equal bit for bit."""
    code = (
        "import numpy as np; from fsm_calib.world2d.rollout import *; from fsm_calib.world2d.kernel import kernel;"
        "from fsm_calib.world2d.parameters import null_parameters;"
        "drive = Drive([0.0], [0.4], [0.3]);"
        "s = simulate(null_parameters(), drive, np.arange(0, 3, 0.05), (0, 0, 0));"
        "print(s.tobytes().hex()[-64:], sum(kernel(bare=True).run_many.stats.cache_misses.values()))"
    )
    outputs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in "ab"
    ]
    assert outputs[0].stdout.split()[0] == outputs[1].stdout.split()[0]
    assert outputs[1].stdout.split()[1] == "0"
