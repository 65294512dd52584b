"""What an owner's first test says of a robot, by a scripted one that does at once what it is told."""

from __future__ import annotations

import pytest

from fsm_calib.errors import EmergencyStopped
from fsm_calib.perception.encoded import decode_image
from fsm_calib.robots import check as checking
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.check import Check, Finding
from fsm_calib.robots.dtps.subject import DtpsSubject
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.subject import Ros1Subject
from fsm_calib.robots.subject import Heard
from fsm_calib.types import STOP, Frame, WheelCommand

TICKS = 10
"""That a push turns a wheel by."""


class Scripted:
    """A robot and its own subject; no time passes.

    Parameters
    ----------
    dead_zone : float
        Commands up to this turn no wheel [1].
    allowed : float
        The largest least command that is good [1].
    has_encoders, can_stop : bool
        What it is equipped with.
    """

    turning = 0.3

    def __init__(
        self, dead_zone: float = 0.0, allowed: float = 0.14, has_encoders: bool = True, can_stop: bool = True
    ) -> None:
        self.heard, self.robot, self.least_command = Heard(decode_image), self, allowed
        self._dead_zone, self._can_stop, self._is_pressed = dead_zone, can_stop, False
        if has_encoders:
            self.heard.ticks = {"left": 0, "right": 0}

    def command(self, command: WheelCommand) -> None:
        self.heard.execute(command)

    def run(self, command: WheelCommand, duration: float) -> None:
        for side, value in (("left", command.left), ("right", command.right)):
            if side in self.heard.ticks and abs(value) > self._dead_zone:
                self.heard.count(side, self.heard.ticks[side] + TICKS)
        self.heard.execute(command)
        self.heard.execute(STOP)

    def wait(self, duration: float) -> None:
        if self._is_pressed:
            self.heard.execute(STOP)
            raise EmergencyStopped("the stop was pressed")

    def now(self) -> float:
        return 0.0

    def capture(self) -> Frame | None:
        return None

    def press_stop(self) -> None:
        self._is_pressed = self._can_stop

    def close(self) -> None:
        pass


def found(robot: Scripted, monkeypatch: pytest.MonkeyPatch) -> dict[str, Finding]:
    """Return what the check finds, by name."""
    monkeypatch.setattr(checking, "open_subject", lambda setup, decode: robot)
    check = Check(GuardSetup(parse_address("ros1://host/duckie")), decode_image)
    return {finding.name: finding for finding in check.findings()}


@pytest.mark.parametrize(
    ("dead_zone", "allowed", "least", "is_good"),
    [
        (0.01, Ros1Subject.least_command, 0.02, True),
        (0.2, Ros1Subject.least_command, 0.22, False),
        (0.2, DtpsSubject.least_command, 0.22, True),
        (0.25, DtpsSubject.least_command, 0.26, False),
    ],
)
def test_a_least_command_is_judged_by_the_drivers_own_dead_zone(
    dead_zone: float, allowed: float, least: float, is_good: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    finding = found(Scripted(dead_zone, allowed), monkeypatch)["least_command"]
    assert (finding.value, finding.good) == (least, is_good)


def test_wheels_that_never_turn_are_bad(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = found(Scripted(dead_zone=1.0), monkeypatch)["least_command"]
    assert (finding.value, finding.good) == (None, False)
    assert "motors, cables and battery" in finding.sentence


def test_without_encoders_nothing_is_bad_about_the_wheels(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = found(Scripted(has_encoders=False), monkeypatch)["least_command"]
    assert (finding.value, finding.good) == (None, True)
    assert "No encoders" in finding.sentence


def test_an_emergency_stop_that_does_not_stop_is_bad(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = found(Scripted(can_stop=False), monkeypatch)["stop_s"]
    assert not finding.good
    assert "Do not run it" in finding.sentence


def test_an_emergency_stop_is_seen_by_what_the_driver_acknowledges(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = found(Scripted(), monkeypatch)["stop_s"]
    assert finding.value is not None
    assert "put the wheels to zero" in finding.sentence


def test_a_camera_without_a_frame_is_bad_and_so_is_its_latency(monkeypatch: pytest.MonkeyPatch) -> None:
    figures = found(Scripted(), monkeypatch)
    assert (figures["camera_hz"].value, figures["camera_hz"].good) == (0.0, False)
    assert (figures["latency_s"].value, figures["latency_s"].good) == (None, False)
