"""The robot and its floor as bodies of the DART engine.

Tyres are spheres (one contact point under the hub, exact against a box); a wide tyre is two spheres on one
hub that may lean about its line on the floor, so that both carry half of the load as an elastic tread does.
(On a rigid axle of wheels that differ by tenths of a millimetre only the inner sphere of the larger wheel and
the outer one of the smaller touch: an axle that lies half a tyre's width aside, not a tyre that scrubs.) A hub
off the tyre's centre is a shifted sphere; an oval tyre changes its radius with the angle of the wheel. Gears with lost motion are two revolute joints in a row, the second one between limits. A tyre that
creeps sideways sits on a damped bearing about the forward axis: a sphere that rolls slowly sideways under
load and is put upright again after every step, which a sphere does not notice.
"""

from __future__ import annotations

from dataclasses import dataclass

import dartpy as dart
import numpy as np

from benchmarks.dart_robots.truth import GRAVITY, Truth, loads

FOOT_GAP = 0.002  # m: clearance of the foot that keeps a robot from tipping over its wheels
FOOT_RADIUS = 0.008
FORK_TRAIL = 0.6  # trail of a swivelling caster in radii of its wheel
RELAXATION = 0.02  # s
FLOOR_GRIP = 10.0  # DART takes the lower one of two bodies' coefficients


@dataclass
class Wheel:
    """Handles of one wheel: the joint that the motor turns, the one with lost motion, the creeping one."""

    motor: dart.dynamics.RevoluteJoint
    hub: dart.dynamics.RevoluteJoint | None
    roller: dart.dynamics.RevoluteJoint | None
    body: dart.dynamics.BodyNode
    shape: dart.dynamics.SphereShape
    grips: list[dart.dynamics.DynamicsAspect]

    def angle(self) -> float:
        """Return the wheel's angle against the chassis [rad]."""
        angle = self.motor.getPosition(0)
        return float(angle if self.hub is None else angle + self.hub.getPosition(0))

    def rate(self) -> float:
        """Return the wheel's rate against the chassis [rad/s]."""
        rate = self.motor.getVelocity(0)
        return float(rate if self.hub is None else rate + self.hub.getVelocity(0))


@dataclass
class Built:
    """A world that is ready to step."""

    world: dart.simulation.World
    base: dart.dynamics.BodyNode
    root: dart.dynamics.FreeJoint
    wheels: tuple[Wheel, Wheel]
    floor: dart.dynamics.Joint


def _at(x: float, y: float, z: float) -> dart.math.Isometry3:
    frame = dart.math.Isometry3()
    frame.set_translation([x, y, z])
    return frame


def _ball(
    body: dart.dynamics.BodyNode, radius: float, at: tuple[float, float, float], grip: float
) -> tuple[dart.dynamics.SphereShape, dart.dynamics.DynamicsAspect]:
    shape = dart.dynamics.SphereShape(radius)
    node = body.createShapeNode(shape)
    node.setRelativeTranslation(list(at))
    node.createCollisionAspect()
    aspect = node.createDynamicsAspect()
    aspect.setFrictionCoeff(grip)
    return shape, aspect


def _solid(body: dart.dynamics.BodyNode, mass: float, moments: tuple[float, float, float]) -> None:
    body.setInertia(dart.dynamics.Inertia(mass, [0.0, 0.0, 0.0], np.diag(moments)))


def build(truth: Truth, dt: float) -> Built:
    """Build floor and robot, the robot at the origin with its wheels on the floor."""
    world = dart.simulation.World()
    world.setTimeStep(dt)
    # a robot that stands still must not be put to sleep
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    angle, heading = truth.place.tilt
    fall = GRAVITY * np.sin(angle)
    world.setGravity([fall * np.cos(heading), fall * np.sin(heading), -GRAVITY * np.cos(angle)])
    world.getConstraintSolver().setCollisionDetector(dart.collision.DARTCollisionDetector())
    floor = _floor(truth)
    world.addSkeleton(floor)
    robot = dart.dynamics.Skeleton("robot")
    root, base = robot.createFreeJointAndBodyNodePair()
    body = truth.body
    base.setInertia(dart.dynamics.Inertia(body.mass, list(body.centre), np.diag(body.inertia)))
    if body.payload:
        joint, load = robot.createWeldJointAndBodyNodePair(base)
        joint.setTransformFromParentBodyNode(_at(*body.payload_at))
        moment = body.payload * 0.03**2
        _solid(load, body.payload, (moment, moment, moment))
    wheels = (_wheel(robot, base, truth, 0), _wheel(robot, base, truth, 1))
    down = -float(np.mean(body.radius))
    if body.caster == "ball":
        # its friction is applied as a force (`simulate`)
        _ball(base, body.caster_radius, (body.caster_arm, 0.0, down + body.caster_radius), 0.0)
    else:
        _fork(robot, base, truth, down)
    _ball(base, FOOT_RADIUS, (-body.caster_arm, 0.0, down + FOOT_RADIUS + FOOT_GAP), 0.02)
    root.setPositions([0.0, 0.0, 0.0, 0.0, 0.0, max(body.radius) + max(map(abs, body.hub_offset))])
    world.addSkeleton(robot)
    return Built(world, base, root, wheels, floor.getJoint(0))


