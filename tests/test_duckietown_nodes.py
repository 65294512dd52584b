"""A run against Duckietown's own wheel driver and kinematics node; skipped where their checkouts are not at hand."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import pytest
from duckietown_robot import CALIBRATION, DuckietownRobot, checkouts, duckietown_robot
from ros_rig import until
from served_robot import for_client

from fsm_calib.errors import EmergencyStopped
from fsm_calib.perception.encoded import encode_jpeg
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.guard.pwm import LARGEST, command_of
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.messages import BOOL, CLOCK, IMAGE, TEXT, TICK, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.robot import Ros1Robot
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.ros1.store import store_calibration
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.world import world_of
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.types import WheelCalibration, WheelCommand
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.robot import make_world

STANDING = [("left", 0), ("right", 0)]
"""What the motor board is told last of wheels that stand."""
LOST = 0.5
"""Longest wait for the motors to do what a command says [s]."""
SCENARIO = """
name: wheels
seed: 3
robot: {source: nominal, wheel_ratio: 1.05, name: duckie}
plan: [orientation, wheels]
output: {report: false, recording: false, bag: none, frames: 0}
"""


class Body(ServedNode):
    """The rest of the robot in lockstep: a simulated chassis, camera and encoders on their driver's motors.

    It hears the commands too, to know when the driver has obeyed: one that the driver's queue of one has lost is waited
    for `LOST`, and counts as taken.
    """

    motors: ClassVar[dict[str, int]] = {"left": 0, "right": 0}
    acknowledged = 0

    def _parameters(self) -> None:
        """The kinematics are their node's."""

    def _listen(self) -> None:
        self.node.subscribe(self.topics.step, TEXT, self._step)
        self.node.subscribe(self.topics.wheels, WHEELS, self._take)
        self.node.subscribe(self.topics.executed, WHEELS, self._hear)

    def _publish(self) -> None:
        self._image = self.node.publish(self.topics.image, IMAGE)
        self._stepped = self.node.publish(self.topics.stepped, TEXT)
        self._clock = self.node.publish("/clock", CLOCK)
        self._encoders = {
            side: self.node.publish(getattr(self.topics, f"{side}_tick"), TICK) for side in ("left", "right")
        }

    def turn(self, side: str, pwm: int) -> None:
        """The motor board sets a motor."""
        self.motors = {**self.motors, side: pwm}

    def _take(self, body: bytes) -> None:
        message = message_type(WHEELS).decode(body)
        wanted = {"left": pwm_of(float(message.vel_left)), "right": pwm_of(float(message.vel_right))}
        end = time.monotonic() + LOST
        while self.motors != wanted and time.monotonic() < end:
            time.sleep(0.001)
        levels = (self.motors[side] / LARGEST for side in ("left", "right"))
        self.station.take(WheelCommand(*(command_of(level) for level in levels)))

    def _hear(self, body: bytes) -> None:
        self.acknowledged = int(message_type(WHEELS).decode(body).header.seq)

    def _tell_step(self, said: str) -> None:
        super()._tell_step(json.dumps({**json.loads(said), "executed": self.acknowledged}))

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        """Their driver acknowledges."""


@pytest.fixture(scope="module")
def theirs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DuckietownRobot]:
    with duckietown_robot(checkouts(), tmp_path_factory.mktemp("duckiebot")) as robot:
        yield robot


@pytest.fixture
def ours(theirs: DuckietownRobot) -> Iterator[Ros1Robot]:
    camera = Node("/duckie/camera_node", theirs.master)
    camera.publish(Topics("duckie").image, IMAGE)
    robot = Ros1Robot(GuardSetup(parse_address(address_of(theirs)), fence=1000.0), lambda body: None)
    yield robot
    robot.close()
    camera.close()


def address_of(theirs: DuckietownRobot) -> str:
    return theirs.master.replace("http", "ros1") + "duckie"


def pwm_of(command: float) -> int:
    """Return the PWM that Duckietown's driver is known to make of a command."""
    return 0 if abs(command) <= 0.01 else round(math.copysign(math.floor(abs(command) * 195 + 60), command))


