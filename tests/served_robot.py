"""A served robot and the scenario that calibrates it, for tests and the benchmark."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from ros_rig import free_port

from fsm_calib.perception.encoded import encode_jpeg
from fsm_calib.robots.dtps.served_node import DtpsServedNode
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.runner.connecting import with_robot
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.world2d.robot import World, make_world


def need_dtps() -> None:
    """Skip where Duckietown's library is not installed."""
    pytest.importorskip("dtps", reason="dtps-http is not installed (pip install 'fsm-calib[dtps]')")
    pytest.importorskip("duckietown_messages", reason="duckietown-messages is not installed")


@contextmanager
def dtps_node(world: World, lockstep: bool, **settings: float) -> Iterator[tuple[DtpsServedNode, str]]:
    """Serve a world's robot behind a DTPS switchboard; yield it and its address."""
    robot, port = dataclasses.replace(ServeSettings(), **settings), free_port()
    node = DtpsServedNode(world, robot, "127.0.0.1", port, "duckie", encode_jpeg, lockstep)
    try:
        yield node, f"dtps://127.0.0.1:{port}/duckie"
    finally:
        node.close()


@contextmanager
def served_dtps(scenario: Scenario, **settings: float) -> Iterator[tuple[DtpsServedNode, Scenario]]:
    """Serve the scenario's robot behind a DTPS switchboard in lockstep; yield it, and the scenario for a client."""
    with dtps_node(make_world(world_of(scenario)), True, **settings) as (node, address):
        yield node, for_client(scenario, address)


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
