"""Laws of what is seen: the tag on the robot, and the markers that the camera is placed by."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from benchmarks.physx_robots.laws import Law, Reported, direction, log_uniform, register, sign
from benchmarks.physx_robots.robots import Rng, Robot
from benchmarks.physx_robots.simulate import Drive

Vector = tuple[float, float]


@register
@dataclass(frozen=True)
class GluedOff(Law):
    """The tag sits `size_m` off its place."""

    label, law, grows, span, senses = "sensor_offset", "glued_off", {"size_m": 1}, (0.002, 0.15), True
    cause = "a tag glued by eye, or a marker plate on the wrong holes"
    size_m: float
    towards: Vector

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw distance and direction."""
        return cls(log_uniform(rng, 0.008, 0.05), direction(rng))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with its tag moved."""
        x, y = robot.sensing.tag
        tag = (x + self.size_m * self.towards[0], y + self.size_m * self.towards[1])
        return replace(robot, sensing=replace(robot.sensing, tag=tag))


@register
@dataclass(frozen=True)
class CreepingTape(Law):
    """The tag starts a third of `size_m` off its place and creeps towards all of it with time constant `creep_s`."""

    label, law, grows, span, senses = "sensor_offset", "creeping_tape", {"size_m": 1}, (0.002, 0.15), True
    cause = "a heavy marker plate on soft adhesive tape creeps (viscoelastic shear of foam tape)"
    size_m: float
    towards: Vector
    creep_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw distance, direction and time."""
        return cls(log_uniform(rng, 0.01, 0.05), direction(rng), float(rng.uniform(15.0, 40.0)))

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the poses with the offset of each time."""
        size = self.size_m * (1.0 - 0.67 * np.exp(-poses["time"] / self.creep_s))
        cos, sin = np.cos(poses["byaw"]), np.sin(poses["byaw"])
        x = poses["x"] + size * (cos * self.towards[0] - sin * self.towards[1])
        return poses | {"x": x, "y": poses["y"] + size * (sin * self.towards[0] + cos * self.towards[1])}


@register
@dataclass(frozen=True)
class GluedAskew(Law):
    """The tag is turned by an angle."""

    label, law, grows, span, senses = "sensor_yaw", "glued_askew", {"size": 1}, (0.003, 0.6), True
    cause = "a tag glued by eye, 1 to 10 degrees askew"
    size: float
    sense: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the angle."""
        return cls(log_uniform(rng, 0.015, 0.15), sign(rng))

    def sizes(self) -> dict[str, Any]:
        """Return the signed angle."""
        return {"yaw_rad": self.sense * self.size}

    def build(self, robot: Robot) -> Robot:
        """Return the robot with its tag turned."""
        sensing = robot.sensing
        return replace(robot, sensing=replace(sensing, tag_yaw=sensing.tag_yaw + self.sense * self.size))


@register
@dataclass(frozen=True)
class LooseScrew(Law):
    """The tag's plate is turned from the start and turns on within the run, from 0.6 of `size` to all of it."""

    label, law, grows, span, senses = "sensor_yaw", "loose_screw", {"size": 1}, (0.003, 0.6), True
    cause = "a plate on one screw that works loose"
    size: float
    sense: float
    turn_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw angle and time."""
        return cls(log_uniform(rng, 0.02, 0.15), sign(rng), float(rng.uniform(15.0, 40.0)))

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the poses turned."""
        turn = self.sense * self.size * (1.0 - 0.4 * np.exp(-poses["time"] / self.turn_s))
        return poses | {"yaw": poses["yaw"] + turn}


@dataclass(frozen=True)
class Marker(Law):
    """Poses are wrong near a marker that was knocked by `shift_m` along `towards` and turned by `turn_rad`."""

    local, senses = True, True
    shift_m: float
    turn_rad: float
    towards: Vector
    at: Vector
    size_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the knock and the area."""
        at = direction(rng, robot.reach * float(rng.uniform(0.35, 0.7)))
        shift = log_uniform(rng, 0.01, 0.06)
        turn = shift * float(rng.uniform(0.2, 1.5)) * sign(rng)
        return cls(shift, turn, direction(rng), at, robot.reach * float(rng.uniform(0.35, 0.6)))

    def weight(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return how much a place is seen by the marker, 0..1."""
        raise NotImplementedError

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the poses turned about the marker and shifted."""
        x, y = poses["x"], poses["y"]
        w = self.weight(x, y)
        dx, dy = x - self.at[0], y - self.at[1]
        return poses | {
            "x": x + w * (self.shift_m * self.towards[0] - self.turn_rad * dy),
            "y": y + w * (self.shift_m * self.towards[1] + self.turn_rad * dx),
            "yaw": poses["yaw"] + w * self.turn_rad,
        }

    def touched(self, drive: Drive, rng: Rng) -> np.ndarray:
        """Return where the marker counts."""
        return self.weight(drive.x, drive.y) > 0.3


@register
@dataclass(frozen=True)
class KnockedMarker(Marker):
    """Within `size_m` of the marker its own place is believed: a hard edge."""

    label, law, grows, span = (
        "misplaced_marker",
        "nearest_marker",
        {"shift_m": 1, "turn_rad": 1},
        (0.002, 0.2),
    )
    cause = "localisation by the nearest floor marker (each tag owns a cell)"

    def weight(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return 1 within the area."""
        return (np.hypot(x - self.at[0], y - self.at[1]) < self.size_m).astype(float)


@register
@dataclass(frozen=True)
class BlendedMarker(Marker):
    """Several markers are averaged by distance: the error fades over a band."""

    label, law, grows, span = (
        "misplaced_marker",
        "blended_markers",
        {"shift_m": 1, "turn_rad": 1},
        (0.002, 0.2),
    )
    cause = "bundle of floor tags weighted by their size in the image"

    def weight(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return a smooth step."""
        apart = np.hypot(x - self.at[0], y - self.at[1])
        return 1.0 / (1.0 + np.exp((apart - self.size_m) / (0.08 * self.size_m)))
