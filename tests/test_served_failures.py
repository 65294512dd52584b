"""A calibration of a served robot that something stops in every phase that drives, and that goes on each time."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros_rig import small_master, until
from served_robot import served

from fsm_calib.outcome import Outcome
from fsm_calib.robots.ros1.messages import BOOL, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.runner.progress import Silent
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.types import STOP
from fsm_calib.world2d.deviation import straight_deviation

CALIBRATION = """
name: stopped
seed: 2
robot: {source: fleet, name: duckie}
plan: [focus, scan, orientation, wheels, exit, lane]
output: {report: false, recording: false, bag: none, frames: 0}
"""
Failure = Callable[[], object]


class Phase(Silent):
    """Knows which phase a run is in."""

    def __init__(self) -> None:
        self.now = ""

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        self.now = phase


@contextmanager
def failing(phase: str, observer: Phase, node: ServedNode, fail: Failure) -> Iterator[None]:
    """Let something fail once, when the wheels turn in a phase."""
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(0.0005):
            if observer.now == phase and node.last_received != STOP:
                fail()
                return

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def guards_of_this_process() -> list[int]:
    """Return the process numbers of the guards that this process has started and that live."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            command, status = (entry / "cmdline").read_bytes(), (entry / "status").read_text()
        except (OSError, ValueError):
            continue
        if b"fsm_calib.robots.guard.process" in command and f"PPid:\t{os.getpid()}\n" in status:
            found.append(int(entry.name))
    return found


def drive_it_too(master: str, topic: str) -> None:
    """Drive the wheels from another node, which then leaves."""
    joystick = Node("/joystick", master)
    stick = joystick.publish(topic, WHEELS)
    pushed = message_type(WHEELS).stamped(0.0, vel_left=0.5, vel_right=-0.5)
    until(lambda: stick.publish(pushed), "the driver hears the joystick")
    joystick.close()


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="finds the guard's process in /proc")
@pytest.mark.slow
def test_a_run_that_is_stopped_in_every_phase_stands_still_and_goes_on_to_its_end(tmp_path: Path) -> None:
    scenario = scenario_from(parse_yaml(CALIBRATION))
    with small_master() as master, served(scenario, master) as (node, client):
        bystander = Node("/bystander", master)
        button = bystander.publish(node.topics.estop, BOOL)
        pressed = message_type(BOOL).stamped(0.0, data=True)

        def press() -> None:
            until(lambda: button.publish(pressed), "the guard hears the button")

        failures: tuple[tuple[str, Failure, str], ...] = (
            ("scan", lambda: os.kill(guards_of_this_process()[0], signal.SIGKILL), "LinkLost"),
            ("orientation", press, "EmergencyStopped"),
            ("wheels", lambda: drive_it_too(master, node.topics.wheels), "EmergencyStopped"),
            ("exit", lambda: os.kill(guards_of_this_process()[0], signal.SIGTERM), "LinkLost"),
            ("lane", lambda: os.kill(os.getpid(), signal.SIGTERM), ""),
        )
        for number, (phase, fail, name) in enumerate(failures):
            observer = Phase()
            with failing(phase, observer, node, fail):
                result = run_scenario(client, tmp_path, resume=number > 0, observer=observer).result
            assert (phase, result["outcome"], result.get("lost", {}).get("name", "")) == (
                phase,
                "aborted",
                name,
            )
            until(lambda: node.last_received == STOP, f"the wheels stand in {phase}")
        finished = run_scenario(client, tmp_path, resume=True)
        notebook = finished.session.run.bench.notebook
        assert finished.result["outcome"] == "done"
        assert abs(straight_deviation(node.robot.world.truth.parameters, notebook.wheel_ratio)) < 0.10
        bystander.close()
