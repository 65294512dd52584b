"""What a user says about a recording that the recording does not say itself."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.recording.channels import Stamp
from fsm_calib.recording.recording import RobotFacts


@dataclass(frozen=True)
class Named:
    """What the user says about a bag: names of its topics; joints of the left and right wheel, and what the stamp of a
    wheel's rate is; a command's lifetime [s]; facts of the robot.
    """

    command: str | None = None
    pose: str | None = None
    wheels: str | None = None
    yaw_rate: str | None = None
    state: str | None = None
    joints: tuple[str, str] | None = None
    stamp: Stamp | None = None
    stale_after: float | None = None
    robot: RobotFacts | None = None

    @property
    def any_topic(self) -> bool:
        """Whether a topic was named."""
        return any((self.command, self.pose, self.wheels, self.yaw_rate, self.state))


NOTHING = Named()
