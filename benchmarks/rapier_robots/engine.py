"""A robot in Rapier: rigid bodies, revolute joints and the engine's own contacts.

x points ahead, y to the left, z up; a wheel that rolls ahead has a positive rate about y. Dry friction is a joint motor
with target rate 0 and a largest torque, which the engine's solver treats as a constraint: a stuck wheel stands still.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Any

os.environ.setdefault("RAYON_NUM_THREADS", "1")  # a robot is too small a world to share between threads
import rapier3d as rapier

from benchmarks.rapier_robots.plant import Caster, Plant, Trailer

GRAVITY = 9.81  # m/s2
STEP = 0.002  # s
SIDES = (1.0, -1.0)  # left wheel, right wheel
HOLD = 1000.0  # Nms: how stiffly dry friction holds a joint below its largest torque
MULTIPLY = rapier.CoefficientCombineRule.MULTIPLY
ROTOR = 0.7  # share of the armature that is the rotor's own where the gear has play
SPIN = rapier.JointAxis.ANG_X


def _props(
    mass: float, inertia: tuple[float, float, float], com: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Any:
    return rapier.MassProperties(com, mass, inertia)


class World:
    """A robot on a floor.

    `chassis` has its origin at the middle of the axle; `wheels`: left, right.
    """

    def __init__(self, plant: Plant, x: float, y: float, yaw: float, step: float = STEP) -> None:
        self.plant = plant
        self.step_s = step
        self.world = rapier.PhysicsWorld(
            gravity=(GRAVITY * plant.slope[0], GRAVITY * plant.slope[1], -GRAVITY)
        )
        settings = self.world.integration_parameters
        settings.dt = step
        settings.num_solver_iterations = 4
        settings.normalized_allowed_linear_error = 1e-5
        settings.warmstart_joints = True
        settings.static_contact_softness = rapier.SpringCoefficients(0.48 / step, 5.0)
        self.origin = (x, y, yaw)
        self.balls: list[Any] = []
        self.height = sum(plant.radius) / 2.0
        self.step: Callable[[], None] = self.world.step
        self._floor()
        self._body()
        self._wheels()
        for caster in plant.casters:
            self._fork(caster) if caster.kind == "fork" else self._ball(caster)
        if plant.trailer is not None:
            self._trail(plant.trailer)

    def _floor(self) -> None:
        base = self.world.add_body(rapier.RigidBody.fixed())
        floor = rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(1.0).friction_combine_rule(MULTIPLY)
        self.floor = self.world.add_collider(floor, base)

    def place(self, ahead: float, left: float, above: float) -> tuple[float, float, float]:
        """Return where a point of the robot is in the world at the start [m]."""
        x, y, yaw = self.origin
        c, s = math.cos(yaw), math.sin(yaw)
        return (x + c * ahead - s * left, y + s * ahead + c * left, above)

    def _add(self, at: tuple[float, float, float], props: Any, fast: bool = False) -> tuple[Any, Any]:
        """Add a body at a place of the robot (ahead, left, above the floor); return its handle and itself."""
        builder = rapier.RigidBody.dynamic().translation(self.place(*at)).rotation((0.0, 0.0, self.origin[2]))
        builder = builder.can_sleep(False).additional_mass_properties(props).allow_fast_rotation(fast)
        handle = self.world.add_body(builder)
        return handle, self.world.rigid_bodies[handle]

    def _round(self, body: Any, radius: float, friction: float, at: tuple[float, float, float]) -> Any:
        """Add a massless ball to a body and return it."""
        ball = rapier.Collider.ball(radius).translation(at).density(0.0).friction(friction)
        return self.world.colliders[self.world.add_collider(ball.friction_combine_rule(MULTIPLY), body)]

    def _joint(self, one: Any, two: Any, axis: Any, at_one: Any, at_two: Any, friction: float) -> Any:
        joint = rapier.RevoluteJoint.builder(axis).local_anchor1(at_one).local_anchor2(at_two)
        joint = joint.contacts_enabled(False).motor_velocity(0.0, HOLD).motor_max_force(friction)
        joint = joint.motor_model(rapier.MotorModel.FORCE_BASED)
        return self.world.impulse_joints.insert(one, two, joint.build())

    def _body(self) -> None:
        plant = self.plant
        props = _props(plant.mass, plant.inertia, plant.com)
        self.chassis_handle, self.chassis = self._add((0.0, 0.0, self.height), props)

    def _wheels(self) -> None:
        plant = self.plant
        self.wheels, self.joints, self.rims = [], [], []
        for k, side in enumerate(SIDES):
            mass, radius = plant.wheel_mass, plant.radius[k]
            across = 0.28 * mass * radius**2
            own = 1.0 - ROTOR if plant.play[k] > 0.0 else 1.0  # a rotor behind play turns by itself
            spin = 0.55 * mass * radius**2 + own * plant.armature[k]
            at = (0.0, side * plant.axle / 2.0, self.height)
            handle, wheel = self._add(at, _props(mass, (across, spin, across)), True)
            hub = (0.0, side * plant.axle / 2.0, 0.0)
            dry = plant.dry[k] + plant.rolling[k] * plant.wheel_load * radius
            joint = self._joint(self.chassis_handle, handle, (0.0, 1.0, 0.0), hub, (0.0, 0.0, 0.0), dry)
            self.wheels.append(wheel)
            self.joints.append(self.world.impulse_joints[joint])
            self.rims.append(self._rims(handle, k))

    def _rims(self, handle: Any, k: int) -> list[Any]:
        plant = self.plant
        bore, at = plant.bore[k], plant.bore_at[k]
        lines = (-plant.twin[k], plant.twin[k]) if plant.twin[k] else (0.0,)
        places = [(bore * math.cos(at), line, bore * math.sin(at)) for line in lines]
        return [self._round(handle, plant.radius[k], plant.grip[k], place) for place in places]

    def _ball(self, caster: Caster) -> None:
        above = caster.radius + caster.lift - self.height
        ball = self._round(self.chassis_handle, caster.radius, caster.friction, (caster.x, caster.y, above))
        if caster.lift == 0.0:
            self.balls.append(ball)

    def _fork(self, caster: Caster) -> None:
        """Add a fork that swivels about z, and its wheel."""
        mass, radius = 0.02 * self.plant.mass, caster.radius
        small = 0.5 * mass * (radius**2 + caster.trail**2)
        at = (caster.x, caster.y, radius)
        fork, self.fork = self._add(at, _props(mass, (small, small, small)))
        top, middle = (caster.x, caster.y, radius - self.height), (0.0, 0.0, 0.0)
        self.pivot = self._joint(self.chassis_handle, fork, (0.0, 0.0, 1.0), top, middle, caster.pivot)
        spin = 0.5 * mass * radius**2
        wheel, _ = self._add(
            (caster.x - caster.trail, caster.y, radius), _props(mass, (spin, spin, spin)), True
        )
        self._joint(fork, wheel, (0.0, 1.0, 0.0), (-caster.trail, 0.0, 0.0), middle, caster.roll)
        self._round(wheel, radius, 0.6, middle)
        self.pivot = self.world.impulse_joints[self.pivot]

    def _trail(self, trailer: Trailer) -> None:
        """Add a cart on one wide castor-less wheel behind a ball hitch: its tyre does not slide sideways."""
        radius = self.plant.radius[0]
        at = (-trailer.hitch - trailer.bar, 0.0, radius)
        yaw = trailer.mass * (trailer.bar**2 / 4.0 + radius**2)
        cart, _ = self._add(at, _props(trailer.mass, (yaw, yaw, yaw)))
        joint = rapier.SphericalJoint.builder().local_anchor1((-trailer.hitch, 0.0, radius - self.height))
        joint = joint.local_anchor2((trailer.bar, 0.0, 0.0)).contacts_enabled(False)
        self.world.impulse_joints.insert(self.chassis_handle, cart, joint.build())
        half = 0.3 * self.plant.axle
        spin = 0.1 * trailer.mass * radius**2
        for side in SIDES:
            place = (at[0], side * half, radius)
            wheel, _ = self._add(place, _props(0.1 * trailer.mass, (spin, spin, spin)), True)
            hold = trailer.drag * trailer.mass * GRAVITY * radius / 2.0
            self._joint(cart, wheel, (0.0, 1.0, 0.0), (0.0, side * half, 0.0), (0.0, 0.0, 0.0), hold)
            self._round(wheel, radius, 0.6, (0.0, 0.0, 0.0))

    def set_friction(self, k: int, torque: float) -> None:
        """Set the dry friction of a wheel's bearing with its rolling resistance [Nm]."""
        self.joints[k].data.set_motor_max_force(SPIN, max(torque, 0.0))

    def set_grip(self, k: int, grip: float) -> None:
        """Set the friction coefficient of a wheel's tyre."""
        for rim in self.rims[k]:
            rim.friction = grip

    def set_ball(self, more: float) -> None:
        """Add to the friction coefficient of the ball caster that stands on the floor."""
        for ball in self.balls:
            ball.friction = self.plant.casters[0].friction + more

    def set_rim(self, k: int, ahead: float, above: float) -> None:
        """Move a wheel's rim from its bore [m], in the wheel's own turning frame."""
        for rim in self.rims[k]:
            rim.translation_wrt_parent = (ahead, 0.0, above)

    def side_force(self, k: int) -> float:
        """Return the force along the axle that a wheel's bearing carried in the last part of a step [N]."""
        return float(self.joints[k].impulses[0]) * 4.0 / self.step_s


class Creep:
    """A hook of the engine: tyres whose contact slides sideways at a given speed, as if the floor moved."""

    def __init__(self, world: World) -> None:
        self.velocity = (0.0, 0.0, 0.0)
        flag = rapier.ActiveHooks.MODIFY_SOLVER_CONTACTS
        for rims in world.rims:
            for rim in rims:
                rim.active_hooks = flag
        self.floor = world.floor
        world.world.physics_hooks = self  # type: ignore[assignment]  # the other hooks are optional

    def modify_solver_contacts(self, context: Any) -> None:
        """Give the contact its own speed [m/s]; the engine counts it from its first body to the second."""
        vx, vy, vz = self.velocity
        sign = 1.0 if context.collider1 == self.floor else -1.0
        context.set_tangent_velocity((sign * vx, sign * vy, sign * vz))
