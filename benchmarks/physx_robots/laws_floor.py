"""Laws of the floor, and of what pushes the robot about on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from benchmarks.physx_robots.laws import BRUSH, DUTY, Law, Process, direction, log_uniform, register
from benchmarks.physx_robots.robots import GRAVITY, Rng, Robot
from benchmarks.physx_robots.simulate import Drive, State

Vector = tuple[float, float]


@register
@dataclass(frozen=True)
class Slope(Law):
    """The whole floor slopes by `tilt_rad` down along a direction."""

    label, law, grows, span, needs = "floor_tilt", "slope", {"tilt_rad": 1}, (0.0003, 0.12), DUTY
    cause = "floors are level within 2 to 10 mm/m (DIN 18202), tables and boards less so"
    tilt_rad: float
    down: Vector

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw slope and direction."""
        return cls(log_uniform(rng, 0.008, 0.05), direction(rng))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with gravity askew."""
        tilt = math.sin(self.tilt_rad)
        return replace(robot, tilt=(robot.tilt[0] + tilt * self.down[0], robot.tilt[1] + tilt * self.down[1]))


class Downhill(Process):
    """The pull of a floor that sags like a valley along one direction."""

    def __init__(self, law: Sagging) -> None:
        self.law = law

    def force(self, state: State) -> None:
        """Add weight times slope; the slope grows with the distance from the valley's line, up to a limit."""
        law = self.law
        across = (state.x - law.at[0]) * law.down[0] + (state.y - law.at[1]) * law.down[1]
        slope = law.tilt_rad * (1.0 - 0.5 * math.tanh(across / law.length_m))
        pull = state.robot.total_mass * GRAVITY * slope
        state.push(pull * law.down[0], pull * law.down[1])
        ahead, left, _ = state.robot.centre
        cos, sin = math.cos(state.yaw), math.sin(state.yaw)
        state.moment += pull * (
            (ahead * cos - left * sin) * law.down[1] - (ahead * sin + left * cos) * law.down[0]
        )


@register
@dataclass(frozen=True)
class Sagging(Law):
    """A floor that slopes by `tilt_rad` in the middle, by half as much again on one side and half as much on
    the other.
    """

    label, law, grows, span, needs = "floor_tilt", "uneven_slope", {"tilt_rad": 1}, (0.0003, 0.12), DUTY
    cause = "screed laid to a drain, or a board that sags: a slope that is not the same everywhere"
    tilt_rad: float
    down: Vector
    at: Vector
    length_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw slope, direction and where it changes."""
        return cls(
            log_uniform(rng, 0.008, 0.05), direction(rng), direction(rng, 0.3), float(rng.uniform(0.4, 1.0))
        )

    def process(self, rng: Rng) -> Process:
        """Return the pull."""
        return Downhill(self)


class Pile(Process):
    """Rolling resistance that depends on the direction of motion against the pile."""

    def __init__(self, law: DirectionalDrag) -> None:
        self.law = law

    def tick(self, state: State) -> None:
        """Set both wheels' rolling resistance: least along the nap, most against it."""
        speed = math.hypot(state.vx, state.vy)
        if speed < 1e-4:
            along = 0.0
        else:
            along = (state.vx * self.law.nap[0] + state.vy * self.law.nap[1]) / speed
        drag = self.law.drag * (1.0 - 0.85 * along)
        state.rolling = [state.rolling[0] + drag, state.rolling[1] + drag]


@register
@dataclass(frozen=True)
class DirectionalDrag(Law):
    """Carpet that drags by `drag` of the load, less along its nap and more against it."""

    label, law, grows, span, needs = "carpet_nap", "directional_drag", {"drag": 1}, (0.001, 0.3), DUTY
    cause = (
        "cut pile leans one way; rolling on carpet takes several per cent of the load, more against the lean"
    )
    drag: float
    nap: Vector

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw drag and nap."""
        return cls(log_uniform(rng, 0.015, 0.08), direction(rng))

    def process(self, rng: Rng) -> Process:
        """Return the pile."""
        return Pile(self)


@register
@dataclass(frozen=True)
class Carried(Law):
    """Carpet whose pile lays over as wheels roll, and carries them by `share` of the rolled way along the nap."""

    label, law, grows, span, needs = "carpet_nap", "carried", {"share": 1}, (0.001, 0.3), BRUSH
    cause = "drift of robots on carpet along its pile (Roy and Thrun, Online self-calibration, ICRA 1999)"
    share: float
    nap: Vector

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw share and nap."""
        return cls(log_uniform(rng, 0.01, 0.06), direction(rng))

    def build(self, robot: Robot) -> Robot:
        """Return the robot on the carpet."""
        return replace(robot, nap_speed=(self.share * self.nap[0], self.share * self.nap[1]))


class Leaning(Process):
    """A pull along the nap while the robot moves."""

    def __init__(self, law: PilePull) -> None:
        self.law = law

    def force(self, state: State) -> None:
        """Add the pull, full above a few cm/s."""
        pull = self.law.pull * state.robot.total_mass * GRAVITY
        pull *= math.tanh((abs(state.rate[0]) + abs(state.rate[1])) * state.robot.radius / 0.06)
        state.push(pull * self.law.nap[0], pull * self.law.nap[1])