def _floor(truth: Truth) -> dart.dynamics.Skeleton:
    floor = dart.dynamics.Skeleton("floor")
    if truth.place.nap_carry:
        joint, body = floor.createTranslationalJoint2DAndBodyNodePair()
        joint.setActuatorType(dart.dynamics.ActuatorType.VELOCITY)
        body.setGravityMode(False)
    else:
        joint, body = floor.createWeldJointAndBodyNodePair()
        floor.setMobile(False)
    joint.setTransformFromParentBodyNode(_at(0.0, 0.0, -0.5))
    node = body.createShapeNode(dart.dynamics.BoxShape([40.0, 40.0, 1.0]))
    node.createCollisionAspect()
    node.createDynamicsAspect().setFrictionCoeff(FLOOR_GRIP)
    return floor


def _wheel(robot: dart.dynamics.Skeleton, base: dart.dynamics.BodyNode, truth: Truth, side: int) -> Wheel:
    body, drive = truth.body, truth.drive
    radius, mass = body.radius[side], body.wheel_mass
    left = body.axle / 2 * (1 - 2 * side)
    parent, place, roller = base, _at(0.0, left, 0.0), None
    across = 0.25 * mass * radius**2
    if body.tyre_width:
        lean, parent = robot.createRevoluteJointAndBodyNodePair(parent)
        lean.setAxis([1.0, 0.0, 0.0])
        lean.setTransformFromParentBodyNode(_at(0.0, left, -radius))
        _solid(parent, 0.01 * mass, (0.1 * across, 0.1 * across, 0.1 * across))
        place = _at(0.0, 0.0, radius)
    if body.cornering:
        roller, parent = robot.createRevoluteJointAndBodyNodePair(parent)
        roller.setAxis([1.0, 0.0, 0.0])
        roller.setTransformFromParentBodyNode(place)
        # contacts do not see a joint's damping within a step, so the bearing has inertia: it lags by 20 ms at
        # 0.1 m/s, as a tyre's side force lags by its relaxation length
        inertia = RELAXATION * body.cornering * loads(body)[side] * radius**2 / 0.1
        _solid(parent, 0.1 * mass, (inertia, across, across))
        place = _at(0.0, 0.0, 0.0)
    motor, node = robot.createRevoluteJointAndBodyNodePair(parent)
    motor.setAxis([0.0, 1.0, 0.0])
    motor.setTransformFromParentBodyNode(place)
    spin = 0.5 * mass * radius**2
    hub = None
    if drive.backlash[side]:
        _solid(node, 0.05 * mass, (0.05 * across, drive.rotor[side], 0.05 * across))
        hub, node = robot.createRevoluteJointAndBodyNodePair(node)
        hub.setAxis([0.0, 1.0, 0.0])
        hub.setPositionLowerLimit(0, -drive.backlash[side] / 2)
        hub.setPositionUpperLimit(0, drive.backlash[side] / 2)
        hub.setLimitEnforcement(True)
    else:
        spin += drive.rotor[side]
    _solid(node, mass, (across, spin, across))
    off, phase = body.hub_offset[side], body.phase[side]
    shift = (off * np.cos(phase), 0.0, off * np.sin(phase))
    grips = []
    for y in (0.0,) if not body.tyre_width else (-body.tyre_width / 2, body.tyre_width / 2):
        shape, aspect = _ball(node, radius, (shift[0], y, shift[2]), body.tyre_grip)
        grips.append(aspect)
    return Wheel(motor, hub, roller, node, shape, grips)


def _fork(robot: dart.dynamics.Skeleton, base: dart.dynamics.BodyNode, truth: Truth, down: float) -> None:
    """Add a swivelling caster: a fork about the vertical and a small wheel behind its axis."""
    body = truth.body
    radius = body.caster_radius
    swivel, fork = robot.createRevoluteJointAndBodyNodePair(base)
    swivel.setAxis([0.0, 0.0, 1.0])
    swivel.setTransformFromParentBodyNode(_at(body.caster_arm, 0.0, down + radius))
    swivel.setCoulombFriction(0, body.swivel_torque)
    mass = 0.02 * body.mass
    moment = mass * radius**2
    _solid(fork, mass, (moment, moment, moment))
    axle, wheel = robot.createRevoluteJointAndBodyNodePair(fork)
    axle.setAxis([0.0, 1.0, 0.0])
    axle.setTransformFromParentBodyNode(_at(-FORK_TRAIL * radius, 0.0, 0.0))
    axle.setCoulombFriction(0, body.caster_axle_torque)
    _solid(wheel, mass, (0.5 * moment, moment, 0.5 * moment))
    _ball(wheel, radius, (0.0, 0.0, 0.0), 0.6)
