"""Whatever fails, the wheels stop: the zero arrives at the driver within 0.3 s."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Queue

import pytest
from processes import is_alive
from ros_rig import answers, free_port, small_master, until

from fsm_calib.errors import EmergencyStopped, LinkLost
from fsm_calib.robots.address import RobotAddress, parse_address
from fsm_calib.robots.guard.client import GuardClient
from fsm_calib.robots.guard.process import Guard
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.messages import BOOL, IMAGE, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.robot import Ros1Robot
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.types import WheelCommand

LIMIT = 0.3
"""The wheels' time to zero [s]."""
ATTEMPTS = 4
"""What else the machine does can only lengthen a time: one attempt of so many must be within the limit."""
PROGRAM = Path(__file__).parent / "guarded_program.py"


class Driver:
    """A wheel driver as Duckietown's: no watchdog; acknowledges what it gets, and keeps when."""

    def __init__(self, master: str) -> None:
        self.topics = Topics("duckie")
        self.node = Node("/duckie/wheels_driver_node", master)
        self.echo = self.node.publish(self.topics.executed, WHEELS)
        self.node.publish(self.topics.image, IMAGE)
        self.moving = False
        self.changes: list[float] = []
        self.acknowledges = True
        self.node.subscribe(self.topics.wheels, WHEELS, self.take)

    def take(self, body: bytes) -> None:
        message = message_type(WHEELS).decode(body)
        moving = message.vel_left != 0.0 or message.vel_right != 0.0
        if moving != self.moving:
            self.changes.append(time.monotonic())
            self.moving = moving
        if self.acknowledges:
            self.echo.publish(message)


@pytest.fixture
def rig() -> Iterator[tuple[Driver, str]]:
    with small_master() as url:
        driver = Driver(url)
        yield driver, url
        driver.node.close()


