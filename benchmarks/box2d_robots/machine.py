"""A robot in a Box2D world: its body there, wheels and motors beside it, laws that act in every step."""

from __future__ import annotations

import math

import Box2D
import numpy as np

from benchmarks.box2d_robots import core
from benchmarks.box2d_robots.control import Controller
from benchmarks.box2d_robots.parts import Hook, Pair, Plant, Setup
from benchmarks.robot_sets.driving import Array

STEP = 0.002  # s
PARTS = 4  # of a step, in which wheels and motors advance
PRESLIDE = 0.012  # rad, of a shaft's dry friction
PAIRS = {
    "duty": core.DUTY,
    "volts": core.VOLTS,
    "torque_const": core.KT,
    "emf_const": core.KE,
    "winding": core.RES,
    "dry": core.DRY,
    "viscous": core.VISC,
    "torque": core.TORQUE,
    "block": core.BLOCK,
    "grip": core.GRIP,
    "along": core.ALONG,
    "across": core.ACROSS,
    "relax": core.RELAX,
    "roll": core.ROLL,
    "radius": core.RADIUS,
    "track": core.TRACK,
    "toe": core.TOE,
    "scrub": core.SCRUB,
    "base": core.BASE,
    "lift": core.LIFT,
    "floor_x": core.FLOOR_X,
    "floor_y": core.FLOOR_Y,
    "play": core.PLAY,
    "side": core.SIDE,
    "slope": core.SLOPE,
}


