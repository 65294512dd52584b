"""One robot in PhysX: links, joints, contacts, and what the simulation reads and writes each step."""

from __future__ import annotations

import math
import warnings

import numpy as np

from benchmarks.physx_robots.robots import GRAVITY, Caster, Robot

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # no graphics are wanted
    import sapien
    from sapien import Pose, physx

STEP = 0.002  # s
TO_Y = [0.70710678, 0.0, 0.0, 0.70710678]  # turns a joint's x axis to y
TO_Z = [0.70710678, 0.0, -0.70710678, 0.0]  # and to z
OWN_GROUP = [1, 1, 1, 0]  # parts of the robot do not collide with one another
ITERATIONS = 12


def _material(friction: float) -> physx.PhysxMaterial:
    """Return a material that meets the frictionless floor with `friction` (PhysX takes the mean of the two)."""
    return physx.PhysxMaterial(2.0 * friction, 2.0 * friction, 0.0)


class Body:
    """A robot standing at the origin of a plane, heading along x.

    The loop sets `joint_torque` [N m] (left, right, fork, fork's wheel) and calls `push` and `step`.
    """

    def __init__(self, robot: Robot, step: float = STEP) -> None:
        self.robot = robot
        physx.set_scene_config(
            gravity=np.array([GRAVITY * robot.tilt[0], GRAVITY * robot.tilt[1], -GRAVITY], dtype=np.float32),
            enable_tgs=False,  # the other solver lets wheels that roll straight creep apart
            bounce_threshold=0.2,
        )
        physx.set_shape_config(contact_offset=0.003)
        physx.set_body_config(
            solver_position_iterations=ITERATIONS, solver_velocity_iterations=1, sleep_threshold=0.0
        )
        self.scene = sapien.Scene([physx.PhysxCpuSystem()])
        self.scene.set_timestep(step)
        self._system = self.scene.physx_system
        floor = self.scene.create_actor_builder()
        floor.add_plane_collision(Pose([0, 0, 0], TO_Z), physx.PhysxMaterial(0.0, 0.0, 0.0))
        floor.build_static("floor")
        self.grips: list[physx.PhysxMaterial] = []
        self.articulation = self._build()
        self.root = self.articulation.links[0]
        self.joint_torque = np.zeros(self.articulation.dof, dtype=np.float32)
        self._force = np.zeros(3, dtype=np.float32)
        self._torque = np.zeros(3, dtype=np.float32)

    def _build(self) -> physx.PhysxArticulation:
        robot = self.robot
        builder = self.scene.create_articulation_builder()
        chassis = builder.create_link_builder(None)
        chassis.set_name("chassis")
        chassis.set_mass_and_inertia(robot.mass, Pose(list(robot.centre)), list(robot.inertia))
        for caster in robot.casters:
            if caster.kind != "swivel":
                place = [caster.x, 0.0, caster.radius - robot.radius + caster.lift]
                chassis.add_sphere_collision(Pose(place), caster.radius, _material(caster.friction))
        for side in (0, 1):
            self._add_wheel(builder, chassis, side)
        for caster in robot.casters:
            if caster.kind == "swivel":
                self._add_fork(builder, chassis, caster)
        builder.set_initial_pose(Pose([0, 0, robot.radius]))
        made = builder.build()
        for link in made.links:
            link.set_linear_damping(0.0)
            link.set_angular_damping(0.0)
            for shape in link.collision_shapes:
                shape.set_collision_groups(OWN_GROUP)
        for joint in made.active_joints:
            joint.set_friction(0.0)
        for joint, motor in zip(made.active_joints[:2], robot.motors):
            joint.set_armature(np.array([0.0 if motor.mesh else motor.rotor], dtype=np.float32))
        return made

    def _add_wheel(self, builder: sapien.ArticulationBuilder, chassis: object, side: int) -> None:
        robot, wheel = self.robot, self.robot.wheels[side]
        link = builder.create_link_builder(chassis)
        link.set_name(("left", "right")[side])
        material = _material(0.0 if robot.tyre.brush else robot.tyre.grip)
        self.grips.append(material)
        x, z = wheel.hub_offset * np.cos(wheel.phase), wheel.hub_offset * np.sin(wheel.phase)
        lines = (-wheel.half_width, wheel.half_width) if wheel.half_width else (0.0,)
        for line in lines:
            link.add_sphere_collision(Pose([x, line, z]), wheel.radius, material)
        about = 0.5 * wheel.mass * wheel.radius**2
        link.set_mass_and_inertia(wheel.mass, Pose(), [0.6 * about, about, 0.6 * about])
        place = Pose([0.0, (0.5, -0.5)[side] * robot.axle, wheel.radius - robot.radius], TO_Y)
        link.set_joint_properties("revolute_unwrapped", [[-1e9, 1e9]], place, Pose([0, 0, 0], TO_Y))

    def _add_fork(self, builder: sapien.ArticulationBuilder, chassis: object, caster: Caster) -> None:
        mass, radius = 0.02 * self.robot.mass, caster.radius
        drop = radius - self.robot.radius
        fork = builder.create_link_builder(chassis)
        fork.set_name("fork")
        spread = mass * (0.5 * radius**2 + caster.trail**2)
        fork.set_mass_and_inertia(0.5 * mass, Pose([-0.5 * caster.trail, 0, 0]), [spread, spread, spread])
        fork.set_joint_properties(
            "revolute_unwrapped", [[-1e9, 1e9]], Pose([caster.x, 0, drop], TO_Z), Pose([0, 0, 0], TO_Z)
        )
        wheel = builder.create_link_builder(fork)
        wheel.set_name("fork_wheel")
        wheel.add_sphere_collision(Pose(), radius, _material(0.7))
        about = 0.25 * mass * radius**2
        wheel.set_mass_and_inertia(0.5 * mass, Pose(), [0.6 * about, about, 0.6 * about])
        wheel.set_joint_properties(
            "revolute_unwrapped",
            [[-1e9, 1e9]],
            Pose([-caster.trail, caster.skew, 0], TO_Y),
            Pose([0, 0, 0], TO_Y),
        )

    def set_grip(self, side: int, friction: float) -> None:
        """Set the friction coefficient of a wheel whose contact is the engine's own."""
        self.grips[side].set_static_friction(2.0 * friction)
        self.grips[side].set_dynamic_friction(2.0 * friction)

    def push(self, force: tuple[float, float], moment: float, pose: tuple[float, float, float]) -> None:
        """Apply a level force [N] of the world at the floor below the axle's middle, and a moment [N m], to the body.

        pose : x, y [m], yaw [rad] of the axle's middle.
        """
        (ahead, left, up), yaw = self.robot.centre, pose[2]
        dx = left * math.sin(yaw) - ahead * math.cos(yaw)
        dy = -left * math.cos(yaw) - ahead * math.sin(yaw)
        height = up + self.robot.radius
        self._force[0], self._force[1] = force
        self._torque[0] = height * force[1]
        self._torque[1] = -height * force[0]
        self._torque[2] = moment + dx * force[1] - dy * force[0]
        self.root.add_force_torque(self._force, self._torque)

    def step(self) -> None:
        """Advance by one step."""
        self.articulation.set_qf(self.joint_torque)
        self._system.step()
