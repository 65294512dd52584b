"""What a guard is told when it is started, as one line of JSON."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field

from fsm_calib.robots.address import RobotAddress
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.types import Pose2


@dataclass(frozen=True)
class GuardSetup:
    """A guard's robot, rules and clock.

    Parameters
    ----------
    address : RobotAddress
        The robot.
    settings : LinkSettings
        The rules' numbers.
    fence : float
        Farthest from the start by dead reckoning [m].
    start : Pose2
        Where the robot begins, for dead reckoning.
    """

    address: RobotAddress
    settings: LinkSettings = field(default_factory=LinkSettings)
    fence: float = 4.0
    start: Pose2 = field(default_factory=Pose2)

    @property
    def lockstep(self) -> bool:
        """Whether the robot is a served one whose time passes only when it is asked to."""
        return self.settings.lockstep

    def to_json(self) -> str:
        """Return it as one line."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> GuardSetup:
        """Return what `to_json` wrote."""
        values = json.loads(text)
        return cls(
            RobotAddress(**values["address"]),
            LinkSettings(**values["settings"]),
            values["fence"],
            Pose2(**values["start"]),
        )
