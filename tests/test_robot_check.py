"""An owner's first test of a robot, against the served one in real time; and the battery's word."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from ros_rig import small_master

from fsm_calib.errors import EmergencyStopped
from fsm_calib.perception.encoded import decode_image, encode_jpeg
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.battery import charge_of, refuse_flat
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.check import Check
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.types import STOP
from fsm_calib.world2d.robot import WorldSpec, make_world


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


def test_the_check_tells_every_figure_and_ends_with_the_wheels_at_zero() -> None:
    with small_master() as master:
        settings = ServeSettings(rate=5.0)
        node = ServedNode(make_world(WorldSpec()), settings, master, "duckie", encode_jpeg)
        check = Check(GuardSetup(parse_address(master.replace("http", "ros1") + "duckie")), decode_image)
        findings = {finding.name: finding for finding in check.findings()}
        check.close()
        node.close()
    assert list(findings) == ["camera_hz", "echo_s", "latency_s", "least_command", "stop_s"]
    assert all(finding.sentence for finding in findings.values())
    assert findings["echo_s"].value is not None
    assert findings["stop_s"].value is not None
    assert node.last_received == STOP
