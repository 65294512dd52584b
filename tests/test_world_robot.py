"""The simulated robot behind its port."""

import math

import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.ports import Robot
from fsm_calib.types import STOP, Pose2, WheelCommand
from fsm_calib.world2d.deviation import small_deviation, straight_deviation
from fsm_calib.world2d.faults import (
    BlurredCamera,
    DeadWheel,
    DroppedFrames,
    FrozenFrames,
    MissingBoard,
    MissingMarkers,
    Obstacle,
)
from fsm_calib.world2d.fleet import FLEET, draw_robot, nominal_robot
from fsm_calib.world2d.lens import ray_table
from fsm_calib.world2d.robot import Wear, WorldSettings, WorldSpec, make_world
from fsm_calib.world2d.scene import SceneSpec, Wall

FORWARD = WheelCommand(0.25, 0.25)
BARE = SceneSpec()


def spin(robot, quanta=4):
    for _ in range(quanta):
        robot.command(WheelCommand(0.3, 0.0))
        robot.wait(0.1)
        robot.command(STOP)
        robot.wait(0.2)


def test_the_simulated_robot_fits_the_port():
    assert isinstance(make_world(WorldSpec(scene=BARE)).robot, Robot)


def test_there_is_no_public_way_from_the_port_to_the_truth():
    robot = make_world(WorldSpec(scene=BARE)).robot
    public = {name for name in dir(robot) if not name.startswith("_")}
    assert public == {
        "capture",
        "command",
        "command_log",
        "fast_forward",
        "frames_taken",
        "now",
        "run",
        "wait",
    }


def test_same_specification_gives_the_same_run_bit_for_bit():
    worlds = [make_world(WorldSpec(scene=BARE, seed=5)) for _ in range(2)]
    for world in worlds:
        spin(world.robot)
    assert worlds[0].truth.pose == worlds[1].truth.pose
    assert np.array_equal(worlds[0].robot.capture().image, worlds[1].robot.capture().image)


def test_another_seed_gives_another_run():
    worlds = [make_world(WorldSpec(scene=BARE, seed=seed)) for seed in (1, 2)]
    for world in worlds:
        spin(world.robot)
    assert worlds[0].truth.pose != worlds[1].truth.pose


def test_skipping_frames_changes_neither_motion_nor_later_frames():
    many, few = (make_world(WorldSpec(scene=BARE, seed=2)) for _ in range(2))
    for _ in range(3):
        many.robot.capture()
        spin(many.robot, 1)
    spin(few.robot, 3)
    few.robot.fast_forward((), few.robot.now(), frames=3)
    assert np.array_equal(many.robot.capture().image, few.robot.capture().image)


def test_a_logged_run_driven_again_ends_in_the_identical_state():
    spec = WorldSpec(scene=BARE, seed=4, wear=Wear(0.05), faults=(DeadWheel("left", 1.5),))
    first = make_world(spec)
    spin(first.robot, 3)
    first.robot.command(FORWARD)
    first.robot.wait(1.234)
    again = make_world(spec)
    again.robot.fast_forward(first.robot.command_log, first.robot.now(), first.robot.frames_taken)
    for world in (first, again):
        world.robot.wait(0.5)
    assert first.truth.pose == again.truth.pose
    assert first.truth.twist == again.truth.twist


def test_a_frozen_picture_is_the_same_after_fast_forward():
    spec = WorldSpec(scene=BARE, seed=4, faults=(FrozenFrames(0.5),))
    first = make_world(spec)
    spin(first.robot, 2)
    frozen = first.robot.capture()
    spin(first.robot, 1)
    again = make_world(spec)
    again.robot.fast_forward(first.robot.command_log, first.robot.now(), first.robot.frames_taken)
    assert np.array_equal(frozen.image, first.robot.capture().image)
    assert np.array_equal(frozen.image, again.robot.capture().image)


def test_fast_forward_refuses_a_log_that_lies_in_the_past():
    world = make_world(WorldSpec(scene=BARE))
    world.robot.wait(1.0)
    with pytest.raises(InputError, match="past"):
        world.robot.fast_forward([(0.5, STOP)], 2.0)


@pytest.mark.parametrize("duration", [-0.1, math.nan, math.inf])
def test_waits_that_make_no_sense_are_refused(duration):
    with pytest.raises(InputError):
        make_world(WorldSpec(scene=BARE)).robot.wait(duration)


@pytest.mark.parametrize("command", [WheelCommand(math.nan, 0.0), WheelCommand(0.0, math.inf)])
def test_commands_that_are_not_finite_are_refused(command):
    with pytest.raises(InputError):
        make_world(WorldSpec(scene=BARE)).robot.command(command)


@pytest.mark.parametrize("step", [0.0, -0.001, math.nan, 0.003])
def test_steps_that_the_physics_cannot_take_are_refused(step):
    with pytest.raises(InputError):
        WorldSettings(step=step)


def test_a_step_beyond_the_time_constants_is_refused_when_the_world_is_made():
    robot = draw_robot(np.random.default_rng(0))
    quick = type(robot)(robot.name, robot.camera, robot.mount, effects={"tau_forward": 0.006})
    with pytest.raises(InputError, match="longer than the physics allows"):
        make_world(WorldSpec(robot=quick, scene=BARE))


def test_commands_are_clipped_to_the_drivers_limit():
    robot = make_world(WorldSpec(scene=BARE)).robot
    robot.command(WheelCommand(3.0, -2.0))
    assert robot.command_log[-1][1] == WheelCommand(1.0, -1.0)


def test_equal_wheels_without_noise_drive_straight():
    world = make_world(WorldSpec(scene=BARE, settings=WorldSettings(drive_noise=0.0)))
    world.robot.command(FORWARD)
    world.robot.wait(3.0)
    assert world.truth.pose.x > 0.3
    assert abs(world.truth.pose.y) < 1e-9


