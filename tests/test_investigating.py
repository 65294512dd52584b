"""What the robot does in an investigation: being seen, driving a plan inside the area, coming back."""

import math

import pytest

from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.investigating import (
    Findings,
    InvestigationBench,
    drive_plan,
    localise,
    look_around,
    return_step,
)
from fsm_calib.types import STOP

RATE = 20.0


class RollingRobot:
    """An ideal robot that a tracker sees: 0.5 m/s at command 1, wheels 0.1 m apart; a robot, clock and tracker."""

    def __init__(self, x=0.0, y=0.0, theta=0.0, seen=True):
        self.pose, self.time, self.held, self.seen = [x, y, theta], 0.0, STOP, seen
        self.rows = []

    def command(self, command):
        self.held = command

    def now(self):
        return self.time

    def wait(self, duration):
        for _ in range(round(duration * 100)):
            v = 0.25 * (self.held.left + self.held.right)
            self.pose[0] += 0.01 * v * math.cos(self.pose[2])
            self.pose[1] += 0.01 * v * math.sin(self.pose[2])
            self.pose[2] += 0.01 * 5.0 * (self.held.right - self.held.left)
            self.time = round(self.time + 0.01, 6)
            if self.seen and round(self.time * 100) % 5 == 0:
                self.rows.append((self.time, *self.pose))

    def poses(self):
        rows, self.rows = self.rows, []
        return rows


def bench_of(robot, **asked):
    settings = InvestigateSettings(**asked)

    def clearance(x, y):
        return min(1.0 - abs(x), 1.0 - abs(y))

    return InvestigationBench(robot, tracker=robot, asked=settings, clearance=clearance)


def test_robot_is_where_the_tracker_sees_it():
    bench = bench_of(RollingRobot(0.2, -0.1, 0.3))
    outcome = localise(bench)
    assert outcome.trigger == "localised"
    assert outcome.evidence["roomy"]
    assert bench.findings.pose == pytest.approx((0.2, -0.1, 0.3))


def test_robot_near_the_edge_has_no_room():
    assert not localise(bench_of(RollingRobot(0.8, 0.0))).evidence["roomy"]


def test_robot_that_nobody_sees_is_an_outcome():
    assert localise(bench_of(RollingRobot(seen=False))).trigger == "pose_missing"


def test_plan_is_driven_and_kept():
    bench = bench_of(RollingRobot())
    bench.findings.holds = [(1.0, 0.4, 0.4), (0.5, 0.0, 0.0)]
    outcome = drive_plan(bench)
    assert outcome.trigger == "drive_finished"
    drive = bench.findings.drives[0]
    assert drive.poses[-1][1] == pytest.approx(0.2, abs=0.01)
    assert [pair[1:] for pair in drive.commands][2] == (0.4, 0.4)
    assert bench.findings.distance == pytest.approx(0.2, abs=0.03)


def test_drive_stops_before_the_edge():
    robot = RollingRobot(0.5, 0.0)
    bench = bench_of(robot, stop_margin=0.13)
    bench.findings.holds = [(5.0, 0.6, 0.6)]
    assert drive_plan(bench).trigger == "drive_cut"
    assert bench.findings.drives[0].cut
    assert robot.pose[0] < 0.9
    assert robot.held == STOP


def test_drive_without_a_pose_is_stopped():
    robot = RollingRobot(seen=False)
    bench = bench_of(robot)
    bench.findings.holds = [(9.0, 0.3, 0.3)]
    assert drive_plan(bench).trigger == "pose_missing"
    assert robot.now() < 4.0
    assert robot.held == STOP


@pytest.mark.parametrize("theta", [0.0, 1.5, 3.0, -2.0])
def test_robot_comes_back_to_the_middle(theta):
    robot = RollingRobot(0.85, 0.8, theta)
    bench = bench_of(robot)
    for _ in range(8):
        if localise(bench).evidence["roomy"]:
            break
        return_step(bench)
    assert math.hypot(*robot.pose[:2]) < 0.9
    assert localise(bench).evidence["roomy"]


def test_findings_survive_a_checkpoint():
    bench = bench_of(RollingRobot())
    bench.findings.holds = [(1.0, 0.4, 0.4)]
    drive_plan(bench)
    assert Findings.from_state(bench.to_state()["findings"]) == bench.findings


def test_robot_in_the_middle_turns_to_another_heading():
    robot = RollingRobot(0.02, 0.0, 0.0)
    bench = bench_of(robot)
    localise(bench)
    return_step(bench)
    assert abs(math.remainder(robot.pose[2], math.tau)) > 0.5
    assert math.hypot(robot.pose[0] - 0.02, robot.pose[1]) < 0.05


def test_robot_that_sees_no_marker_turns_and_one_under_a_tracker_waits():
    looking, watched = RollingRobot(), RollingRobot()
    look_around(bench_of(looking, poses="camera"))
    look_around(bench_of(watched))
    assert abs(looking.pose[2]) > 0.2
    assert watched.pose[2] == 0.0
