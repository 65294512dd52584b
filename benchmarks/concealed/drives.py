"""What the concealed robots are told to do: held wheel commands with the state each belongs to."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from concealed.physics import Physics, simulate

ARENA = 0.45
"""Distance from the centre [m] beyond which the next manoeuvre leads back."""


@dataclass
class Drive:
    """Breakpoints [s], commands [-1, 1] that hold until the next, and state paths."""

    times: list[float] = field(default_factory=lambda: [0.0])
    left: list[float] = field(default_factory=lambda: [0.0])
    right: list[float] = field(default_factory=lambda: [0.0])
    states: list[str] = field(default_factory=lambda: ["idle"])
    end: float = 0.8

    def hold(self, left: float, right: float, duration: float, state: str) -> None:
        self.times.append(self.end)
        self.left.append(round(left, 5))
        self.right.append(round(right, 5))
        self.states.append(state)
        self.end += duration

    def rest(self, rng: np.random.Generator, state: str) -> None:
        self.hold(0.0, 0.0, float(rng.choice([0.5, 0.6, 0.8])), state)

    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.array(self.times), np.array(self.left), np.array(self.right)


def _shuttle(d: Drive, rng: np.random.Generator) -> None:
    u, t = rng.uniform(0.12, 0.47), rng.uniform(1.4, 2.6)
    d.hold(u, u, t, "wheel_iteration/forward")
    d.rest(rng, "wheel_iteration/settle")
    d.hold(-u, -u, t, "wheel_iteration/back")
    d.rest(rng, "wheel_iteration/settle")


def _spin(d: Drive, rng: np.random.Generator) -> None:
    u = rng.choice([-1, 1]) * rng.uniform(0.13, 0.36)
    d.hold(u, -u, rng.uniform(0.7, 1.9), "orientation/turn")
    d.rest(rng, "orientation/settle")


def _steps(d: Drive, rng: np.random.Generator) -> None:
    u, wheel = rng.uniform(0.18, 0.4), rng.integers(2)
    for _ in range(int(rng.integers(4, 9))):
        d.hold(u * (wheel == 0), u * (wheel == 1), 0.25, "camera_scan/step")
        d.hold(0.0, 0.0, 0.3, "camera_scan/settle")


def _slalom(d: Drive, rng: np.random.Generator) -> None:
    a, b, t = rng.uniform(0.3, 0.48), rng.uniform(0.15, 0.3), rng.uniform(0.4, 0.7)
    for i in range(int(rng.integers(4, 7))):
        d.hold(*((a, b) if i % 2 else (b, a)), t, "in_lane/follow")
    d.hold(0.0, 0.0, 0.5, "in_lane/stop")


def _arc(d: Drive, rng: np.random.Generator) -> None:
    for _ in range(2):
        d.hold(rng.uniform(0.1, 0.36), rng.uniform(0.1, 0.36), rng.uniform(1.2, 2.2), "in_lane/follow")
    d.hold(0.0, 0.0, 0.5, "in_lane/stop")


MIXED = ((_shuttle, 3), (_spin, 3), (_steps, 1.5), (_slalom, 1.5), (_arc, 1.5))
HELD_OUT = ((_shuttle, 1), (_spin, 1), (_slalom, 3), (_arc, 3))


def _lead_back(d: Drive, rng: np.random.Generator, pose: np.ndarray) -> None:
    """Turn to the centre and drive there, by the nominal model."""
    turn = math.remainder(math.atan2(-pose[1], -pose[0]) - pose[2], 2 * math.pi)
    u = rng.uniform(0.18, 0.3)
    d.hold(
        -math.copysign(u, turn),
        math.copysign(u, turn),
        abs(turn) * 0.05 / (0.0318 * 20 * u),
        "orientation/turn",
    )
    d.rest(rng, "orientation/settle")
    u = rng.uniform(0.2, 0.4)
    d.hold(u, u, min(math.hypot(pose[0], pose[1]) / (0.0318 * 20 * u), 3.0), "in_lane/follow")
    d.hold(0.0, 0.0, 0.5, "in_lane/stop")


def make_drive(
    rng: np.random.Generator, physics: Physics, start: np.ndarray, profile: str, duration: float = 60.0
) -> Drive:
    """Compose manoeuvres until `duration` [s]; `profile` is mixed, held_out or poor (constant arcs only)."""
    d = Drive()
    if profile == "poor":
        u = rng.uniform(0.25, 0.35)
        d.hold(u, u * rng.uniform(0.6, 0.75), duration - d.end, "in_lane/follow")
        return d
    menu = MIXED if profile == "mixed" else HELD_OUT
    weights = np.array([w for _, w in menu])
    first = [_spin, _shuttle, _spin, _shuttle, _slalom] if profile == "mixed" else []
    while d.end < duration:
        _, states = simulate(physics, *d.arrays(), start, d.end, None, step=0.001)
        if math.hypot(*states[-1, :2]) > ARENA:
            _lead_back(d, rng, states[-1])
        else:
            act = first.pop() if first else menu[rng.choice(len(menu), p=weights / weights.sum())][0]
            act(d, rng)
    return d
