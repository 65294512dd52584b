"""The robot's true motion: the body in its space, stepped in whole ticks."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pymunk

from fsm_calib.types import FloatArray, Pose2, WheelCommand
from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.clearance import free_room
from fsm_calib.world2d.faults import FrozenFrames
from fsm_calib.world2d.obstacles import add_scene, make_space, robot_outline
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.spec import WorldSpec
from fsm_calib.world2d.stages import scene_stages

_NOISE_STREAM = 1
_NOISE_BLOCK = 256
"""Knots of the drive noise that one generator draws."""
_Place = tuple[float, float, float]
"""x, y [m], theta [rad]: a pose, a microsecond cheaper."""
_WEAR_GRAIN = 0.02
"""Driven distance after which a worn ratio is brought up to date [m]."""
_MOST_AT_ONCE = 1000
"""Ticks made in one call while nothing is near: 2 s."""
_LEAST_AT_ONCE = 8
"""Ticks that are worth such a call, which costs as much as a few of them one by one."""
_BESIDE = 25
"""Ticks made one by one, beside an obstacle, until the room around the robot is asked for again: 0.05 s."""


class Motion:
    """The body in its space, stepped in whole ticks, with drive noise, wear and the changes of scene."""

    def __init__(self, spec: WorldSpec, parameters: FloatArray) -> None:
        self._spec, self._fresh = spec, parameters
        self.space = make_space()
        self.body = RobotBody(self.space, parameters, spec.start)
        self.space.add(robot_outline(self.body.body))
        self._stages = deque(scene_stages(spec))
        self._shapes: list[pymunk.Shape] = []
        self.ticks, self.odometer, self.worn_at = 0, 0.0, 0.0
        self._noise: list[list[float]] = []
        self._noise_block = -1
        self._recent: deque[_Place] = deque(maxlen=1 + math.ceil(spec.optics.exposure / spec.settings.step))
        self._trace_every = max(1, round(spec.settings.trace_period / spec.settings.step))
        self.trace: list[tuple[float, float, float, float]] = []
        self._freeze_at = min((f.at for f in spec.faults if isinstance(f, FrozenFrames)), default=math.inf)
        self._frozen: tuple[float, list[Pose2]] | None = None
        self._note()
        self._change_scene()

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.ticks * self._spec.settings.step

    def _note(self) -> None:
        (x, y), theta = self.body.body.position, self.body.body.angle
        self._recent.append((x, y, theta))
        if self.ticks % self._trace_every == 0:
            self.trace.append((self.time, x, y, theta))
        if self._frozen is None and self.time >= self._freeze_at:
            self._frozen = self.time, self.recent

    @property
    def recent(self) -> list[Pose2]:
        """The poses of the last exposure time, the newest last."""
        return [Pose2(*place) for place in self._recent]

    def frozen_view(self) -> tuple[float, list[Pose2]]:
        """Return when the camera froze [s] and the poses of that exposure; now, when it has not."""
        return self._frozen or (self.time, self.recent)

    def _change_scene(self) -> None:
        """Exchange the obstacles when a fault changes the scene."""
        while self._stages and self._stages[0][0] <= self.time:
            _, scene = self._stages.popleft()
            if self._shapes:
                self.space.remove(*self._shapes)
            self._shapes = add_scene(self.space, scene)

    def _noise_at(self, tick: int) -> tuple[float, float]:
        """Return the relative deviation of both wheels' answers [1], linear between knots."""
        settings = self._spec.settings
        place = tick * settings.step / settings.noise_period
        knot = int(place)
        block, index = divmod(knot, _NOISE_BLOCK)
        if block != self._noise_block:
            draws = [
                np.random.default_rng([self._spec.seed, _NOISE_STREAM, b]).standard_normal((_NOISE_BLOCK, 2))
                for b in (block, block + 1)
            ]
            self._noise, self._noise_block = (settings.drive_noise * np.vstack(draws)).tolist(), block
        share = place - knot
        (a, b), (c, d) = self._noise[index], self._noise[index + 1]
        return a + share * (c - a), b + share * (d - b)

    def step(self, left: float, right: float) -> None:
        """Hold the commands [1] for one step."""
        settings = self._spec.settings
        if settings.drive_noise > 0.0 and (left != 0.0 or right != 0.0):
            noise = self._noise_at(self.ticks)
            left, right = left * (1.0 + noise[0]), right * (1.0 + noise[1])
        self._wear_down()
        self.body.step(WheelCommand(left, right), settings.step)
        self.ticks += 1
        before = self._recent[-1]
        self._note()
        after = self._recent[-1]
        self.odometer += math.hypot(after[0] - before[0], after[1] - before[1])
        if self._stages:
            self._change_scene()

    def run(self, left: float, right: float, ticks: int) -> None:
        """Hold the commands [1] for many steps; those made at once, far from everything, give the same bits."""
        while ticks > 0:
            made = self._ride(left, right, min(ticks, _MOST_AT_ONCE))
            if made == 0:
                made = min(ticks, _BESIDE)
                for _ in range(made):
                    self.step(left, right)
            ticks -= made

    def _ride(self, left: float, right: float, most: int) -> int:
        """Make up to `most` steps at once and return how many were made: none where something may be near, is
        about to change, or changes the physics on the way.
        """
        is_watched = self._stages or (self._frozen is None and self._freeze_at < math.inf)
        if most < _LEAST_AT_ONCE or is_watched or self._spec.wear.per_metre != 0.0 or not self.body.is_plain:
            return 0
        x, y, _ = self._recent[-1]
        room = free_room(self.space, (x, y))
        if room <= 0.0:
            return 0
        poses = self.body.ride_free(self._commands(left, right, most), self._spec.settings.step, room)
        self._note_all(poses.tolist())
        return len(poses)

    def _commands(self, left: float, right: float, most: int) -> FloatArray:
        """Return the commands of the next steps with their noise, shape (n, 2); the noise's block may end
        before `most` steps.
        """
        settings, commands = self._spec.settings, np.array((left, right))
        if settings.drive_noise == 0.0 or not commands.any():
            return np.tile(commands, (most, 1))
        self._noise_at(self.ticks)  # has the knots of this block drawn
        place = np.arange(self.ticks, self.ticks + most) * settings.step / settings.noise_period
        block, index = np.divmod(place.astype(int), _NOISE_BLOCK)
        place, index = place[block == self._noise_block], index[block == self._noise_block]
        knots, share = np.array(self._noise), (place - place.astype(int))[:, None]
        noise = knots[index] + share * (knots[index + 1] - knots[index])
        return np.asarray(commands * (1.0 + noise))

    def _note_all(self, poses: list[list[float]]) -> None:
        """Keep the books of the steps that led to `poses`: clock, odometer, trace and the last exposure."""
        x, y, _ = self._recent[-1]
        odometer = self.odometer
        for next_x, next_y, _ in poses:
            odometer += math.hypot(next_x - x, next_y - y)
            x, y = next_x, next_y
        first = -(self.ticks + 1) % self._trace_every
        for number in range(first, len(poses), self._trace_every):
            time = (self.ticks + 1 + number) * self._spec.settings.step
            x, y, theta = poses[number]
            self.trace.append((time, x, y, theta))
        self._recent.extend((x, y, theta) for x, y, theta in poses[-(self._recent.maxlen or 0) :])
        self.odometer, self.ticks = odometer, self.ticks + len(poses)

    def _wear_down(self) -> None:
        if self._spec.wear.per_metre != 0.0 and self.odometer - self.worn_at >= _WEAR_GRAIN:
            self.worn_at = self.odometer
            self.body.set_parameters(self.worn_parameters())

    def worn_parameters(self) -> FloatArray:
        """Return the parameters as they are now: the gains share the drift of the ratio."""
        vector, table = self._fresh.copy(), parameter_table()
        factor = math.sqrt(self._spec.wear.factor(self.worn_at))
        vector[table.place("gain_left")] *= factor
        vector[table.place("gain_right")] /= factor
        return vector
