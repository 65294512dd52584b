"""An owner's first test of a robot, against the served one in real time; and the battery's word."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from ros_rig import small_master, until

from fsm_calib.errors import EmergencyStopped, RobotLost
from fsm_calib.perception.encoded import decode_image, encode_jpeg
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.battery import charge_of, refuse_flat
from fsm_calib.robots.check import Check, Finding
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.types import STOP
from fsm_calib.world2d.robot import WorldSpec, make_world

ATTEMPTS = 4
"""A robot in real time needs a machine that lets it live: one check of so many must come to its end."""


@pytest.fixture(params=[9, 80])
def health(request: pytest.FixtureRequest) -> Iterator[tuple[int, int]]:
    """A robot's health service that tells a charge; yields its port and the charge."""

    class Health(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(json.dumps({"percentage": request.param}).encode())

        def log_message(self, *arguments: object) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Health)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server.server_address[1], request.param
    server.shutdown()
    server.server_close()


def test_a_flat_battery_is_refused_and_a_full_one_is_not(health: tuple[int, int]) -> None:
    port, charge = health
    assert charge_of("127.0.0.1", port) == charge
    if charge > 15:
        refuse_flat("127.0.0.1", 15.0, port)
        return
    with pytest.raises(EmergencyStopped, match="The battery is at 9 %"):
        refuse_flat("127.0.0.1", 15.0, port)


def test_a_robot_that_tells_no_charge_is_let_through() -> None:
    assert charge_of("127.0.0.1", 1) is None
    refuse_flat("127.0.0.1", 15.0, 1)


def checked() -> list[Finding]:
    """Return what the check finds, as far as it comes; the wheels stand then.

    The robot lives in real time: where the machine lets it starve, its guard may stop it for good.
    """
    found: list[Finding] = []
    with small_master() as master, ExitStack() as ended:
        node = ServedNode(make_world(WorldSpec()), ServeSettings(rate=5.0), master, "duckie", encode_jpeg)
        ended.callback(node.close)
        address = parse_address(master.replace("http", "ros1") + "duckie")
        with suppress(RobotLost):
            check = Check(GuardSetup(address, LinkSettings(quiet=10.0, echo=10.0)), decode_image)
            with closing(check):
                found.extend(check.findings())
        until(lambda: node.last_received == STOP, "the wheels stand")
    return found


def test_the_check_tells_every_figure_and_ends_with_the_wheels_at_zero() -> None:
    for _ in range(ATTEMPTS):
        found = checked()
        figures = {finding.name: finding for finding in found}
        if {"echo_s", "stop_s"} <= {name for name, finding in figures.items() if finding.value is not None}:
            break
    assert list(figures) == ["camera_hz", "echo_s", "latency_s", "least_command", "stop_s"]
    assert all(finding.sentence for finding in found)
    assert figures["echo_s"].value is not None
    assert figures["stop_s"].value is not None
