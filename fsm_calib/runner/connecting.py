"""Chooses the socket that a scenario names, and resumes what is behind it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fsm_calib.errors import DataError, InputError, RobotLost
from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.outcome import Outcome
from fsm_calib.perception.encoded import decode_colour
from fsm_calib.robots.address import PORTS, RobotAddress, parse_address
from fsm_calib.robots.connection import Connection
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.simulated import connect_simulated
from fsm_calib.runner.logged import LoggedCommand
from fsm_calib.runner.progress import Observer
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import WheelCommand
from fsm_calib.world2d.outlines import scene_corners
from fsm_calib.world2d.robot import World, WorldSpec

POSE_TOLERANCE = 1e-9
"""How far a world that was driven again may be from the journal [m, rad]: rounding of another machine."""


FENCE_MARGIN = 1.0
"""From the area's farthest point to the fence [m]: dead reckoning from encoders is good to some 2 % of the way."""


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
    refuse_truth(scenario)
    link = scenario.robot.link.build()
    setup = GuardSetup(address_of(scenario), link, link.fence or farthest(spec), spec.start)
    if setup.address.kind == "ros1":
        from fsm_calib.robots.ros1.connect import connect_ros1

        return connect_ros1(setup, decode_colour)
    from fsm_calib.robots.dtps.connect import connect_dtps

    return connect_dtps(setup, decode_colour)


def refuse_truth(scenario: Scenario) -> None:
    """Refuse to teach a real robot what only a simulation knows.

    Raises
    ------
    InputError
        The scenario says that the camera, or a drifted wheel ratio, is known.
    """
    known = scenario.robot.known
    if known.camera or known.ratio_drift is not None:
        name = "camera" if known.camera else "ratio_drift"
        raise InputError(
            "only a simulated robot's truth can be known beforehand",
            where=f"robot.known.{name}",
            cure="Leave it out and plan focus and scan too; known.wheel_ratio may be given.",
        )


def farthest(spec: WorldSpec) -> float:
    """Return how far from the start anything of the area is, and a margin [m]: where the fence stands."""
    points = np.vstack([np.empty((0, 2)), *scene_corners(spec.scene)])
    away = np.hypot(points[:, 0] - spec.start.x, points[:, 1] - spec.start.y)
    return float(away.max(initial=0.0)) + FENCE_MARGIN


class Told:
    """An observer that also tells a real robot's network what happens.

    Parameters
    ----------
    observer : Observer
        Who watches here.
    connection : Connection
        Who is told there.
    """

    def __init__(self, observer: Observer, connection: Connection) -> None:
        self._observer, self._connection = observer, connection

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        """Pass an event on; see `progress.Observer`."""
        self._observer.event(state, phase, outcome, time)
        trigger, sentence = (outcome.trigger, outcome.sentence) if outcome else ("", "")
        event = {"time": time, "path": state, "phase": phase, "trigger": trigger, "sentence": sentence}
        with suppress(RobotLost):  # the run itself learns of it at its next call
            self._connection.tell(event)


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
