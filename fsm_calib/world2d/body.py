"""The robot as a pymunk body: the same compiled step as the roll-out's, plus whatever pymunk adds (walls,
boards).

Before each step the body gets the mean velocity of the step and the force that brings it to the velocity
after it, so that pymunk's own integrator reproduces the roll-out to rounding when nothing is touched, and its
contact solver acts on the velocity that the wheels want when something is. While nothing can be touched, many
steps are made at once by the same compiled function, which then moves the body as pymunk would, bit for bit
(`ride_free`).
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pymunk

from fsm_calib.errors import InputError
from fsm_calib.types import FloatArray, Pose2, WheelCommand
from fsm_calib.world2d.kernel import kernel, memory_places
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import active_flags
from fsm_calib.world2d.slots import (
    ANGLE,
    BENCH_SIZE,
    COM_X,
    COM_Y,
    HALF_AXLE,
    INERTIA,
    MASS,
    MEMORY,
    RIM,
    TIME,
)

LARGEST_STEP = 0.01
"""Longest step that a world may ask for [s]; see `largest_stable_step`."""
STEPS_PER_TIME_CONSTANT = 5.0
"""Steps that each time constant of the robot is divided into at least: the trapezoid rule is then right to
0.3 %."""


def largest_stable_step(parameters: FloatArray) -> float:
    """Return the longest step [s] at which the robot is still simulated accurately.

    The friction enters implicitly and is stable for any step; what limits the step is that it must resolve
    the motors' time constants (`STEPS_PER_TIME_CONSTANT`) and stay below `LARGEST_STEP`.
    """
    table = parameter_table()
    table.check(parameters)
    fastest = min(parameters[table.index["tau_forward"]], parameters[table.index["tau_turn"]])
    return min(LARGEST_STEP, fastest / STEPS_PER_TIME_CONSTANT)


def _floats(array: FloatArray) -> memoryview[float]:
    """Return a view of an array whose elements are read and written as plain floats: four times faster."""
    return array.data.cast("B").cast("d")


class RobotBody:
    """A Duckiebot in a pymunk space.

    Parameters
    ----------
    space : pymunk.Space
        Without gravity or damping of its own (``damping`` 1): the floor's normal forces are ours.
    parameters : array, shape (p,)
        See `parameters`; effects are on where they differ from null.
    pose : Pose2
        Of the axle centre at the start; the robot rests.

    Shapes for collisions may be attached to `body`, in the frame `base`.

    Raises
    ------
    InputError
        For parameters outside their bounds, a pose that is not finite, or a space with gravity or damping.
    """

    def __init__(self, space: pymunk.Space, parameters: FloatArray, pose: Pose2 | None = None) -> None:
        pose = pose or Pose2()
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            raise InputError(f"the robot's pose is {pose}, expected finite numbers")
        if tuple(space.gravity) != (0.0, 0.0) or space.damping != 1.0:
            raise InputError(
                "the robot's space has gravity or damping", cure="Use Space() as it comes: seen from above."
            )
        self.space = space
        self._bench = np.zeros(BENCH_SIZE)
        self._state = np.zeros(MEMORY + memory_places()[1])
        self._slots, self._work = _floats(self._state), _floats(self._bench)
        self._ride, self._held, self._end = np.zeros(12), np.zeros((1, 2)), np.zeros((1, 3))
        self._ridden, self._hold = _floats(self._ride), _floats(self._held)
        self._is_plain = False
        self._history: deque[tuple[float, float, float]] = deque([(-math.inf, 0.0, 0.0)])
        self.set_parameters(parameters)
        self.body = self._make_body(pose)
        space.add(self.body)
        # no step: the program is loaded or compiled before time runs
        self._make_steps(np.zeros((0, 2)), LARGEST_STEP, np.zeros((0, 3)))

    def _make_body(self, pose: Pose2) -> pymunk.Body:
        """Return a resting pymunk body at the pose."""
        body = pymunk.Body(self._bench[MASS], self._bench[INERTIA])
        body.center_of_gravity = (self._bench[COM_X], self._bench[COM_Y])
        body.angle = pose.theta
        body.position = (pose.x, pose.y)
        return body

    def set_parameters(self, parameters: FloatArray) -> None:
        """Change the physics (wear, a fault) from now on; motion and memories go on. InputError as at the
        start.
        """
        parameter_table().check(parameters)
        self._parameters = np.array(parameters, dtype=float)
        self._on = active_flags(self._parameters)
        self._kernel = kernel(bare=not self._on.any())
        self._kernel.begin(self._parameters, self._on, self._bench)
        is_plain = not self._on.any()
        self._delay = 0.0 if is_plain else float(self._kernel.delay(self._parameters, self._on))
        if self._is_plain and not is_plain:
            self._history = deque([(-math.inf, self._hold[0], self._hold[1])])  # what acted until now
        self._is_plain = is_plain
        self._shaped: dict[tuple[float, float], tuple[float, float]] = {}
        if hasattr(self, "body"):
            self.body.mass, self.body.moment = self._bench[MASS], self._bench[INERTIA]
            self.body.center_of_gravity = (self._bench[COM_X], self._bench[COM_Y])

    @property
    def parameters(self) -> FloatArray:
        """A copy of the parameter vector."""
        return self._parameters.copy()

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return float(self._state[TIME])

    @property
    def pose(self) -> Pose2:
        """Pose of the axle centre; theta is not wrapped."""
        x, y = self.body.position
        return Pose2(x, y, self.body.angle)

    @property
    def twist(self) -> tuple[float, float, float]:
        """Forward and leftward speed of the axle centre [m/s] and yaw rate [rad/s], in `base`."""
        angle, (vx, vy), omega = self.body.angle, self.body.velocity, self.body.angular_velocity
        c, s = math.cos(angle), math.sin(angle)
        x, y = self.body.center_of_gravity
        return c * vx + s * vy + omega * y, c * vy - s * vx - omega * x, omega

    @property
    def is_moving(self) -> bool:
        """Whether the robot moves at all."""
        return any(speed != 0.0 for speed in self.twist)

    @property
    def wheel_angles(self) -> tuple[float, float]:
        """How far the wheels have turned, left and right [rad]."""
        return float(self._state[ANGLE]), float(self._state[ANGLE + 1])

    @property
    def rim_speeds(self) -> tuple[float, float]:
        """Speeds of the rims relative to the axle, left and right [m/s]."""
        return float(self._state[RIM]), float(self._state[RIM + 1])

    @property
    def axle_length(self) -> float:
        """Distance between the wheels [m]."""
        return 2.0 * float(self._bench[HALF_AXLE])

    def step(self, command: WheelCommand, dt: float) -> None:
        """Hold `command` for `dt` [s] and advance the space by it.

        Raises
        ------
        InputError
            For a command that is not finite or a step that is not positive or longer than `LARGEST_STEP`.
        """
        if not 0.0 < dt <= LARGEST_STEP:
            raise InputError(f"the step is {dt} s, expected more than 0 and at most {LARGEST_STEP} s")
        if not (math.isfinite(command.left) and math.isfinite(command.right)):
            raise InputError(f"the wheel command is {command}, expected finite numbers")
        self._read_body()
        self._hold[0], self._hold[1] = self._mean_command(command, dt)
        self._make_steps(self._held, dt, self._end)
        self._push_body()
        self.space.step(dt)

    @property
    def is_plain(self) -> bool:
        """Whether no effect is on: commands act at once and as they are, the centre of mass is the axle's."""
        return self._is_plain

    def ride_free(self, commands: FloatArray, dt: float, room: float) -> FloatArray:
        """Make up to n steps of `dt` [s] at once, commands of shape (n, 2) [1], while nothing can be touched.

        Only as many are made as keep the axle's centre within `room` [m] of where it is; they are what as many
        calls of `step` give, to the last bit. Returns the poses after them, shape (m, 3), m <= n. The robot must
        be plain (`is_plain`).
        """
        begin = self._read_body()
        state, bench = self._state.copy(), self._bench.copy()
        poses = np.empty((len(commands), 3))
        self._make_steps(commands, dt, poses)
        away = np.hypot(poses[:, 0] - begin[0], poses[:, 1] - begin[1]) > room
        if away.any():
            self._state[:], self._bench[:] = state, bench
            self._read_body()
            poses = poses[: int(np.argmax(away))]
            self._make_steps(commands[: len(poses)], dt, poses)
        self._held[0] = commands[len(poses) - 1]
        self._move_body()
        return poses

    def _make_steps(self, commands: FloatArray, dt: float, poses: FloatArray) -> None:
        """Make a compiled step of `dt` [s] for each row of commands (n, 2) [1]; fill the poses (n, 3)."""
        self._kernel.ride(
            self._parameters, self._on, self._state, self._bench, self._ride, commands, dt, poses
        )

    def _mean_command(self, command: WheelCommand, dt: float) -> tuple[float, float]:
        """Return the shaped commands that act in this step, late by the delay, averaged over the step."""
        if self._is_plain:
            return command.left, command.right
        left, right = self._shape(command)
        history, now = self._history, self._slots[TIME]
        if len(history) == 1 and history[0][1] == left and history[0][2] == right:
            return left, right  # as before, and nothing else is on its way
        begin, end = now - self._delay, now + dt - self._delay
        history.append((now, left, right))
        while len(history) > 1 and history[1][0] <= begin:
            history.popleft()
        if len(history) == 1:
            return left, right
        total_left = total_right = 0.0
        for i, (since, left, right) in enumerate(history):
            until = history[i + 1][0] if i + 1 < len(history) else math.inf
            part = max(0.0, min(until, end) - max(since, begin))
            total_left, total_right = total_left + part * left, total_right + part * right
        return total_left / dt, total_right / dt

    def _shape(self, command: WheelCommand) -> tuple[float, float]:
        """Return the shaped levels of both wheels; a command that is held is shaped once."""
        key = command.left, command.right
        if key not in self._shaped:
            shape = self._kernel.shape
            left = float(shape(self._parameters, self._on, command.left, 0))
            right = float(shape(self._parameters, self._on, command.right, 1))
            self._shaped = {key: (left, right)}
        return self._shaped[key]

    def _read_body(self) -> tuple[float, float]:
        """Take pose and velocity from pymunk, which contacts may have changed; return the place [m]."""
        ride, body = self._ridden, self.body
        x, y = ride[0], ride[1] = body.position
        ride[2] = body.angle
        ride[3], ride[4] = body.velocity
        ride[5] = body.angular_velocity
        return x, y

    def _push_body(self) -> None:
        """Give pymunk the mean velocity of the step and the force to the velocity after it."""
        _, _, _, _, _, _, vx, vy, omega, fx, fy, torque = self._ridden
        body = self.body
        body.velocity, body.angular_velocity = (vx, vy), omega
        body.force, body.torque = (fx, fy), torque

    def _move_body(self) -> None:
        """Put pymunk's body where a free ride has ended."""
        x, y, theta, vx, vy, omega = self._ride[:6].tolist()
        body = self.body
        body.angle = theta
        body.position = (x, y)
        body.velocity = (vx, vy)
        body.angular_velocity = omega
