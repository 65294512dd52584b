"""The robot as a pymunk body: the same compiled step as the roll-out's, plus whatever pymunk adds (walls,
boards).

Before each step the body gets the mean velocity of the step and the force that brings it to the velocity
after it, so that pymunk's own integrator reproduces the roll-out to rounding when nothing is touched, and its
contact solver acts on the velocity that the wheels want when something is.
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
    HEADING_COS,
    HEADING_SIN,
    INERTIA,
    MASS,
    MEAN_OMEGA,
    MEAN_VX,
    MEAN_VY,
    MEMORY,
    NEXT,
    NEXT_VX,
    NEXT_VY,
    OMEGA,
    RIM,
    THETA,
    TIME,
    L,
    V,
    X,
    Y,
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
        self._history: deque[tuple[float, float, float]] = deque([(-math.inf, 0.0, 0.0)])
        self.set_parameters(parameters)
        self.body = self._make_body(pose)
        space.add(self.body)

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
        self._delay = float(self._kernel.delay(self._parameters, self._on))
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
        self._read_body()
        return float(self._state[V]), float(self._state[L]), float(self._state[OMEGA])

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
        self.prepare(command, dt)
        self.space.step(dt)
        self._slots[TIME] += dt

    def prepare(self, command: WheelCommand, dt: float) -> None:
        """Set the body's velocity and force for a step of `dt` [s] that the caller makes (see `step` for
        errors).
        """
        if not 0.0 < dt <= LARGEST_STEP:
            raise InputError(f"the step is {dt} s, expected more than 0 and at most {LARGEST_STEP} s")
        if not (math.isfinite(command.left) and math.isfinite(command.right)):
            raise InputError(f"the wheel command is {command}, expected finite numbers")
        self._read_body()
        left, right = self._mean_command(command, dt)
        self._kernel.single_step(self._parameters, self._on, self._state, self._bench, left, right, dt)
        self._write_body(dt)

    def _mean_command(self, command: WheelCommand, dt: float) -> tuple[float, float]:
        """Return the shaped commands that act in this step, late by the delay, averaged over the step."""
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

    def _read_body(self) -> None:
        """Take pose and twist of the axle from pymunk, which contacts may have changed."""
        state, bench, body = self._slots, self._work, self.body
        angle = body.angle
        c, s = math.cos(angle), math.sin(angle)
        (state[X], state[Y]), state[THETA] = body.position, angle
        state[HEADING_COS], state[HEADING_SIN] = c, s
        (vx, vy), omega = body.velocity, body.angular_velocity
        state[V] = c * vx + s * vy + omega * bench[COM_Y]
        state[L] = c * vy - s * vx - omega * bench[COM_X]
        state[OMEGA] = omega

    def _write_body(self, dt: float) -> None:
        """Give pymunk the mean velocity of the step and the force to the velocity after it."""
        bench, body = self._work, self.body
        vx, vy, omega = bench[MEAN_VX], bench[MEAN_VY], bench[MEAN_OMEGA]
        push = bench[MASS] / dt
        body.velocity = (vx, vy)
        body.angular_velocity = omega
        body.force = (push * (bench[NEXT_VX] - vx), push * (bench[NEXT_VY] - vy))
        body.torque = bench[INERTIA] / dt * (bench[NEXT + OMEGA] - omega)
