"""A calibration through DTPS, against the server of Duckietown's own library; skipped where that is not installed."""

from __future__ import annotations

import socket
import sys
import threading
from contextlib import closing
from pathlib import Path
from queue import Queue

import pytest
from ros_rig import until
from served_robot import dtps_node, need_dtps, served_dtps

from fsm_calib.errors import InputError, LinkLost
from fsm_calib.perception.encoded import decode_image
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.dtps.library import message
from fsm_calib.robots.dtps.link import DtpsLink
from fsm_calib.robots.dtps.outlet import DtpsOutlet
from fsm_calib.robots.dtps.robot import DtpsRobot
from fsm_calib.robots.dtps.topics import NAMES
from fsm_calib.robots.guard.outlet import Event
from fsm_calib.robots.guard.pwm import Dither, command_of, floored, level_of
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.runner.connecting import with_robot
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.types import STOP, WheelCommand
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.robot import WorldSpec, make_world

ENTE = {"dead_zone": 0.2, "dropped": 0.1}


def scenario(plan: str = "[orientation, wheels]") -> Scenario:
    text = f"""
name: wheels
seed: 3
robot: {{source: nominal, wheel_ratio: 1.05}}
plan: {plan}
output: {{report: false, recording: false, bag: none, frames: 0}}
"""
    return scenario_from(parse_yaml(text))


@pytest.mark.parametrize("command", [0.012, 0.2, -0.23, 0.5, 0.999])
def test_the_level_that_a_driver_acknowledges_tells_the_command_that_was_sent(command: float) -> None:
    sent = Dither()(command)
    assert command_of(level_of(floored(sent))) == pytest.approx(sent, abs=1e-9)


def test_a_released_wheel_is_acknowledged_as_zero() -> None:
    assert command_of(level_of(floored(0.19, 0.2))) == 0.0


def test_a_wheels_run_through_the_librarys_own_server_is_done_within_10_cm(tmp_path: Path) -> None:
    need_dtps()
    with served_dtps(scenario(), **ENTE) as (node, client):
        finished = run_scenario(client, tmp_path)
        result, truth = finished.result, node.station.robot.world.truth
        assert result["outcome"] == "done", result
        assert abs(straight_deviation(truth.parameters, result["wheels"]["wheel_ratio"])) < 0.10
        assert node.station.last_received == STOP
    assert "true_" not in (tmp_path / "result.json").read_text()
    assert (tmp_path / "calibrations" / "kinematics" / "duckie.yaml").exists()


def test_a_robot_that_does_not_answer_is_a_lost_link(tmp_path: Path) -> None:
    need_dtps()
    with pytest.raises(LinkLost, match=r"127\.0\.0\.1"):
        run_scenario(with_robot(scenario(), "dtps://127.0.0.1:9/duckie"), tmp_path)


def test_another_vehicles_name_is_a_lost_link_that_names_it(tmp_path: Path) -> None:
    need_dtps()
    with served_dtps(scenario()) as (_, client):
        other = client.model_copy(update={"robot": client.robot.model_copy(update={"vehicle": "other"})})
        with pytest.raises(LinkLost, match="other has no sensor/camera"):
            run_scenario(other, tmp_path)


def test_without_the_library_the_cure_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "dtps", None)
    with pytest.raises(InputError, match=r"fsm-calib\[dtps\]"):
        run_scenario(with_robot(scenario(), "dtps://127.0.0.1:9/duckie"), tmp_path)


def test_a_guard_does_not_wait_until_a_command_is_taken() -> None:
    need_dtps()
    inbox: Queue[Event] = Queue()
    woken = threading.Event()
    with dtps_node(make_world(WorldSpec()), True) as (node, address):
        with closing(DtpsOutlet(GuardSetup(parse_address(address)), inbox)) as outlet:
            node.link._loop.call_soon_threadsafe(woken.wait)  # the switchboard hangs
            outlet.send(WheelCommand(0.2, 0.2))
            outlet.send(STOP)
            assert outlet.sent == 2
            woken.set()
            until(lambda: node.station.robot.taken == 2, "both commands have arrived")
        assert node.station.last_received == STOP
    assert "lost" not in {event[0] for event in inbox.queue}


def test_what_was_sent_has_left_when_a_guard_closes() -> None:
    need_dtps()
    with dtps_node(make_world(WorldSpec()), True) as (node, address):
        with closing(DtpsOutlet(GuardSetup(parse_address(address)), Queue())) as outlet:
            for number in range(5):
                outlet.send(WheelCommand(0.01 * number, 0.0))
        until(lambda: node.station.robot.taken == 5, "all five commands have arrived")
        assert node.station.last_received == WheelCommand(0.04, 0.0)


def test_a_switchboard_that_ends_is_a_lost_link_to_its_guard() -> None:
    need_dtps()
    inbox: Queue[Event] = Queue()
    with dtps_node(make_world(WorldSpec()), True) as (_, address):
        outlet = DtpsOutlet(GuardSetup(parse_address(address)), inbox)
    with closing(outlet):
        outlet.send(STOP)
        kind, why = inbox.get(timeout=60.0)
    assert kind == "lost"
    assert parse_address(address).url in why


def test_a_port_that_is_taken_is_told_with_another_ones_cure() -> None:
    need_dtps()
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(LinkLost, match="--port") as told:
        DtpsLink(f"create:http://127.0.0.1:{taken.getsockname()[1]}/", "duckie")
    assert "create:" not in str(told.value)


def test_a_message_that_cannot_be_read_disturbs_no_guard() -> None:
    need_dtps()
    with dtps_node(make_world(WorldSpec()), True) as (node, address):
        setup = GuardSetup(parse_address(address), LinkSettings(lockstep=True))
        with closing(DtpsRobot(setup, decode_image)) as robot:
            node.link.publisher(NAMES["executed"])(message("text")(data="no command"))
            robot.run(WheelCommand(0.2, 0.2), 0.1)
        assert node.station.robot.taken > 0


def test_messages_that_come_at_once_are_all_heard() -> None:
    need_dtps()
    heard: list[int] = []
    woken = threading.Event()
    with (
        dtps_node(make_world(WorldSpec()), True) as (node, address),
        closing(DtpsLink(parse_address(address).url, "duckie")) as client,
    ):
        client.subscribe(NAMES["left_tick"], "integer", lambda item: heard.append(item.data))
        client._loop.call_soon_threadsafe(woken.wait)  # the listener is busy
        send = node.link.publisher(NAMES["left_tick"])
        for number in range(100):
            send(message("integer")(data=number))
        woken.set()
        until(lambda: heard and heard[-1] == 99, "the last message has come")
    assert heard[-100:] == list(range(100))
