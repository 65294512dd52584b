"""A node on the standard library: topics, services, parameters, with the small master and with Debian's."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import threading
from collections.abc import Iterator

import pytest
from ros_rig import DEADLINE, MASTERS, NO_ROS, debian_master, until

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.calls import Caller
from fsm_calib.robots.ros1.messages import (
    BOOL,
    EMPTY_SERVICE,
    MODE,
    TEXT,
    TICK,
    TWIST,
    WHEELS,
    message_type,
    set_camera_info_service,
    stamp_of,
)
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.publisher import Publisher
from fsm_calib.robots.ros1.wire import pack_header, unpack_header

MD5 = {
    WHEELS: "edbf8d24194d839b1982a6a991b552c6",
    TICK: "141b74ec2cc3bde8c38b5e3bdb694d12",
    BOOL: "542e22b190dc8e6eb476d50dda88feb7",
    TWIST: "3fc0942a3082e78d7ded4a58ea1e2d0c",
    MODE: "3c94938238cecfe40fdf747aae8abbaa",
    TEXT: "992ce8a1687cec8c8bd883ec73ca41d1",
}


@pytest.fixture(params=MASTERS)
def master(request: pytest.FixtureRequest) -> Iterator[str]:
    with MASTERS[request.param]() as url:
        yield url


@pytest.fixture
def nodes(master: str) -> Iterator[tuple[Node, Node]]:
    pair = Node("/a", master), Node("/b", master)
    yield pair
    for node in pair:
        node.close()


@pytest.mark.parametrize("name", MD5)
def test_types_have_the_md5_that_duckietowns_nodes_know(name: str) -> None:
    assert message_type(name).md5 == MD5[name]


def test_services_have_the_md5_that_ros_knows() -> None:
    assert EMPTY_SERVICE.md5 == "d41d8cd98f00b204e9800998ecf8427e"
    assert set_camera_info_service().md5 == "bef1df590ed75ed1f393692395e15482"


def test_a_header_comes_back_as_it_went() -> None:
    fields = {"callerid": "/a", "md5sum": "*", "message_definition": "float32 a = b\n"}
    assert unpack_header(pack_header(fields)[4:]) == fields


def test_bytes_that_are_no_header_are_a_lost_link() -> None:
    with pytest.raises(LinkLost, match="no ROS header"):
        unpack_header(b"\x05\x00\x00\x00hello")


def test_a_publisher_that_does_not_answer_at_once_is_asked_again(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    class Busy(Caller):
        def call(self, name: str, *arguments: object) -> object:
            asked.append(name)
            if len(asked) == 1:
                raise LinkLost("a publisher does not answer")
            return super().call(name, *arguments)

    monkeypatch.setattr("fsm_calib.robots.ros1.subscriber.Caller", Busy)
    publisher = nodes[0].publish("/wheels", WHEELS)
    nodes[1].subscribe("/wheels", WHEELS, lambda body: None)
    until(lambda: publisher.listeners == ("/b",), "the listener is connected")
    assert asked == ["requestTopic", "requestTopic"]


def test_a_message_arrives_whoever_comes_first(nodes: tuple[Node, Node]) -> None:
    heard: list[bytes] = []
    kind = message_type(WHEELS)
    nodes[1].subscribe("/wheels", WHEELS, heard.append)
    publisher = nodes[0].publish("/wheels", WHEELS)
    until(lambda: publisher.listeners == ("/b",), "the listener is connected")
    assert publisher.publish(kind.stamped(12.5, 3, vel_left=0.25, vel_right=-0.5)) == 1
    until(lambda: heard, "the message arrives")
    message = kind.decode(heard[0])
    assert (stamp_of(message), message.header.seq, message.vel_left, message.vel_right) == (
        12.5,
        3,
        0.25,
        -0.5,
    )


def test_what_is_published_once_a_listener_was_greeted_reaches_it() -> None:
    publisher = Publisher("/state", message_type(TEXT), latch=False)
    with socket.create_server(("127.0.0.1", 0)) as server:
        theirs = socket.create_connection(server.getsockname())
        ours, _ = server.accept()
    late = threading.Thread(target=publisher.take, args=("/b", ours, b"welcome"))
    late.start()
    assert theirs.recv(7) == b"welcome"
    assert publisher.publish(message_type(TEXT).make(data="scan")) == 1
    late.join()
    publisher.close()
    theirs.close()


def test_a_latched_message_waits_for_its_listener(nodes: tuple[Node, Node]) -> None:
    heard: list[bytes] = []
    kind = message_type(TEXT)
    nodes[0].publish("/state", TEXT, latch=True).publish(kind.make(data="scan"))
    nodes[1].subscribe("/state", TEXT, heard.append)
    until(lambda: heard, "the latched message arrives")
    assert kind.decode(heard[0]).data == "scan"


def test_another_type_is_refused_with_its_topic(nodes: tuple[Node, Node]) -> None:
    nodes[0].publish("/wheels", WHEELS)
    subscriber = nodes[1].subscribe("/wheels", TWIST, lambda body: None)
    until(lambda: subscriber.refused, "the publisher refuses")
    assert "/wheels" in subscriber.refused


def test_a_listener_hears_that_its_publisher_has_gone(nodes: tuple[Node, Node]) -> None:
    lost: list[bool] = []
    publisher = nodes[0].publish("/wheels", WHEELS)
    nodes[1].subscribe("/wheels", WHEELS, lambda body: None, lambda: lost.append(True))
    until(lambda: publisher.listeners, "the listener is connected")
    nodes[0].close()
    until(lambda: lost, "the listener is told")


def test_a_service_answers_and_a_refusal_says_why(nodes: tuple[Node, Node]) -> None:
    def serve(request: bytes) -> bytes:
        if request == b"no":
            raise LinkLost("the disk is full")
        return request[::-1]

    nodes[0].offer("/turn", EMPTY_SERVICE, serve)
    assert nodes[1].call_service("/turn", EMPTY_SERVICE, b"abc") == b"cba"
    with pytest.raises(LinkLost, match="the disk is full"):
        nodes[1].call_service("/turn", EMPTY_SERVICE, b"no")
    with pytest.raises(LinkLost, match="lookupService"):
        nodes[1].call_service("/nobody", EMPTY_SERVICE, b"")


def test_parameters_and_publishers_are_known_to_the_master(nodes: tuple[Node, Node]) -> None:
    nodes[0].master.call("setParam", "/a", "/duckie/kinematics_node/trim", -0.0181)
    assert nodes[1].master.call("getParam", "/b", "/duckie/kinematics_node/trim") == -0.0181
    nodes[0].publish("/wheels", WHEELS)
    assert nodes[1].publishers_of("/wheels") == ("/a",)
    nodes[0].close()
    assert nodes[1].publishers_of("/wheels") == ()


def test_a_master_that_does_not_answer_is_a_lost_link_with_a_cure() -> None:
    with pytest.raises(LinkLost, match=r"the ROS master at http://127\.0\.0\.1:1/ does not answer") as caught:
        Node("/a", "http://127.0.0.1:1/")
    assert "network" in caught.value.cure


def test_ros_own_tools_see_and_hear_the_node() -> None:
    if shutil.which("rostopic") is None:
        pytest.skip(NO_ROS)
    with debian_master() as url:
        node = Node("/duckie/fsm_calib", url)
        state = node.publish("/duckie/fsm_calib/state", TEXT, latch=True)
        state.publish(message_type(TEXT).make(data="scan/clockwise"))
        tools = {**os.environ, "ROS_MASTER_URI": url, "ROS_HOSTNAME": "127.0.0.1"}
        ran = [
            subprocess.run(command, env=tools, capture_output=True, text=True, timeout=DEADLINE).stdout
            for command in (
                ["rostopic", "echo", "-n", "1", "/duckie/fsm_calib/state"],
                ["rosnode", "info", "/duckie/fsm_calib"],
            )
        ]
        node.close()
    assert "scan/clockwise" in ran[0]
    assert "/duckie/fsm_calib/state [std_msgs/String]" in ran[1]
