"""What is recorded of a run: the tag's poses as a camera reports them, commands, and wheel encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.exudyn_robots.engine import Truth
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts


@dataclass
class Sensing:
    """Sensors of a robot. Metres, radians, seconds; `marker_*`: a place where reported poses are wrong."""

    pose_hz: float
    position_sd: float
    heading_sd: float
    heavy_tail: float
    missing: float
    stamp_jitter: float
    command_hz: float
    log_changes: bool
    ticks_per_turn: int
    encoder_hz: float
    tag: tuple[float, float]
    tag_yaw: float
    pose_delay: float = 0.0
    pose_delay_swing: float = 0.0
    clock_rate: float = 0.0
    clock_bend: float = 0.0
    marker_x: float = 0.0
    marker_y: float = 0.0
    marker_r: float = 0.0
    marker_shift: tuple[float, float] = (0.0, 0.0)
    marker_turn: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator, encoders: bool) -> Sensing:
        """Sensors as they come: 10 to 50 Hz, 0.5 to 3 mm, 3 to 15 mrad; encoders in half of the robots."""
        hz = float(rng.choice([10.0, 15.0, 20.0, 25.0, 30.0, 50.0]))
        reach, angle = rng.uniform(0.001, 0.002), rng.uniform(-math.pi, math.pi)
        has = bool(rng.random() < 0.45) or encoders
        return cls(
            pose_hz=hz,
            position_sd=float(np.exp(rng.uniform(np.log(0.0005), np.log(0.003)))),
            heading_sd=float(np.exp(rng.uniform(np.log(0.003), np.log(0.015)))),
            heavy_tail=float(rng.uniform(2.5, 6.0)) if rng.random() < 0.3 else 0.0,
            missing=float(rng.uniform(0.0, 0.03)) if rng.random() < 0.6 else 0.0,
            stamp_jitter=float(rng.uniform(0.0001, 0.001)),
            command_hz=float(rng.choice([20.0, 25.0, 40.0, 50.0])),
            log_changes=bool(rng.random() < 0.25),
            ticks_per_turn=int(rng.choice([135, 360, 512, 1024, 2048, 4096])),
            encoder_hz=float(rng.choice([20.0, 25.0, 50.0])) if has else 0.0,
            tag=(float(reach * math.cos(angle)), float(reach * math.sin(angle))),
            tag_yaw=float(rng.uniform(0.001, 0.005) * rng.choice([-1, 1])),
        )

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        """Time of the robot's clock at which a pose with this stamp was valid: stamp = t + rate t +
        bend t2 / 60.
        """
        t = np.asarray(stamp, float)
        for _ in range(4):
            t = (stamp - self.clock_bend * t * t / 60.0) / (1.0 + self.clock_rate)
        delay = self.pose_delay * (1.0 + self.pose_delay_swing * np.sin(2.0 * math.pi * t / 13.0))
        return np.maximum(t - delay, 0.0)

    def observe(self, truth: Truth, stamp: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Noise-free poses (n, 3) with these stamps (s), and whether an effect of a place or moment acts."""
        t = self.true_time(stamp)
        base = np.stack([np.interp(t, truth.t, truth.pose[:, k]) for k in range(3)], axis=1)
        active = np.interp(t, truth.t, truth.active) > 0.5
        x, inside = self.report(base)
        return x, active | inside

    def report(self, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tag poses of robot poses (n, 3), and whether the misplaced reference was in use."""
        c, s = np.cos(base[:, 2]), np.sin(base[:, 2])
        x = base[:, 0] + c * self.tag[0] - s * self.tag[1]
        y = base[:, 1] + s * self.tag[0] + c * self.tag[1]
        h = base[:, 2] + self.tag_yaw
        inside = np.zeros(len(x), bool)
        if self.marker_r > 0.0:
            inside = np.hypot(x - self.marker_x, y - self.marker_y) < self.marker_r
            dx, dy = x - self.marker_x, y - self.marker_y
            ct, st = math.cos(self.marker_turn), math.sin(self.marker_turn)
            x = np.where(inside, self.marker_x + ct * dx - st * dy + self.marker_shift[0], x)
            y = np.where(inside, self.marker_y + st * dx + ct * dy + self.marker_shift[1], y)
            h = np.where(inside, h + self.marker_turn, h)
        return np.stack([x, y, h], axis=1), inside


def _stamps(rng: np.random.Generator, hz: float, end: float, jitter: float) -> np.ndarray:
    """Sampling times: own phase, jitter, strictly growing."""
    t = np.arange(rng.uniform(0.0, 1.0 / hz), end, 1.0 / hz)
    t = t + np.clip(jitter * rng.standard_normal(len(t)), -0.2 / hz, 0.2 / hz)
    return t[t >= 0.0]


def _noise(rng: np.random.Generator, n: int, sd: float, tail: float) -> np.ndarray:
    """Normal, or with heavy tails (5 % of the values `tail` times wider)."""
    e = sd * rng.standard_normal(n)
    return e if tail == 0.0 else np.where(rng.random(n) < 0.05, tail * e, e)


def recorded(
    name: str,
    sheet: dict[str, float],
    sensing: Sensing,
    truth: Truth,
    commands: np.ndarray,
    rng: np.random.Generator,
) -> Recording:
    """What is recorded of a run. `commands`: rows left, right at command_hz from time 0."""
    end = float(truth.t[-1])
    t = np.arange(len(commands)) / sensing.command_hz
    keep = np.ones(len(t), bool)
    if sensing.log_changes:
        keep[1:] = np.any(np.diff(commands, axis=0) != 0.0, axis=1)
        keep[:: int(sensing.command_hz)] = True
    last = end * (1.0 + sensing.clock_rate) + sensing.clock_bend * end * end / 60.0
    stamp = _stamps(rng, sensing.pose_hz, last, sensing.stamp_jitter)
    pose, _ = sensing.observe(truth, stamp)
    n = len(stamp)
    pose = pose + np.stack(
        [
            _noise(rng, n, sensing.position_sd, sensing.heavy_tail),
            _noise(rng, n, sensing.position_sd, sensing.heavy_tail),
            _noise(rng, n, sensing.heading_sd, sensing.heavy_tail),
        ],
        axis=1,
    )
    pose[:, 2] = (pose[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
    there = rng.random(n) >= sensing.missing
    return Recording(
        robot=RobotFacts(name=name, **sheet),
        command=CommandTrack(np.round(t[keep], 6), *np.round(commands[keep].T, 6)),
        pose=PoseTrack(stamp[there], *pose[there].T),
        wheel_angle=_encoders(sensing, truth, end, rng) if sensing.encoder_hz > 0.0 else None,
        source=name,
    )


def _encoders(sensing: Sensing, truth: Truth, end: float, rng: np.random.Generator) -> WheelPair:
    stamp = _stamps(rng, sensing.encoder_hz, end, 0.0)
    per = sensing.ticks_per_turn / (2.0 * math.pi)
    left, right = (np.floor(np.interp(stamp, truth.t, truth.angle[:, i]) * per) / per for i in range(2))
    return WheelPair(stamp, left, right, "rad", 1.0 / per)
