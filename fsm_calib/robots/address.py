"""Where a robot is reached: ``ros1://HOST[:PORT]/VEHICLE`` or ``dtps://HOST[:PORT]/VEHICLE``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal
from urllib.parse import urlsplit

from fsm_calib.errors import InputError

PORTS = {"ros1": 11311, "dtps": 11511}
"""Where a robot listens when nothing else is said: the ROS master; the DTPS switchboard of the robot's stack."""
VEHICLE_PATTERN = r"[A-Za-z][A-Za-z0-9_]*"
"""Names of vehicles are parts of ROS names."""
_CURE = "Give for instance ros1://duckie.local/duckie."


@dataclass(frozen=True, slots=True)
class RobotAddress:
    """A robot on a network: how it speaks, where, and the name that its topics begin with."""

    kind: Literal["ros1", "dtps"]
    host: str
    port: int
    vehicle: str

    @property
    def url(self) -> str:
        """The HTTP address of the ROS master or of the switchboard."""
        return f"http://{self.host}:{self.port}/"

    def __str__(self) -> str:
        """Return the address as it is written."""
        return f"{self.kind}://{self.host}:{self.port}/{self.vehicle}"


def parse_address(text: str) -> RobotAddress:
    """Return the address that `text` spells.

    Raises
    ------
    InputError
        Another scheme, no host, a port that is none, or no name of a vehicle.
    """
    parts = urlsplit(text)
    if parts.scheme not in PORTS:
        raise InputError(f"{text!r} does not begin with ros1:// or dtps://", where="--robot", cure=_CURE)
    vehicle = parts.path.strip("/")
    if not parts.hostname:
        raise InputError(f"{text!r} names no host", where="--robot", cure=_CURE)
    if not re.fullmatch(VEHICLE_PATTERN, vehicle):
        raise InputError(f"{text!r} names no vehicle", where="--robot", cure=_CURE)
    try:
        port = parts.port or PORTS[parts.scheme]
    except ValueError as error:
        raise InputError(f"{text!r}: {error}", where="--robot", cure=_CURE) from error
    kind: Literal["ros1", "dtps"] = "ros1" if parts.scheme == "ros1" else "dtps"
    return RobotAddress(kind, parts.hostname, port, vehicle)