class Now:
    """What laws see and set in a step: time, pose and command; views of the inputs X and of the state.

    Inputs go back to their nominal values before each step. `push` is force along and to the left [N] and
    torque about the axle's middle [N m]; `slope` gravity along the floor [m/s2] in the body's frame;
    `third` the sliding friction, a fork's rolling resistance and its pivot's friction.
    """

    duty: Array
    volts: Array
    torque_const: Array
    emf_const: Array
    winding: Array
    dry: Array
    viscous: Array
    torque: Array
    block: Array
    grip: Array
    along: Array
    across: Array
    relax: Array
    roll: Array
    radius: Array
    track: Array
    toe: Array
    scrub: Array
    base: Array
    lift: Array
    floor_x: Array
    floor_y: Array
    play: Array
    side: Array
    slope: Array

    def __init__(self, inputs: Array, state: Array, start: tuple[float, float, float], step: float) -> None:
        """Name the parts of the arrays."""
        self.t, self.step = 0.0, step
        self.x, self.y, self.yaw = start
        self.command = [0.0, 0.0]
        self.touched = False
        for name, at in PAIRS.items():
            setattr(self, name, inputs[at : at + 2])
        self.push = inputs[core.FORCE : core.FORCE + 3]
        self.third = inputs[core.SLIDE : core.SWIVEL + 1]
        self.rate, self.angle = state[core.RATE :][:2], state[core.ANGLE :][:2]
        self.turned = state[core.TURNED :][:2]  # the motors' side of the gears
        self.turned_rate = state[core.ROTOR :][:2]
        self.amps, self.load = state[core.AMPS :][:2], state[core.LOAD :][:2]
        self.slip, self.pull = state[core.SLIP :][:2], state[core.PULL :][:2]
        self.motion = state[core.VX : core.W + 1]  # along, to the left [m/s], turn [rad/s]
        self.swing = state[core.SWING : core.SWING + 1]

    def to_body(self, x: float, y: float) -> Pair:
        """Return a vector of the floor in the body's frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return c * x + s * y, c * y - s * x


def _params(plant: Plant, reverse: float) -> Array:
    p, third = np.zeros(core.PARAMS), plant.third
    cx, cy, ch = plant.centre
    less = min(plant.wheel_inertia, plant.rotor_inertia)
    values = {
        core.MASS: plant.mass,
        core.CX: cx,
        core.CY: cy,
        core.CH: ch,
        core.JW: plant.wheel_inertia,
        core.JR: plant.rotor_inertia,
        core.TAU: plant.electric_lag,
        core.ETA: plant.efficiency,
        core.THIRD_X: third.x,
        core.THIRD_Y: third.half_y,
        core.AHEAD: third.ahead,
        core.TRAIL: max(third.trail, 1e-3),
        core.FORK: float(third.kind == "fork"),
        core.PRE: PRESLIDE,
        core.SUBS: PARTS,
        core.REVERSE: reverse,
        core.MESH: 0.1 * less / 0.0005**2,
    }
    for at, value in values.items():
        p[at] = value
    return p


def _inputs(plant: Plant) -> Array:
    x, third = np.zeros(core.INPUTS), plant.third
    pairs = {
        core.VOLTS: (plant.volts, plant.volts),
        core.KT: plant.torque_const,
        core.KE: plant.emf_const,
        core.RES: plant.winding,
        core.DRY: plant.dry,
        core.VISC: plant.viscous,
        core.GRIP: (plant.grip, plant.grip),
        core.ALONG: (plant.stiff[0],) * 2,
        core.ACROSS: (plant.stiff[1],) * 2,
        core.RELAX: (plant.relax,) * 2,
        core.ROLL: (plant.rolling,) * 2,
        core.RADIUS: plant.radius,
        core.TRACK: (0.5 * plant.axle, -0.5 * plant.axle),
        core.SIDE: (1.0, 1.0),
    }
    for at, (left, right) in pairs.items():
        x[at], x[at + 1] = left, right
    x[core.SLIDE], x[core.CROLL], x[core.SWIVEL] = third.slide, third.roll, third.swivel
    return x


class Machine:
    """A robot under way; in the plane it cannot fall over."""

    has_fallen = False

    def __init__(self, setup: Setup, run: int, start: tuple[float, float, float], step: float = STEP) -> None:
        """Put the robot at rest at `start` and let its laws take hold."""
        self.setup, self.plant, self.step, self.run = setup, setup.plant, step, run
        self.params, self.nominal = _params(self.plant, setup.robot.reverse), _inputs(self.plant)
        self.inputs, self.state, self.out = self.nominal.copy(), np.zeros(core.STATES), np.zeros(3)
        self.world = Box2D.b2World(gravity=(0.0, 0.0), doSleep=False)
        self.body = self._chassis(start)
        self.now = Now(self.inputs, self.state, start, step)
        self.turns = 0.0  # what the body's angle was turned back, to keep its single precision fine
        self.before = (0.0, 0.0)
        self.controller = Controller(setup.control, step) if setup.control else None
        stages = (setup.command, setup.drive, setup.supply, setup.motor, setup.floor, setup.body)
        made: list[list[Hook]] = [[make(self, run) for make in stage] for stage in stages]
        self.first, self.rest = made[0], [hook for stage in made[1:] for hook in stage]
        core.advance(self.params, self.inputs, self.state, 1e-9, self.out)  # loads of a robot at rest

    def _chassis(self, start: tuple[float, float, float]) -> Box2D.b2Body:
        body = self.world.CreateDynamicBody(position=start[:2], angle=start[2], allowSleep=False)
        size = (0.75 * self.plant.axle, 0.55 * self.plant.axle)
        body.CreatePolygonFixture(box=size, density=1.0, friction=0.3, restitution=0.1)
        cx, cy, _ = self.plant.centre
        body.massData = Box2D.b2MassData(mass=self.plant.mass, center=(cx, cy), I=self.plant.inertia)
        return body

    @property
    def motors(self) -> Pair:
        """How far the motors have turned [rad]."""
        return float(self.now.turned[0]), float(self.now.turned[1])

    def advance(self, told: Pair) -> None:
        """Advance by one step under a command; the engine moves the body by the forces found."""
        now, body = self.now, self.body
        now.command[0], now.command[1] = told
        for hook in self.first:
            hook(now)
        left, right = self.controller.duty(now) if self.controller else now.command
        self.inputs[0], self.inputs[1] = min(max(left, -1.0), 1.0), min(max(right, -1.0), 1.0)
        for hook in self.rest:
            hook(now)
        fx, fy, tz = core.felt(self.params, self.inputs, self.state, self.step, now.yaw, self.out)
        body.ApplyForceToCenter((fx, fy), True)
        body.ApplyTorque(tz, True)
        self.world.Step(self.step, 8, 4)
        self._look()
        now.t += self.step

    def _look(self) -> None:
        """Read the body's motion from the engine."""
        body, now = self.body, self.now
        speed, place, angle = body.linearVelocity, body.position, body.angle
        if abs(angle) > 3.3:
            turn = math.copysign(2.0 * math.pi, angle)
            body.angle = angle = angle - turn
            self.turns += turn
        now.x, now.y, now.yaw = place.x, place.y, angle + self.turns
        moving = (speed.x, speed.y)
        world = (*moving, *self.before, body.angularVelocity, now.yaw)
        core.begin(self.params, self.state, self.inputs, self.nominal, world, self.step)
        self.before = moving
