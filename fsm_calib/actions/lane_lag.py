"""Where the robot is in its lane now, from where a late frame saw it and the commands sent since.

A frame is at hand some time after its exposure, and the wheels answer a command after a time constant; a controller
that takes the old pose for the present one swings (an integrator with lag t and gain g swings from g t = 1 on). The
pose is carried on over the lag, with the model that the controller itself uses: d' = v sin(phi), phi' = omega.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from fsm_calib.types import LanePose, WheelCommand

Sent = Sequence[tuple[float, WheelCommand]]
"""Commands with the times [s] at which they were given, in order."""
STEP = 0.01
"""Step of the integration [s]."""
NO_LAG = 1e-6
"""A frame that is no older is of now [s]."""


def predict(
    pose: LanePose,
    seen: float,
    now: float,
    sent: Sent,
    *,
    speed: float,
    ratio: float,
    axle: float,
    answer: float,
) -> LanePose:
    """Return the pose in the lane at which a command given now will act.

    Parameters
    ----------
    pose : LanePose
        As the frame saw it.
    seen, now : float
        When the frame was taken, and the present [s]. Without a lag the pose is returned as it is.
    sent : sequence of (time, command)
        What was commanded; before the first one the robot stands.
    speed : float
        Speed per unit of mean command [m/s].
    ratio : float
        Wheel ratio k in use [1].
    axle : float
        Distance of the wheels [m].
    answer : float
        The motors' answer, taken as a delay [s].
    """
    if now - seen <= NO_LAG:
        return pose
    d, phi, time = pose.d, pose.phi, seen
    while time < now + answer:
        command = _acting(sent, time - answer)
        left, right = speed * command.left, speed * command.right / ratio
        step = min(STEP, now + answer - time)
        d += 0.5 * (left + right) * math.sin(phi) * step
        phi += (right - left) / axle * step
        time += STEP
    return LanePose(d, phi, pose.support)


def _acting(sent: Sent, time: float) -> WheelCommand:
    """Return the command that was given last at `time` [s]."""
    for given, command in reversed(sent):
        if given <= time:
            return command
    return WheelCommand()
