"""Brush tyres in the plane: bristles that the rolling wheel carries away, limited by grip times load.

The steady force is stiffness * load * slip (Pacejka, Tyre and Vehicle Dynamics, ch. 3 and 7: the single-point
model with a relaxation length); at rest the bristles hold like springs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.physx_robots.robots import Robot

if TYPE_CHECKING:
    from benchmarks.physx_robots.simulate import State

DAMPING = 0.3  # of critical, of wheel and bristles


class BrushPair:
    """The two driven wheels' tyres; the engine's own contact carries load alone then."""

    def __init__(self, robot: Robot, step: float) -> None:
        self.robot, self.step = robot, step
        self.bristle = [[0.0, 0.0], [0.0, 0.0]]  # m ahead, left of each wheel
        self.twist = [0.0, 0.0]  # rad
        self.places = (0.5 * robot.axle, -0.5 * robot.axle)
        self.springs = []
        for load, wheel, motor in zip(robot.loads, robot.wheels, robot.motors):
            light = motor.rotor / wheel.radius**2 + 0.5 * wheel.mass  # kg at the rim
            ahead = load * robot.tyre.stiffness / robot.tyre.length
            ahead = min(ahead, 0.2 * light / step**2)  # stiffer ones would not be followed by the step
            side = min(load * robot.tyre.side_stiffness / robot.tyre.length, 0.02 * robot.mass / step**2)
            self.springs.append((ahead, side, 2.0 * DAMPING * math.sqrt(ahead * light)))

    def apply(self, state: State, torque: np.ndarray) -> None:
        """Add the tyres' forces to the state's, and their torques to the wheels'."""
        robot, tyre, step = self.robot, self.robot.tyre, self.step
        cos, sin = math.cos(state.yaw), math.sin(state.yaw)
        for side in (0, 1):
            wheel, load, y = robot.wheels[side], robot.loads[side], self.places[side]
            radius = wheel.radius
            if wheel.oval:
                radius *= 1.0 + wheel.oval * math.cos(2.0 * (state.angle[side] + wheel.phase))
            roll = state.rate[side] * radius
            carried = abs(roll)
            vx = state.vx - robot.nap_speed[0] * carried
            vy = state.vy - robot.nap_speed[1] * carried
            slip_x = roll - (vx * cos + vy * sin - state.turn * y)
            slip_y = vx * sin - vy * cos
            spring_x, spring_y, damping = self.springs[side]
            length_x = (
                load * tyre.stiffness / spring_x
            )  # keeps the steady stiffness where the spring was limited
            length_y = load * tyre.side_stiffness / spring_y
            bristle = self.bristle[side]
            bristle[0] += step * (slip_x - carried / length_x * bristle[0])
            bristle[1] += step * (slip_y - carried / length_y * bristle[1])
            ahead, left = spring_x * bristle[0], spring_y * bristle[1]
            used = math.hypot(ahead / tyre.grip, left / tyre.side_grip) / (load * state.grip[side])
            if used > 1.0:
                bristle[0] /= used
                bristle[1] /= used
                ahead /= used
                left /= used
            else:
                ahead += damping * slip_x * (1.0 - used)
            state.fx += ahead * cos - left * sin
            state.fy += ahead * sin + left * cos
            state.moment -= ahead * y
            torque[side] -= ahead * radius
            if tyre.spin_arm:
                self._twist(state, side, carried)

    def _twist(self, state: State, side: int, carried: float) -> None:
        """Add the moment of a contact patch that is turned on the spot; rolling lets it unwind."""
        tyre = self.robot.tyre
        twist = self.twist[side] + self.step * (state.turn - carried / (2.0 * tyre.length) * self.twist[side])
        self.twist[side] = twist = max(-tyre.spin_angle, min(tyre.spin_angle, twist))
        state.moment -= tyre.spin_arm * self.robot.loads[side] * twist / tyre.spin_angle
