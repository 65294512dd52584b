"""The driver: manoeuvres from a shuffled deck, kept inside an area by a look at the noisy pose."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.physx_robots.robots import GRAVITY, Rng, Robot

Pair = tuple[float, float]
Pose = tuple[float, float, float]
FASTEST_TURN = 3.5  # rad/s that the driver asks for
DECK = [
    "straight",
    "straight",
    "straight",
    "slow",
    "slow",
    "back",
    "back",
    "back_slow",
    "arc",
    "arc",
    "arc",
    "back_arc",
    "spin",
    "spin",
    "spin_slow",
    "pivot",
    "pivot",
    "back_pivot",
    "s_curve",
    "s_curve",
    "ramp",
    "stop_and_go",
    "rest",
    "weave",
]


class Driver:
    """Yields a command pair at each call; its own randomness comes from `rng`."""

    def __init__(self, rng: Rng, robot: Robot, duration: float) -> None:
        self.rng, self.robot, self.duration = rng, robot, duration
        self.limit = robot.reach
        self.period = robot.command_period
        height = robot.centre[2] + robot.radius
        lifting = (
            GRAVITY * abs(robot.centre[0]) / height / robot.speed
        )  # 1/s: so fast a reversal lifts the caster
        self.slew = min(float(rng.uniform(2.5, 8.0)), float(rng.uniform(0.5, 0.8)) * lifting)
        self.turning = min(1.0, FASTEST_TURN * robot.axle / (2.0 * robot.speed))
        self.pose: Pose = (0.0, 0.0, 0.0)
        self.now: Pair = (0.0, 0.0)
        self.deck: list[str] = []
        self.steps = self._all()
        self.decimals = int(rng.choice([2, 3, 4]))

    def __call__(self, t: float, pose: Pose) -> Pair:
        """Return the command for a time [s] and a true pose, seen with noise."""
        sensing = self.robot.sensing
        x, y, yaw = (
            p + s * self.rng.normal()
            for p, s in zip(pose, (sensing.position_sd,) * 2 + (sensing.heading_sd,))
        )
        self.pose = (float(x), float(y), float(yaw))
        wanted = next(self.steps) if t < self.duration - 1.5 else (0.0, 0.0)
        most = self.slew * self.period
        left, right = (n + max(-most, min(most, w - n)) for n, w in zip(self.now, wanted))
        self.now = (round(left, self.decimals), round(right, self.decimals))
        return self.now

    def _all(self) -> Iterator[Pair]:
        yield from self._hold(0.0, 0.0, float(self.rng.uniform(0.5, 1.2)))
        while True:
            if self._far(self.pose, 0.85):
                yield from self._home()
            if not self.deck:
                self.deck = list(self.rng.permutation(DECK))
            for pair in self._manoeuvre(self.deck.pop()):
                yield pair
                if self._far(self.pose, 1.12):
                    break

    def _far(self, pose: Pose, share: float) -> bool:
        return math.hypot(pose[0], pose[1]) > share * self.limit

    def _hold(self, left: float, right: float, seconds: float) -> Iterator[Pair]:
        for _ in range(max(1, round(seconds / self.period))):
            yield left, right

    def _level(self, name: str) -> float:
        if "slow" in name:
            return float(self.rng.uniform(0.1, 0.35))
        return float(self.rng.uniform(0.35, 1.0)) if self.rng.random() < 0.75 else 1.0

    def _sense(self, level: float, seconds: float) -> float:
        """Return 1, or -1 where going ahead would leave the area and going back would not."""
        x, y, yaw = self.pose
        way = level * self.robot.speed * seconds
        ends = [(x + s * way * math.cos(yaw), y + s * way * math.sin(yaw), yaw) for s in (1, -1)]
        return -1.0 if self._far(ends[0], 0.95) and not self._far(ends[1], 0.95) else 1.0

    def _time(self, level: float, longest: float) -> float:
        """Return a time [s] that a straight at a level may take."""
        room = 1.2 * self.limit / (level * self.robot.speed)
        return float(min(self.rng.uniform(0.8, longest), room))

    def _manoeuvre(self, name: str) -> Iterator[Pair]:
        rng, level = self.rng, self._level(name)
        side = 1.0 if rng.random() < 0.5 else -1.0
        turn = level * self.turning
        if name.startswith(("straight", "slow", "back")) and not name.endswith(("arc", "pivot")):
            seconds = self._time(level, 4.0 if "slow" in name else 2.5)
            sense = self._sense(level, seconds) * (-1.0 if "back" in name else 1.0)
            yield from self._hold(sense * level, sense * level, seconds)
        elif name.startswith("spin"):
            turn = max(turn, 0.12)
            yield from self._hold(-side * turn, side * turn, float(rng.uniform(0.6, 2.5)))
        elif name.endswith("pivot"):
            turn = (-1.0 if "back" in name else 1.0) * max(min(1.5 * turn, level), 0.12)
            pair = (turn, 0.0) if side > 0 else (0.0, turn)
            yield from self._hold(*pair, float(rng.uniform(0.8, 2.5)))
        elif name.endswith("arc"):
            yield from self._arc(level, side, "back" in name)
        elif name == "rest":
            yield from self._hold(0.0, 0.0, float(rng.uniform(1.0, 2.2)))
        else:
            yield from self._shaped(name, level, side)

    def _arc(self, level: float, side: float, back: bool) -> Iterator[Pair]:
        differ = min(self.rng.uniform(0.15, 0.8) * level, 2.0 * self.turning)
        inner = level - differ
        seconds = self._time(0.5 * (level + inner), 3.5)
        sense = self._sense(0.5 * (level + inner), seconds) * (-1.0 if back else 1.0)
        pair = (inner, level) if side > 0 else (level, inner)
        yield from self._hold(sense * pair[0], sense * pair[1], seconds)

    def _shaped(self, name: str, level: float, side: float) -> Iterator[Pair]:
        """Yield what changes all the time: S-curves, weaving, ramps, stop-and-go."""
        seconds = float(self.rng.uniform(2.5, 4.5))
        sense, count = self._sense(level, 0.6 * seconds), round(seconds / self.period)
        sway = min(0.5 * level, self.turning)
        waves = float(self.rng.uniform(1.5, 4.0)) if name == "weave" else 1.0
        beat = float(self.rng.uniform(0.4, 1.0))
        for i in range(count):
            part = i / count
            if name == "ramp":
                v, w = level * (1.0 - abs(2.0 * part - 1.0)), 0.0
            elif name == "stop_and_go":
                v, w = (level if (i * self.period) % (2 * beat) < beat else 0.0), 0.0
            elif name == "s_curve":
                v, w = level - sway, side * sway * (1.0 if part < 0.5 else -1.0)
            else:
                v, w = level - sway, side * sway * math.sin(2.0 * math.pi * waves * part)
            yield sense * v - w, sense * v + w

    def _home(self) -> Iterator[Pair]:
        """Turn towards (or the rear towards) a place near the middle and drive there by sight."""
        goal = self.rng.uniform(-0.35, 0.35, 2) * self.limit
        level = float(self.rng.uniform(0.4, 1.0))
        x, y, yaw = self.pose
        error = _wrap(math.atan2(goal[1] - y, goal[0] - x) - yaw)
        sense = 1.0 if abs(error) < 0.6 * math.pi else -1.0
        for _ in range(round(9.0 / self.period)):
            x, y, yaw = self.pose
            aim = math.atan2(goal[1] - y, goal[0] - x) + (0.0 if sense > 0 else math.pi)
            error = _wrap(aim - yaw)
            if math.hypot(goal[0] - x, goal[1] - y) < 0.2 * self.limit:
                return
            turn = float(np.clip(0.9 * error, -1.0, 1.0)) * self.turning
            turn = math.copysign(max(abs(turn), 0.06), turn) if abs(error) > 0.15 else turn
            ahead = sense * max(level - 2.0 * abs(turn), 0.15) if abs(error) < 0.6 else 0.0
            yield max(-1.0, min(1.0, ahead - turn)), max(-1.0, min(1.0, ahead + turn))


def _wrap(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
