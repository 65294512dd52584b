"""What a robot is made of before it drives: the parts that laws change, each in its own stage.

rows     command rows -> command rows       (the link between operator and robot)
samples  duty on the integration grid -> duty  (the driver, faults)
left, right, supply  fields of `Motor` and `Supply`
body     fields of `Body`
hooks    called every 10 ms with time, pose and velocity; may write forces and what the floor is like
sensing  measured pose track -> measured pose track
Every engine takes the same Setup, so a law is written once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from foreign.motor import Motor, Supply
from foreign.planar import Body

Array = np.ndarray
RowLaw = Callable[[Array, Array], tuple[Array, Array]]  # times (n,), duties (n, 2)
SampleLaw = Callable[[Array, Array], Array]  # grid times (k,), duties (k, 2)
HookLaw = Callable[
    [float, Array, Array], None
]  # time, state (x, y, theta, vx, vy, omega in world), hook array
SenseLaw = Callable[["Track"], None]


@dataclass
class Track:
    """True states on a fine grid and the measured pose rows, which laws of sensing change in place."""

    grid: Array  # s
    states: Array  # (k, 6) x, y, theta of the axle centre, vx, vy (world), omega
    times: Array  # stamps of the measured rows, s
    shown: Array  # the instants that the rows show, s
    mount: Array  # x, y, theta of the tag on the robot
    after: list[Callable[[Array, Array], Array]] = field(
        default_factory=list
    )  # stamps, poses (n, 3) -> poses


@dataclass
class Place:
    """A part of the floor: outline, centre [m], half sizes [m], direction [rad], softness of the edge (share)."""

    x: float
    y: float
    outline: str
    half_long: float
    half_wide: float
    direction: float
    soft: float

    def inside(self, x: float, y: float) -> float:
        """Return how much of the place's nature a point has, 0 to 1."""
        c, s = np.cos(self.direction), np.sin(self.direction)
        along = (c * (x - self.x) + s * (y - self.y)) / self.half_long
        across = (-s * (x - self.x) + c * (y - self.y)) / self.half_wide
        if self.outline == "ellipse":
            reach = float(np.hypot(along, across))
        elif self.outline == "strip":
            reach = abs(across)
        else:
            reach = max(abs(along), abs(across))
        if self.soft <= 0.0:
            return 1.0 if reach < 1.0 else 0.0
        return float(1.0 / (1.0 + np.exp(min((reach - 1.0) / (0.25 * self.soft), 60.0))))


@dataclass
class Setup:
    """A robot in parts; laws change it. `size` [m] is the axle length, `speed` [m/s] the top speed."""

    left: dict[str, float]
    right: dict[str, float]
    supply: dict[str, float]
    body: dict[str, Any]
    size: float
    speed: float
    place: Place | None
    window: tuple[float, float] | None  # of this run's event, s; None = it does not happen in this run
    reach: float  # radius of the arena, m
    engine: str = "planar"
    salt: int = 0  # differs from run to run, for laws that throw dice while driving
    rows: list[RowLaw] = field(default_factory=list)
    samples: list[SampleLaw] = field(default_factory=list)
    hooks: list[HookLaw] = field(default_factory=list)
    sensing: list[SenseLaw] = field(default_factory=list)
    gravity: tuple[float, float] = (0.0, 0.0)  # slope, as seen by the 3-D engines [m/s2]
    payload: list[tuple[float, float, float]] = field(
        default_factory=list
    )  # mass [kg], x, y [m], 3-D engines
    pieces: dict[str, float] = field(default_factory=dict)  # natural causes for the 3-D engines

    @property
    def weight(self) -> float:
        """Weight [N]."""
        return float(self.body["mass"]) * 9.81

    @property
    def stall(self) -> float:
        """Stall torque of a wheel [N m]."""
        return float(self.left["stall"])

    def motors(self) -> tuple[Motor, Motor]:
        """Return both drives."""
        return Motor(**self.left), Motor(**self.right)

    def battery(self) -> Supply:
        """Return the battery."""
        return Supply(**self.supply)

    def frame(self) -> Body:
        """Return the planar body."""
        return Body(**self.body)

    def wheels(self, which: str) -> list[dict[str, float]]:
        """Return the parts of `left`, `right` or `both` wheels."""
        return {"left": [self.left], "right": [self.right], "both": [self.left, self.right]}[which]

    @staticmethod
    def columns(which: str) -> list[int]:
        """Return the columns of a duty array for `left`, `right` or `both`."""
        return {"left": [0], "right": [1], "both": [0, 1]}[which]


def add_mass(setup: Setup, mass: float, x: float, y: float) -> None:
    """Put a point mass [kg] on the body at (x, y) [m]: centre of mass and inertia by the parallel axis theorem."""
    b = setup.body
    whole = b["mass"] + mass
    cx, cy = (b["mass"] * b["com_x"] + mass * x) / whole, (b["mass"] * b["com_y"] + mass * y) / whole
    own = b["mass"] * ((b["com_x"] - cx) ** 2 + (b["com_y"] - cy) ** 2)
    b["inertia"] += own + mass * ((x - cx) ** 2 + (y - cy) ** 2)
    b["mass"], b["com_x"], b["com_y"] = whole, cx, cy
    setup.payload.append((mass, x, y))