def test_their_driver_applies_the_commands_that_it_is_sent(theirs: DuckietownRobot, ours: Ros1Robot) -> None:
    theirs.pwm.clear()
    ours.run(WheelCommand(0.23, -0.31), 0.5)
    until(lambda: theirs.pwm[-2:] == STANDING, "the wheels stand")
    turning = {side: [pwm for name, pwm in theirs.pwm if name == side and pwm] for side in ("left", "right")}
    for side, command in (("left", 0.23), ("right", -0.31)):
        least = pwm_of(command)
        assert {abs(pwm) - abs(least) for pwm in turning[side]} <= {0, 1}
        mean = sum(turning[side]) / len(turning[side])
        assert abs(mean) - 60 == pytest.approx(abs(command) * 195, abs=0.2)
        assert mean * command > 0


def test_the_guard_counts_with_what_their_driver_acknowledges(
    theirs: DuckietownRobot, ours: Ros1Robot
) -> None:
    ours.run(WheelCommand(0.3, 0.3), 0.5)
    ours.wait(0.2)
    assert ours.guard.path[-1][1] > 0.05


def test_their_emergency_stop_ends_what_drives_and_releases_the_motors(
    theirs: DuckietownRobot, ours: Ros1Robot
) -> None:
    button = Node("/duckie/button", theirs.master)
    stop = button.publish(Topics("duckie").emergency_stop, BOOL)
    until(lambda: len(stop.listeners) >= 2, "driver and guard listen to the emergency stop")
    ours.command(WheelCommand(0.3, 0.3))
    until(lambda: theirs.pwm[-1][1] > 0, "the wheels turn")
    stop.publish(message_type(BOOL).stamped(time.time(), data=True))
    with pytest.raises(EmergencyStopped):
        ours.wait(10.0)
    until(lambda: theirs.pwm[-2:] == STANDING, "the wheels stand")
    stop.publish(message_type(BOOL).stamped(time.time(), data=False))
    button.close()


def test_a_calibration_is_saved_by_their_service_and_is_the_robots_after_its_next_start(
    theirs: DuckietownRobot,
) -> None:
    node = Node("/duckie/fsm_calib", theirs.master)
    found = WheelCalibration(wheel_ratio=1.0432)
    store_calibration(node, Topics("duckie"), None, found)
    assert (theirs.saved["gain"], theirs.saved["trim"]) == (found.gain, found.trim)
    theirs.end("kinematics_node")
    for name in ("gain", "trim"):
        theirs.caller.call("setParam", "/test", f"/duckie/kinematics_node/{name}", 0.5)
    theirs.start("kinematics_node")
    assert (theirs.parameter("gain"), theirs.parameter("trim")) == (found.gain, found.trim)
    node.close()


def test_what_their_service_saves_is_what_was_set_last(theirs: DuckietownRobot) -> None:
    node = Node("/duckie/fsm_calib", theirs.master)
    for ratio in (1.01, 1.02, 0.97):
        found = WheelCalibration(wheel_ratio=ratio)
        (theirs.card / CALIBRATION).unlink(missing_ok=True)
        store_calibration(node, Topics("duckie"), None, found)
        assert (theirs.saved["gain"], theirs.saved["trim"]) == (found.gain, found.trim)
    node.close()


@pytest.mark.slow
def test_a_run_through_their_nodes_calibrates_the_wheels_and_is_saved_on_their_card(tmp_path: Path) -> None:
    scenario = scenario_from(parse_yaml(SCENARIO))
    world = make_world(world_of(scenario))
    with duckietown_robot(checkouts(), tmp_path) as theirs:
        settings = ServeSettings(command_latency=0.0, command_jitter=0.0)
        body = Body(world, settings, theirs.master, "duckie", encode_jpeg, lockstep=True)
        theirs.turned = body.turn
        result = run_scenario(for_client(scenario, address_of(theirs)), tmp_path / "run").result
        body.close()
        assert result["outcome"] == "done", result
        until(lambda: theirs.pwm[-2:] == STANDING, "the wheels stand")
        saved, parameter = theirs.saved, theirs.parameter("trim")
    found = WheelCalibration(wheel_ratio=result["wheels"]["wheel_ratio"])
    assert abs(straight_deviation(world.truth.parameters, found.wheel_ratio)) < 0.10
    assert saved["trim"] == found.trim == parameter
