"""The subject of an owner's first test: a robot that is driven, what it says, and its emergency stop."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fsm_calib.ports import Robot
from fsm_calib.robots.camera import Decode
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.types import WheelCommand

FRAMES = 300
"""How many frames are kept [1]: those of 10 s."""
THINNED = 4
"""Every so manieth pixel of a frame is kept: enough to see that it changed."""


@dataclass
class Heard:
    """What a robot said, with arrival times [s]; filled by the threads of its connection.

    Parameters
    ----------
    decode : callable
        Returns the image of JPEG bytes, or None.
    """

    decode: Decode
    frames: list[tuple[float, NDArray[np.uint8]]] = field(default_factory=list)
    executed: list[tuple[float, WheelCommand]] = field(default_factory=list)
    ticks: dict[str, int] = field(default_factory=dict)

    def frame(self, data: bytes) -> None:
        """Take a frame as JPEG bytes; what is no image is left out."""
        image = self.decode(data)
        if image is not None:
            self.frames.append((time.monotonic(), image[::THINNED, ::THINNED]))
            del self.frames[:-FRAMES]

    def execute(self, command: WheelCommand) -> None:
        """Take the driver's word for a command that it has applied."""
        self.executed.append((time.monotonic(), command))

    def count(self, side: str, ticks: int) -> None:
        """Take the count of the encoder at a wheel, "left" or "right"."""
        self.ticks[side] = ticks


class Subject(Protocol):
    """A robot under test."""

    @property
    def robot(self) -> Robot:
        """What drives it."""
        ...

    @property
    def heard(self) -> Heard:
        """What it has said so far."""
        ...

    @property
    def least_command(self) -> float:
        """The largest command [1] that may be needed to turn a wheel: its driver's own dead zone is no fault."""
        ...

    @property
    def turning(self) -> float:
        """A slow command that turns the wheels of a sound robot [1]."""
        ...

    def press_stop(self) -> None:
        """Press the emergency stop."""
        ...

    def close(self) -> None:
        """Stop the wheels, release what was pressed and end the connections."""
        ...


def open_subject(setup: GuardSetup, decode: Decode) -> Subject:
    """Return the robot of a setup as a test's subject.

    Raises
    ------
    InputError
        It speaks DTPS, and Duckietown's library is not installed.
    RobotLost
        It does not answer, or must not be driven.
    """
    if setup.address.kind == "dtps":
        from fsm_calib.robots.dtps.subject import DtpsSubject

        return DtpsSubject(setup, decode)
    from fsm_calib.robots.ros1.subject import Ros1Subject

    return Ros1Subject(setup, decode)