@register
@dataclass(frozen=True)
class PilePull(Law):
    """Carpet whose bent fibres spring back under the wheels and push along the nap by `pull` of the weight."""

    label, law, grows, span, needs = "carpet_nap", "pile_pull", {"pull": 1}, (0.001, 0.15), DUTY
    cause = "fibres bent against their lean give their energy back along it (carpet drift, as above)"
    pull: float
    nap: Vector

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw pull and nap."""
        return cls(log_uniform(rng, 0.01, 0.05), direction(rng))

    def process(self, rng: Rng) -> Process:
        """Return the pull."""
        return Leaning(self)


@dataclass(frozen=True)
class Patch(Law):
    """A round or square place on the floor; `size_m` is its radius or half its side, `edge_m` how soft its edge
    is.
    """

    local = True
    at: Vector
    size_m: float
    square: bool
    edge_m: float

    @classmethod
    def place(cls, rng: Rng, robot: Robot) -> tuple[Vector, float, bool, float]:
        """Draw a place that drives will meet."""
        size = robot.reach * float(rng.uniform(0.28, 0.45))
        at = direction(rng, robot.reach * float(rng.uniform(0.2, 0.6)))
        return at, size, bool(rng.random() < 0.5), float(rng.uniform(0.01, 0.06))

    def inside(self, x: float, y: float) -> float:
        """Return 1 in the place, 0 outside, and between over its edge."""
        dx, dy = x - self.at[0], y - self.at[1]
        apart = max(abs(dx), abs(dy)) if self.square else math.hypot(dx, dy)
        return min(max((self.size_m - apart) / self.edge_m + 0.5, 0.0), 1.0)

    def wheels(self, state: State) -> tuple[float, float]:
        """Return how far each wheel is inside."""
        half = 0.5 * state.robot.axle
        dx, dy = -half * math.sin(state.yaw), half * math.cos(state.yaw)
        return self.inside(state.x + dx, state.y + dy), self.inside(state.x - dx, state.y - dy)

    def touched(self, drive: Drive, rng: Rng) -> np.ndarray:
        """Return where the axle's middle is in the place."""
        return np.array([self.inside(x, y) > 0.3 for x, y in zip(drive.x.tolist(), drive.y.tolist())])


class Rough(Process):
    """More rolling resistance in a place."""

    def __init__(self, law: Patch, dry: float, by_speed: float) -> None:
        self.law, self.dry, self.by_speed = law, dry, by_speed

    def tick(self, state: State) -> None:
        """Add dry and speed-dependent resistance to the wheels inside."""
        for side, share in enumerate(self.law.wheels(state)):
            if share:
                radius = state.robot.wheels[side].radius
                drag = self.dry + self.by_speed * abs(state.rate[side]) * radius / state.robot.speed
                state.rolling[side] += share * drag


@register
@dataclass(frozen=True)
class Doormat(Patch):
    """A mat with a rolling resistance of `drag` of the load."""

    label, law, grows, span, needs = "rough_floor_patch", "doormat", {"drag": 1}, (0.005, 0.6), DUTY
    cause = "rolling resistance of small hard wheels: floor 1 %, carpet and mats 5 to 15 % (caster makers' tables)"
    drag: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw place and drag."""
        return cls(*cls.place(rng, robot), log_uniform(rng, 0.04, 0.2))

    def process(self, rng: Rng) -> Process:
        """Return the mat."""
        return Rough(self, self.drag, 0.0)


@register
@dataclass(frozen=True)
class Gravel(Patch):
    """Spilt grains, pushed aside: resistance grows with speed, from 0.4 of `drag` at rest to 1.4 of it."""

    label, law, grows, span, needs = "rough_floor_patch", "spilt_grains", {"drag": 1}, (0.005, 0.6), DUTY
    cause = "bulldozing of loose grains grows with speed (Wong, Theory of Ground Vehicles, ch. 2)"
    drag: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw place and drag."""
        return cls(*cls.place(rng, robot), log_uniform(rng, 0.04, 0.2))

    def process(self, rng: Rng) -> Process:
        """Return the grains."""
        return Rough(self, 0.4 * self.drag, self.drag)


class Slick(Process):
    """Less grip in a place."""

    def __init__(self, law: WetSpot) -> None:
        self.law = law

    def tick(self, state: State) -> None:
        """Lower the grip of the wheels inside."""
        for side, share in enumerate(self.law.wheels(state)):
            if share:
                state.grip[side] *= 1.0 - share * (1.0 - min(self.law.grip / state.robot.tyre.grip, 1.0))


@register
@dataclass(frozen=True)
class WetSpot(Patch):
    """A wet or oily place with a friction coefficient of `grip`."""

    label, law, grows, span = "low_friction_patch", "wet_spot", {"grip": -1}, (0.001, 0.5)
    cause = "rubber on wet or oily smooth floor 0.05 to 0.3, with soap or oil film below 0.1 (slip-resistance tables)"
    grip: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw place and grip."""
        return cls(*cls.place(rng, robot), log_uniform(rng, 0.02, 0.08))

    def process(self, rng: Rng) -> Process:
        """Return the spot."""
        return Slick(self)


@register
@dataclass(frozen=True)
class OilyStrip(WetSpot):
    """The same, worst in the middle: the grip rises gradually to the rim."""

    label, law, grows, span = "low_friction_patch", "oily_gradient", {"grip": -1}, (0.001, 0.5)
    cause = "a spill that thins out to its rim (grip between that of the film and that of the dry floor)"

    def inside(self, x: float, y: float) -> float:
        """Return 1 in the middle, falling to 0 at the rim."""
        apart = math.hypot(x - self.at[0], y - self.at[1]) / self.size_m
        return min(max(2.0 * (1.0 - apart), 0.0), 1.0) ** 0.5