def test_the_true_ratio_makes_an_unequal_robot_drive_straight():
    robot = draw_robot(np.random.default_rng(8))
    world = make_world(WorldSpec(robot=robot, scene=BARE, settings=WorldSettings(drive_noise=0.0)))
    world.robot.command(WheelCommand(0.25, 0.25 * world.truth.wheel_ratio))
    world.robot.wait(3.0)
    assert abs(world.truth.pose.y) < 1e-4


def test_a_dead_wheel_turns_the_robot_about_it():
    world = make_world(WorldSpec(scene=BARE, faults=(DeadWheel("left", 0.5),)))
    world.robot.wait(0.6)
    world.robot.command(FORWARD)
    world.robot.wait(1.0)
    assert world.truth.pose.theta > 0.5


def test_dropped_frames_do_not_arrive_after_the_fault_and_do_before():
    robot = make_world(WorldSpec(scene=BARE, faults=(DroppedFrames(0.5),))).robot
    assert robot.capture() is not None
    robot.wait(0.6)
    assert robot.capture() is None


def test_an_intact_camera_never_hands_out_the_same_picture_twice():
    robot = make_world(WorldSpec(scene=BARE)).robot
    assert not np.array_equal(robot.capture().image, robot.capture().image)


def test_a_wall_stops_the_robot():
    fault = Obstacle(Wall(0.3, -0.5, 0.3, 0.5), 0.1)
    world = make_world(WorldSpec(scene=BARE, faults=(fault,)))
    world.robot.command(FORWARD)
    world.robot.wait(4.0)
    assert world.truth.pose.x == pytest.approx(0.3 - 0.003 - 0.095, abs=1e-3)
    assert world.truth.is_touching


def test_a_robot_drives_over_a_board_on_the_floor_and_not_through_a_leaned_one():
    for lean, passes in ((math.pi / 2, True), (0.4, False)):
        board = type(WorldSpec().scene.boards[0])(x=0.45, lean=lean)
        world = make_world(WorldSpec(scene=SceneSpec(boards=(board,))))
        world.robot.command(WheelCommand(0.3, 0.3))
        world.robot.wait(4.0)
        assert (world.truth.pose.x > 0.5) == passes


def test_a_missing_board_leaves_the_scene_from_its_time_on():
    world = make_world(WorldSpec(faults=(MissingBoard(1, 0.5),)))
    before = len(world.truth.scene.spec.boards)
    world.robot.wait(0.6)
    assert len(world.truth.scene.spec.boards) == before - 1


def test_missing_markers_leave_the_others_where_they_were():
    world = make_world(WorldSpec(faults=(MissingMarkers((305, 306), 0.5),)))
    before = {marker.tag_id: marker for marker in world.truth.markers}
    world.robot.wait(0.6)
    after = {marker.tag_id: marker for marker in world.truth.markers}
    assert set(before) - set(after) == {305, 306}
    assert all(after[number] == before[number] for number in after)


def test_a_blurred_camera_loses_its_edges():
    world = make_world(WorldSpec(faults=(BlurredCamera(4.0, 0.5),)))
    sharp = world.robot.capture().image
    world.robot.wait(0.6)
    blurred = world.robot.capture().image
    steepest = [
        np.percentile(np.abs(np.diff(image[..., 1].astype(int), axis=1)), 99.5) for image in (sharp, blurred)
    ]
    assert steepest[1] < 0.5 * steepest[0]


def test_wear_moves_the_true_ratio_with_the_distance_up_to_its_limit():
    world = make_world(WorldSpec(scene=BARE, wear=Wear(0.1, 0.04)))
    world.robot.command(FORWARD)
    world.robot.wait(1.5)
    drifted = world.truth.wheel_ratio
    assert drifted == pytest.approx(1.0 + 0.1 * world.truth.odometer, abs=0.003)
    world.robot.wait(3.0)
    assert world.truth.wheel_ratio == pytest.approx(1.04)


def test_the_deviation_of_a_small_error_is_the_arc_of_the_closed_form():
    parameters = nominal_robot().parameters()
    for error in (0.002, -0.005):
        # right command larger by `error`: the left wheel is slower, e = (v_l - v_r) / v = -error
        expected = small_deviation(-error, 0.100)
        assert straight_deviation(parameters, 1.0 + error) == pytest.approx(expected, rel=0.04)


def test_the_true_ratio_deviates_by_less_than_a_millimetre():
    for seed in range(5):
        robot = draw_robot(np.random.default_rng(seed))
        assert abs(straight_deviation(robot.parameters(), robot.wheel_ratio)) < 1e-3


def test_drawn_robots_have_the_fleets_ratios_and_cameras_that_see_everywhere():
    robots = [draw_robot(np.random.default_rng(seed)) for seed in range(40)]
    ratios = np.array([robot.wheel_ratio for robot in robots])
    spread = FLEET["wheel_ratio"]
    assert np.all((ratios >= spread.low) & (ratios <= spread.high))
    assert 0.06 < ratios.std() < 0.14
    assert not any(ray_table(robot.camera).has_blind for robot in robots[:8])


def test_first_and_second_distortion_terms_of_the_fleet_are_anticorrelated():
    terms = np.array([draw_robot(np.random.default_rng(seed)).camera.distortion[:2] for seed in range(40)])
    assert np.corrcoef(terms.T)[0, 1] < -0.7


def test_the_start_pose_is_where_the_robot_begins():
    assert make_world(WorldSpec(scene=BARE, start=Pose2(0.1, -0.2, 0.3))).truth.pose == Pose2(0.1, -0.2, 0.3)
