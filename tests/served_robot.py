"""A served robot in lockstep and the scenario that calibrates it, for tests and the benchmark."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager

from ros_rig import free_port

from fsm_calib.perception.encoded import encode_jpeg
from fsm_calib.robots.dtps.served_node import DtpsServedNode
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.runner.connecting import with_robot
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.world2d.robot import make_world


@contextmanager
def served_dtps(scenario: Scenario, **settings: float) -> Iterator[tuple[DtpsServedNode, Scenario]]:
    """Serve the scenario's robot behind a DTPS switchboard; yield it, and the scenario for a client."""
    robot, port = dataclasses.replace(ServeSettings(), **settings), free_port()
    node = DtpsServedNode(
        make_world(world_of(scenario)), robot, "127.0.0.1", port, "duckie", encode_jpeg, lockstep=True
    )
    try:
        yield node, for_client(scenario, f"dtps://127.0.0.1:{port}/duckie")
    finally:
        node.close()


def for_client(scenario: Scenario, address: str) -> Scenario:
    """Return the scenario of a client in lockstep."""
    real = with_robot(scenario, address).robot
    link = real.link.model_copy(update={"lockstep": True})
    return scenario.model_copy(update={"robot": real.model_copy(update={"link": link})})


@contextmanager
def served(scenario: Scenario, master: str, **settings: float) -> Iterator[tuple[ServedNode, Scenario]]:
    """Serve the scenario's robot; yield it, and the scenario for a client."""
    robot = dataclasses.replace(ServeSettings(), **settings)
    node = ServedNode(make_world(world_of(scenario)), robot, master, "duckie", encode_jpeg, lockstep=True)
    try:
        yield node, for_client(scenario, master.replace("http", "ros1") + "duckie")
    finally:
        node.close()