class Program:
    """The driving program in a process of its own."""

    def __init__(self, url: str, *options: str) -> None:
        address = url.replace("http", "ros1") + "duckie"
        self.process = subprocess.Popen(
            [sys.executable, str(PROGRAM), address, *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        )
        self.lines: list[dict] = []
        threading.Thread(target=self._read, daemon=True).start()
        until(lambda: self.lines, "the program drives")
        self.guard = self.lines[0]["guard"]

    def _read(self) -> None:
        for text in self.process.stdout or ():
            self.lines.append(json.loads(text))

    def end(self) -> None:
        """End it and see its guard leave, which the next one's guard would take for a second driver."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.guard, signal.SIGCONT)
        for number in (signal.SIGCONT, signal.SIGKILL):
            self.process.send_signal(number)
        self.process.wait()
        until(lambda: not is_alive(self.guard), "the guard of an ended program ends")


@contextmanager
def driving(driver: Driver, url: str, *options: str) -> Iterator[Program]:
    """A program of its own that has turned the wheels."""
    before = len(driver.changes)
    program = Program(url, *options)
    try:
        until(lambda: len(driver.changes) > before, "the wheels turn")
        yield program
    finally:
        program.end()


def stop_time(driver: Driver, fail: Callable[[], object]) -> float:
    """Return how long after a failure the driver got its zero [s]; fails when it never does.

    Infinite where it had its zero before: the machine let the program starve, for which the guard stops it, too.
    """
    began = time.monotonic()
    fail()
    until(lambda: not driver.moving, "the wheels stop")
    return driver.changes[-1] - began if driver.changes[-1] > began else math.inf


def is_in_time(driver: Driver, url: str, fail: Callable[[Program], object], told: str = "") -> bool:
    """Tell whether the wheels stop within the limit after a failure; each attempt has a program of its own.

    `told` is the error that the program must hear of.
    """
    for _ in range(ATTEMPTS):
        with driving(driver, url) as program:
            seconds = stop_time(driver, lambda program=program: fail(program))
            if told:
                until(lambda program=program: len(program.lines) > 1, "the program is told")
            if seconds < LIMIT and (not told or program.lines[1]["lost"] == told):
                return True
    return False


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL, signal.SIGSTOP])
def test_the_wheels_stop_when_the_program_gets_a_signal(
    rig: tuple[Driver, str], number: signal.Signals
) -> None:
    assert is_in_time(*rig, lambda program: program.process.send_signal(number))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL, signal.SIGSTOP])
def test_the_wheels_stop_when_the_guard_gets_a_signal(
    rig: tuple[Driver, str], number: signal.Signals
) -> None:
    assert is_in_time(*rig, lambda program: os.kill(program.guard, number), told="LinkLost")


class Told:
    """A guard's outlet that notes when it sends, among what the guard tells."""

    def __init__(self) -> None:
        self.order: list[str] = []

    def send(self, command: WheelCommand) -> None:
        self.order.append("sent")

    def tell(self, line: dict) -> None:
        if "alive" in line:
            self.order.append("told")


@pytest.mark.parametrize(("command", "order"), [(0.3, ["told", "sent"]), (0.0, ["sent", "told"])])
def test_a_guard_that_is_halted_between_telling_and_sending_counts_as_one_that_turns_the_wheels(
    monkeypatch: pytest.MonkeyPatch, command: float, order: list[str]
) -> None:
    outlet = Told()
    monkeypatch.setattr("fsm_calib.robots.guard.process.tell", outlet.tell)
    guard = Guard(GuardSetup(parse_address("ros1://127.0.0.1:1/duckie")), outlet, Queue())
    guard.take(("line", ["hold", command, command]), 0.0)
    guard.send(0.0)
    assert outlet.order == order


def test_a_program_that_drives_is_told_that_its_guard_was_halted_while_the_wheels_stood(
    rig: tuple[Driver, str],
) -> None:
    address = parse_address(rig[1].replace("http", "ros1") + "duckie")
    guard = GuardClient(GuardSetup(address), lambda: None)
    os.kill(guard.pid, signal.SIGSTOP)
    guard.send("hold", 0.3, 0.3)
    with pytest.raises(LinkLost, match="hangs"):
        guard.rest(60.0)
    guard.close()


def test_the_wheels_stop_when_a_robot_whose_guard_has_died_is_closed_at_once(rig: tuple[Driver, str]) -> None:
    driver, url = rig
    address = parse_address(url.replace("http", "ros1") + "duckie")
    robot = Ros1Robot(GuardSetup(address, fence=1000.0), lambda body: None)
    robot.command(WheelCommand(0.3, 0.3))
    until(lambda: driver.moving, "the wheels turn")
    os.kill(robot.guard.pid, signal.SIGKILL)
    robot.close()
    until(lambda: not driver.moving, "the wheels stop", deadline=30.0)


def test_the_wheels_stop_when_the_program_computes_for_ever(rig: tuple[Driver, str]) -> None:
    with driving(*rig, "hang"):
        until(lambda: not rig[0].moving, "the wheels stop")


def test_the_wheels_stop_at_an_emergency_stop(rig: tuple[Driver, str]) -> None:
    driver, url = rig
    button = driver.node.publish(driver.topics.estop, BOOL)
    pressed = message_type(BOOL).stamped(0.0, data=True)

    def press(program: Program) -> None:
        until(lambda: button.publish(pressed), "the guard hears the button")

    assert is_in_time(driver, url, press, told="EmergencyStopped")


def test_the_wheels_stop_when_somebody_else_drives(rig: tuple[Driver, str]) -> None:
    driver, url = rig
    foreign = message_type(WHEELS).stamped(0.0, vel_left=-0.7, vel_right=0.7)
    assert is_in_time(driver, url, lambda program: driver.echo.publish(foreign), told="EmergencyStopped")


def test_the_wheels_stop_when_the_driver_acknowledges_nothing_any_more(rig: tuple[Driver, str]) -> None:
    with driving(*rig):
        rig[0].acknowledges = False
        until(lambda: not rig[0].moving, "the wheels stop")


def master_of_its_own() -> tuple[subprocess.Popen[bytes], Driver, str]:
    """Return a master's process, a driver that it knows, and its address."""
    port = free_port()
    text = f"from fsm_calib.robots.ros1.master import Master; Master('127.0.0.1', {port}); input()"
    search = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    master = subprocess.Popen([sys.executable, "-c", text], stdin=subprocess.PIPE, env=search)
    url = f"http://127.0.0.1:{port}/"
    until(lambda: answers(url), "the master answers")
    return master, Driver(url), url


def test_the_wheels_stop_when_the_master_is_killed() -> None:
    seconds = []
    while len(seconds) < ATTEMPTS and min(seconds, default=LIMIT) >= LIMIT:
        master, driver, url = master_of_its_own()
        try:
            with driving(driver, url):
                seconds.append(stop_time(driver, master.kill))
        finally:
            master.kill()
            master.wait()
    assert min(seconds) < LIMIT


def test_a_second_publisher_of_wheel_commands_is_refused_by_its_name(rig: tuple[Driver, str]) -> None:
    driver, url = rig
    joystick = Node("/duckie/joystick", url)
    joystick.publish(driver.topics.wheels, WHEELS)
    port = int(url.rstrip("/").rsplit(":", 1)[1])
    with pytest.raises(EmergencyStopped, match="/duckie/joystick publishes wheel commands"):
        GuardClient(GuardSetup(RobotAddress("ros1", "127.0.0.1", port, "duckie")), lambda: None)
    joystick.close()


def test_a_timed_push_is_as_long_as_it_was_asked(rig: tuple[Driver, str]) -> None:
    driver, url = rig
    port = int(url.rstrip("/").rsplit(":", 1)[1])
    errors = []
    while len(errors) < ATTEMPTS and min(errors, default=1.0) >= 0.05:
        before = len(driver.changes)
        guard = GuardClient(GuardSetup(RobotAddress("ros1", "127.0.0.1", port, "duckie")), lambda: None)
        with contextlib.suppress(LinkLost):  # a starved guard counts as hung
            guard.ask("run", 0.3, 0.0, 0.1, timeout=60.0)
        guard.close()
        until(lambda before=before: len(driver.changes) == before + 2, "the push begins and ends")
        errors.append(abs(driver.changes[-1] - driver.changes[-2] - 0.1))
    assert min(errors) < 0.05
