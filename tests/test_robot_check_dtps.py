"""An owner's first test of a robot with DTPS, against the served one in real time; skipped without the library."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

import pytest
from ros_rig import free_port, until
from served_robot import dtps_node, need_dtps
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.errors import LinkLost, RobotLost
from fsm_calib.perception.encoded import decode_image
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.check import Check, Finding
from fsm_calib.robots.dtps.link import DtpsLink
from fsm_calib.robots.dtps.topics import NAMES
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.types import STOP
from fsm_calib.world2d.robot import WorldSpec, make_world

ATTEMPTS = 4
"""A robot in real time needs a machine that lets it live: one check of so many must come to its end."""
NAMED = ["camera_hz", "echo_s", "latency_s", "least_command", "stop_s"]
SLOW = {"rate": 5.0, "dead_zone": 0.2}
"""ente's driver, and a camera that is too slow to follow a lane."""
PATIENT = LinkSettings(quiet=10.0, echo=10.0)


@contextmanager
def silent_robot() -> Iterator[str]:
    """A switchboard with a robot's topics and nobody who publishes or listens; yields its address."""
    port = free_port()
    with closing(DtpsLink(f"create:http://127.0.0.1:{port}/", "duckie")) as link:
        for name in ("image", "wheels", "executed", "emergency_stop"):
            link.create(NAMES[name], 3)
        yield f"dtps://127.0.0.1:{port}/duckie"


class Checked:
    """One check of a served robot, and what became of its emergency stops.

    Parameters
    ----------
    own_stop : bool
        Somebody has made the topic of this project's own emergency stop.
    settings
        The robot's, by the names of `ServeSettings`.
    """

    def __init__(self, own_stop: bool, **settings: float) -> None:
        self.found: dict[str, Finding] = {}
        self.pressed: list[bool] = []
        with dtps_node(make_world(WorldSpec()), False, **settings) as (node, address):
            if own_stop:
                node.link.create(NAMES["estop"], 3)
            node.station.stop = _noting(self.pressed, node.station.stop)  # type: ignore[method-assign]
            with suppress(RobotLost), ExitStack() as ended:
                check = Check(GuardSetup(parse_address(address), PATIENT), decode_image)
                ended.enter_context(closing(check))
                for finding in check.findings():
                    self.found[finding.name] = finding
            until(lambda: node.station.last_received == STOP, "the wheels stand")
            until(lambda: not node.station.robot.is_stopped, "the emergency stop is released")

    @property
    def is_whole(self) -> bool:
        """Whether the machine let the robot live to the end."""
        measured = {name for name, finding in self.found.items() if finding.value is not None}
        return {"echo_s", "stop_s"} <= measured


def _noting(pressed: list[bool], stop: Callable[[bool], None]) -> Callable[[bool], None]:
    """Return `stop`, noting what it was called with."""

    def noted(value: bool) -> None:
        pressed.append(value)
        stop(value)

    return noted


def checked(own_stop: bool, **settings: float) -> Checked:
    """Return a check that came to its end, or the last of `ATTEMPTS`."""
    need_dtps()
    for _ in range(ATTEMPTS):
        check = Checked(own_stop, **settings)
        if check.is_whole:
            break
    return check


@pytest.fixture(scope="module")
def slow_robot() -> Checked:
    return checked(own_stop=False, **SLOW)


@pytest.fixture(scope="module")
def robot_without_encoders() -> Checked:
    return checked(own_stop=True, encoders=False, **SLOW)


def test_the_check_tells_every_figure_of_a_robot_with_dtps(slow_robot: Checked) -> None:
    assert list(slow_robot.found) == NAMED
    assert all(finding.sentence for finding in slow_robot.found.values())
    assert slow_robot.is_whole


def test_a_slow_camera_is_bad(slow_robot: Checked) -> None:
    finding = slow_robot.found["camera_hz"]
    assert finding.value is not None
    assert 0.0 < finding.value < 10.0
    assert not finding.good


def test_no_command_in_the_drivers_dead_zone_is_called_the_least(slow_robot: Checked) -> None:
    value = slow_robot.found["least_command"].value
    assert value is None or value > SLOW["dead_zone"]


def test_the_drivers_emergency_stop_is_pressed_and_released(slow_robot: Checked) -> None:
    assert slow_robot.pressed[0] is True
    assert slow_robot.pressed[-1] is False


def test_without_encoders_the_check_says_so_and_nothing_is_bad(robot_without_encoders: Checked) -> None:
    finding = robot_without_encoders.found["least_command"]
    assert (finding.value, finding.good) == (None, True)
    assert "No encoders" in finding.sentence


def test_an_emergency_stop_of_our_own_leaves_the_drivers_alone(robot_without_encoders: Checked) -> None:
    assert robot_without_encoders.found["stop_s"].value is not None
    assert robot_without_encoders.pressed == []


def test_a_robot_that_answers_no_command_is_bad_in_every_figure_and_a_lost_link() -> None:
    need_dtps()
    found: list[Finding] = []
    with silent_robot() as address:
        setup = GuardSetup(parse_address(address), LinkSettings(quiet=10.0))
        with (
            closing(Check(setup, decode_image)) as check,
            pytest.raises(LinkLost, match="acknowledged no command"),
        ):
            found.extend(check.findings())
    assert [finding.name for finding in found] == NAMED[:3]
    assert not any(finding.good for finding in found)


def test_a_robot_that_is_not_there_is_told_by_the_command() -> None:
    need_dtps()
    done = CliRunner().invoke(app, ["robot", "check", "--robot", "dtps://127.0.0.1:9/duckie", "--yes"])
    assert done.exit_code == 1
    assert "127.0.0.1:9" in done.output
