"""Chooses the socket that a scenario names, and resumes what is behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np

from fsm_calib.errors import DataError, InputError
from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.robots.address import PORTS, RobotAddress, parse_address
from fsm_calib.robots.connection import Connection
from fsm_calib.robots.simulated import connect_simulated
from fsm_calib.runner.logged import LoggedCommand
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import WheelCommand
from fsm_calib.world2d.robot import World, WorldSpec

POSE_TOLERANCE = 1e-9
"""How far a world that was driven again may be from the journal [m, rad]: rounding of another machine."""


def connect(scenario: Scenario, spec: WorldSpec) -> Connection:
    """Return the connection to the scenario's robot, simulated or real.

    Raises
    ------
    InputError
        The world cannot be built, or the robot's address is incomplete.
    RobotLost
        A real robot does not answer, or must not be driven.
    """
    if scenario.robot.connect == "simulated":
        return connect_simulated(spec)
    raise InputError(f"no socket for {address_of(scenario)}", where="robot.connect")


def address_of(scenario: Scenario) -> RobotAddress:
    """Return where the scenario's real robot is reached."""
    section = scenario.robot
    vehicle = section.vehicle or section.name
    kind: Literal["ros1", "dtps"] = "dtps" if section.connect == "dtps" else "ros1"
    host = section.host or f"{vehicle}.local"
    return RobotAddress(kind, host, section.port or PORTS[kind], vehicle)


def with_robot(scenario: Scenario, text: str | None) -> Scenario:
    """Return the scenario for the real robot at the address `text`; as it is for None.

    Raises
    ------
    InputError
        `text` is no address.
    """
    if text is None:
        return scenario
    address = parse_address(text)
    found = {"connect": address.kind, "host": address.host, "port": address.port, "vehicle": address.vehicle}
    names = {} if "name" in scenario.robot.model_fields_set else {"name": address.vehicle}
    return scenario.model_copy(update={"robot": scenario.robot.model_copy(update=found | names)})


def drive_again(connection: Connection, world: World, directory: Path, state: dict[str, Any]) -> None:
    """Bring a new simulated world to where the journal ends, and check that it is there.

    Raises
    ------
    DataError
        The robot ends elsewhere than the journal says.
    """
    commands: list[LoggedCommand] = []
    pose: list[float] = []
    for event in read_journal(directory / JOURNAL_NAME):
        commands += [tuple(command) for command in event["commands"]]
        pose = event["pose"]
    log = [(time, WheelCommand(left, right)) for time, left, right in commands]
    world.robot.fast_forward(log, state["time"], state["frames"])
    error = float(np.abs(np.subtract(connection.pose(), pose)).max())
    if not error <= POSE_TOLERANCE:
        problem = f"driven again, the robot is {error:.3g} m or rad away from where the journal says"
        raise DataError(
            problem, cure="Run again without --resume; the journal was changed or is of another version."
        )
