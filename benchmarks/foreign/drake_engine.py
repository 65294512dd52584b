"""The same robot in Drake: rigid bodies of three kinds with compliant point contact, solved as one convex problem a step.

Below 3 kg it is a small two-wheeler on a ball behind, up to 15 kg a disc with the wheels in the middle and a ball at
either end (the front one hangs a hair above the floor, so that it rocks), above that a cart on a swivelling fork whose
wheel touches the floor at two points. All have a slippery nose; without it hard braking turns them over.

Effects of contact come by their natural cause: gravity leans, hubs sit beside a wheel's centre, a wheel is an ellipsoid,
friction changes under a wheel, a wide tyre touches at two points, a ball rubs on the floor and a fork in its bearings, a
load is a box on the deck, a belt is a floor that moves. Dry friction of a bearing is the solver's own: a servo that
wants rest and whose torque is limited. Sources: Castro, Permenter & Han, arXiv 2110.10107 (2022) (the solver); Castro,
Han & Masterjohn, arXiv 2312.03908 (2023) (lagged friction); Hunt & Crossley, J. Applied Mechanics 42 (1975) (contacts).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    Ellipsoid,
    GeometryId,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    RoleAssign,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
)
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from foreign.motor import MOTOR_STATES, VOLTS, drive_step
from foreign.planar import DRAG_L, DRAG_R, FLOOR_X, FLOOR_Y, HOOKS, MU_L, MU_R, SLACK_R, STEP
from foreign.setup import Array, Setup

STRIDE = 4  # grid steps in one step of the engine: 2 ms
EVERY = 0.01  # s between two calls of hooks and two rows
FLOOR_GRIP = 1000.0  # the engine takes the harmonic mean of two frictions: the robot's side decides
STICTION = 2e-4  # m/s of slip below which a contact counts as sticking
SINK = 0.004  # how far a wheel sinks into the floor under its load, share of its radius
SIDES = ("left", "right")
# it warns that a half space means nothing to soft bodies, of which there are none
logging.getLogger("drake").setLevel(logging.ERROR)


@dataclass(frozen=True)
class Kind:
    """A shape of robot: masses [kg] it goes up to, height of its mass above the axle and gap of its nose, in radii."""

    name: str
    up_to: float
    height: float
    gap: float
    fork: bool
    masses: tuple[float, float]  # drawn between these [kg]


KINDS = (
    Kind("small", 3.0, 0.2, 0.04, False, (0.8, 1.3)),
    Kind("disc", 15.0, 0.0, 0.01, False, (5.0, 10.0)),
    Kind("cart", 1e9, 0.5, 0.04, True, (20.0, 30.0)),
)


def kind_of(mass: float) -> Kind:
    """Return the kind of robot of a mass [kg]."""
    return next(kind for kind in KINDS if mass < kind.up_to)


def draw_mass(rng: np.random.Generator, number: int) -> float:
    """Draw the mass [kg] of a robot; the kinds take turns."""
    return float(rng.uniform(*KINDS[number % len(KINDS)].masses))


@dataclass(frozen=True)
class Trunk:
    """The body without its loads: mass [kg], centre of mass [m] ahead and left of the axle, yaw inertia about it."""

    mass: float
    x: float
    y: float
    inertia: float


def trunk(setup: Setup) -> Trunk:
    """Take the loads off again (the inverse of `add_mass`, last one first)."""
    b = setup.body
    mass, x, y, inertia = b["mass"], b["com_x"], b["com_y"], b["inertia"]
    for extra, ex, ey in reversed(setup.payload):
        left = mass - extra
        ox, oy = (mass * x - extra * ex) / left, (mass * y - extra * ey) / left
        inertia -= left * ((ox - x) ** 2 + (oy - y) ** 2) + extra * ((ex - x) ** 2 + (ey - y) ** 2)
        mass, x, y = left, ox, oy
    return Trunk(mass, x, y, inertia)


def central(mass: float, at: tuple[float, float, float], turns: tuple[float, float, float]) -> SpatialInertia:
    """Return the inertia of a body: kg, m, kg m2 about its centre of mass."""
    return SpatialInertia.MakeFromCentralInertia(mass, list(at), RotationalInertia(*turns))


def block(mass: float, at: tuple[float, float, float], side: float) -> SpatialInertia:
    """Return the inertia of a cube of `side` [m]."""
    turn = mass * side**2 / 6
    return central(mass, at, (turn, turn, turn))


class Builder:
    """Puts the robot together, piece by piece; the base frame is the axle's centre."""

    def __init__(self, setup: Setup, step: float) -> None:
        self.setup, self.bare = setup, trunk(setup)
        self.kind = kind_of(self.bare.mass)
        self.diagram = DiagramBuilder()
        self.plant, self.scene = AddMultibodyPlantSceneGraph(self.diagram, step)
        self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
        self.plant.set_stiction_tolerance(STICTION)
        self.robot = self.plant.AddModelInstance("robot")
        self.shapes: list[GeometryId] = []
        self.wheels: list[list[GeometryId]] = []
        self.body_frame()
        self.joints = [self.wheel(side) for side in SIDES]
        if self.forked():
            self.fork()
        self.floor_joints = self.floor()
        self.plant.mutable_gravity_field().set_gravity_vector([*setup.gravity, -9.81])
        self.scene.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeWithin(GeometrySet(self.shapes))
        )
        self.plant.Finalize()

    def forked(self) -> bool:
        """Return whether a fork stands behind: on carts, and wherever it is the fork that drags."""
        pieces = self.setup.pieces
        return "caster_friction" not in pieces and (self.kind.fork or "fork" in pieces)

    def material(self, friction: float) -> ProximityProperties:
        """Return a surface that sinks by `SINK` under a wheel's load, nearly without bouncing."""
        b, out = self.setup.body, ProximityProperties()
        sink = SINK * b["radius_left"]
        damping = 3.0 / np.sqrt(9.81 * sink)  # s/m: 1.5 times critical about the load
        own = friction * FLOOR_GRIP / (2 * FLOOR_GRIP - friction)
        AddContactMaterial(out, damping, 0.45 * self.bare.mass * 9.81 / sink, CoulombFriction(own, own))
        return out

    def touch(self, body: RigidBody, name: str, at: list[float], shape: Shape, friction: float,
              turn: float = 0.0) -> GeometryId:  # fmt: skip
        """Give a body something that touches the floor, at a place [m], turned about the axle [rad]."""
        pose = RigidTransform(RotationMatrix.MakeYRotation(turn), at)
        made = self.plant.RegisterCollisionGeometry(body, pose, shape, name, self.material(friction))
        self.shapes.append(made)
        return made

    def body_frame(self) -> None:
        """Make the trunk, its ball or nose, and the loads on its deck."""
        b, bare = self.setup.body, self.bare
        r, cx, kind = b["radius_left"], b["caster_x"], self.kind
        self.wheel_mass, self.fork_mass = 0.03 * bare.mass, 0.02 * bare.mass if self.forked() else 0.0
        mass = bare.mass - 2 * self.wheel_mass - self.fork_mass
        x = (bare.x * bare.mass - 1.16 * cx * self.fork_mass) / mass
        turn = max(bare.inertia - 2 * self.wheel_mass * (0.5 * b["axle"]) ** 2, 0.3 * bare.inertia)
        at = (x, bare.y * bare.mass / mass, kind.height * r)
        self.base = self.plant.AddRigidBody(
            "base", self.robot, central(mass, at, (0.6 * turn, 0.6 * turn, turn))
        )
        for k, (extra, ex, ey) in enumerate(self.setup.payload):
            box = self.plant.AddRigidBody(f"load{k}", self.robot, block(extra, (ex, ey, r), r))
            self.plant.WeldFrames(self.base.body_frame(), box.body_frame())
        small, grip = 0.3 * r, self.setup.pieces.get("caster_friction", 0.01)
        if not self.forked():
            self.touch(self.base, "ball", [cx, 0, small - r], Sphere(small), grip)
        nose = grip if kind.name == "disc" else 0.01
        self.touch(self.base, "nose", [-cx, 0, small - (1 - kind.gap) * r], Sphere(small), nose)

    def spread(self) -> list[float]:
        """Return where across its width [m] a tyre touches: a point, or two with the moment of its whole width."""
        b = self.setup.body
        half = max(0.25 * b.get("patch_width", 0.0), b.get("pivot", 0.0) / b["friction"])
        return [-half, half] if half > 0 else [0.0]

    def wheel(self, side: str) -> Joint:
        """Make a driven wheel: its tyre may sit beside the hub, be oval, bear a bump, touch at two points."""
        b, sign = self.setup.body, 1 if side == "left" else -1
        r, mw = b[f"radius_{side}"], self.wheel_mass
        offset, phase, oval, bump = (*b.get(f"ecc_{side}", ()), 0.0, 0.0, 0.0, 0.0)[:4]
        light = 0.25 * mw * r * r
        body = self.plant.AddRigidBody(side, self.robot, central(mw, (0, 0, 0), (light, 2 * light, light)))
        hub = RigidTransform([0, sign * 0.5 * b["axle"], 0])
        joint = self.turning(side, self.base, hub, body, [0, 1, 0])
        motor = self.setup.left if side == "left" else self.setup.right
        rotor = motor["rotor"] * (0.25 if motor.get("gap", 0.0) > 0 else 1.0)
        self.rub(joint, b["rolling"] * 0.5 * b["mass"] * 9.81 * r, max(rotor - 2 * light, 0.2 * rotor))
        up = np.array([np.sin(phase), 0.0, np.cos(phase)])
        tyre = Ellipsoid(r - oval, r, r + oval) if oval else Sphere(r)
        made = []
        for k, y in enumerate(self.spread()):
            at = list(offset * up + [0, y, 0])
            made.append(self.touch(body, f"{side}{k}", at, tyre, b["friction"], phase))
        if bump:
            at = list((0.9 * r + bump) * up)
            made.append(self.touch(body, f"{side}tape", at, Sphere(0.1 * r), b["friction"]))
        self.wheels.append(made)
        return joint

    def turning(
        self, name: str, parent: RigidBody, at: RigidTransform, child: RigidBody, axis: list[int]
    ) -> Joint:
        """Hang a body on a bearing."""
        return self.plant.AddJoint(
            RevoluteJoint(
                name,
                self.plant.AddFrame(FixedOffsetFrame(f"{name}_seat", parent, at)),
                child.body_frame(),
                axis,
            )
        )

    def rub(self, joint: Joint, torque: float, rotor: float = 0.0) -> None:
        """Let a bearing rub with a dry torque [N m], and carry a rotor [kg m2]."""
        motor = self.plant.AddJointActuator(f"{joint.name()}_rub", joint, max(torque, 1e-9))
        motor.set_controller_gains(PdControllerGains(p=0.0, d=max(torque, 1e-9) / 0.02))
        motor.set_default_rotor_inertia(rotor)
        motor.set_default_gear_ratio(1.0)

    def fork(self) -> None:
        """Make a fork that swivels behind, with a wheel of two contacts that rub as it is turned on the spot."""
        b = self.setup.body
        r, cx, mass = b["radius_left"], b["caster_x"], self.fork_mass
        small, trail = 0.4 * r, 0.22 * abs(cx)
        load = max(b["mass"] * 9.81 * b["com_x"] / cx, 0.02 * b["mass"] * 9.81)
        fork = self.plant.AddRigidBody("fork", self.robot, block(0.5 * mass, (-0.5 * trail, 0, 0), small))
        seat = RigidTransform([cx, 0, small - r])
        swivel = self.turning("fork", self.base, seat, fork, [0, 0, 1])
        self.rub(swivel, b["caster_swivel"] * load, 1e-3 * mass * r * r)
        idle = self.plant.AddRigidBody("idle", self.robot, block(0.5 * mass, (0, 0, 0), small))
        axle = self.turning("idle", fork, RigidTransform([-trail, 0, 0]), idle, [0, 1, 0])
        self.rub(axle, b["caster_rolling"] * load * small)
        for k, y in enumerate((-0.15 * small, 0.15 * small)):
            self.touch(idle, f"idle{k}", [0, y, 0], Sphere(small), 0.7)

    def floor(self) -> list[Joint]:
        """Make the floor; where a belt or a nap carries the robot it is a very heavy body on two slides."""
        body, slides = self.plant.world_body(), []
        if "moving_floor" in self.setup.pieces:
            for k, axis in enumerate(([1, 0, 0], [0, 1, 0])):
                heavy = block(1000 * self.setup.body["mass"], (0, 0, 0), 1.0)
                slide = self.plant.AddRigidBody(f"slide{k}", self.robot, heavy)
                slides.append(
                    self.plant.AddJoint(
                        PrismaticJoint(f"slide{k}", body.body_frame(), slide.body_frame(), axis)
                    )
                )
                body = slide
        hard = ProximityProperties()
        AddContactMaterial(hard, 0.0, 1e9, CoulombFriction(FLOOR_GRIP, FLOOR_GRIP))
        self.plant.RegisterCollisionGeometry(body, RigidTransform(), HalfSpace(), "floor", hard)
        return slides


class Drake:
    """A drive in Drake; the robot settles on its wheels before the clock starts. `stride` is in grid steps."""

    def __init__(self, setup: Setup, pose: Array, stride: int = STRIDE) -> None:
        self.setup, self.time, self.count, self.stride = setup, 0.0, 0, stride
        self.every = round(EVERY / (stride * STEP))
        self.left, self.right = setup.motors()
        self.supply, self.pack = setup.battery(), np.zeros(3)
        self.pack[VOLTS] = 1.0
        self.ml, self.mr = np.zeros(MOTOR_STATES), np.zeros(MOTOR_STATES)
        self.parts = Builder(setup, stride * STEP)
        self.start()
        self.settle(pose)
        self.friction = [1.0, 1.0]
        self.wrench, self.drag = np.zeros(6), np.zeros(2)

    def start(self) -> None:
        """Make the simulator and find where each number of the state stands."""
        made, plant = self.parts, self.parts.plant
        diagram = made.diagram.Build()
        self.simulator = Simulator(diagram)
        root = self.simulator.get_mutable_context()
        self.context = plant.GetMyMutableContextFromRoot(root)
        self.scenery = made.scene.GetMyMutableContextFromRoot(root)
        rest = np.zeros(2 * plant.num_actuators(made.robot))
        plant.get_desired_state_input_port(made.robot).FixValue(self.context, rest)
        self.push = plant.get_applied_generalized_force_input_port().FixValue(
            self.context, np.zeros(plant.num_velocities())
        )
        self.size = plant.num_positions()
        self.at = made.base.floating_positions_start()  # quaternion w x y z, then x y z
        self.going = made.base.floating_velocities_start_in_v()  # turn rates x y z, then speeds, in the world
        self.joint_q = [joint.position_start() for joint in made.joints]
        self.joint_v = [joint.velocity_start() for joint in made.joints]
        self.floor_v = [joint.velocity_start() for joint in made.floor_joints]
        self.forces = np.zeros(plant.num_velocities())

    def state(self) -> Array:
        """Return positions and velocities."""
        return self.parts.plant.GetPositionsAndVelocities(self.context)

    def step(self) -> None:
        """Let the engine make one step."""
        self.push.GetMutableData().get_mutable_value().SetFromVector(self.forces)
        self.count += 1
        self.simulator.AdvanceTo(self.count * self.stride * STEP)

    def settle(self, pose: Array) -> None:
        """Put the robot down, let it come to rest for 0.6 s with its wheels braked, and put it where it starts."""
        plant = self.parts.plant
        q = plant.GetPositions(self.context)
        q[self.at : self.at + 7] = [
            np.cos(pose[2] / 2), 0, 0, np.sin(pose[2] / 2), pose[0], pose[1], self.setup.body["radius_left"],
        ]  # fmt: skip
        plant.SetPositions(self.context, q)
        brake = self.setup.stall / self.setup.left["no_load"]
        for _ in range(round(0.6 / (self.stride * STEP))):
            v = self.state()[self.size :]
            self.forces[self.joint_v] = -brake * v[self.joint_v]
            self.step()
        q, self.forces[:] = plant.GetPositions(self.context), 0.0
        q[self.at + 4 : self.at + 6] = pose[:2]
        plant.SetPositions(self.context, q)
        plant.SetVelocities(self.context, np.zeros(plant.num_velocities()))
        self.last = self.turns = heading(q[self.at :])
        self.zero = [q[k] for k in self.joint_q]

    def row(self) -> list[float]:
        """Return x, y, theta, vx, vy, omega, phl, phr of the axle centre."""
        both = self.state()
        q, v = both[: self.size], both[self.size :]
        now = heading(q[self.at :])
        self.turns += float(np.angle(np.exp(1j * (now - self.last))))
        self.last = now
        turned = [q[k] - z for k, z in zip(self.joint_q, self.zero)]
        g = self.going
        return [*q[self.at + 4 : self.at + 6], self.turns, v[g + 3], v[g + 4], v[g + 2], *turned]

    def hooks(self) -> None:
        """Let hooks write forces, the friction under each wheel, its rolling resistance and the floor's speed."""
        hook = np.zeros(HOOKS)
        hook[MU_L : SLACK_R + 1] = 1.0
        row = np.array(self.row()[:6])
        for act in self.setup.hooks:
            act(self.time, row, hook)
        b, c, s = self.setup.body, np.cos(row[2]), np.sin(row[2])
        x, y = c * b["com_x"] - s * b["com_y"], s * b["com_x"] + c * b["com_y"]
        self.wrench[:] = [0, 0, hook[2] + x * hook[1] - y * hook[0], hook[0], hook[1], 0]
        for side, factor in enumerate(hook[[MU_L, MU_R]]):
            if factor != self.friction[side]:
                self.friction[side] = factor
                self.regrip(side, max(b["friction"] * factor, 1e-3))
        self.drag[:] = 0.0
        if hook[DRAG_L] or hook[DRAG_R]:
            self.drag[:] = hook[[DRAG_L, DRAG_R]] * self.loads() * b["radius_left"]
        if self.floor_v:
            v = self.state()[self.size :]
            v[self.floor_v] = hook[[FLOOR_X, FLOOR_Y]]
            self.parts.plant.SetVelocities(self.context, v)

    def regrip(self, side: int, friction: float) -> None:
        """Give a wheel another friction."""
        surface, scene = self.parts.material(friction), self.parts.scene
        for made in self.parts.wheels[side]:
            scene.AssignRole(
                self.scenery, self.parts.plant.get_source_id(), made, surface, RoleAssign.kReplace
            )

    def loads(self) -> Array:
        """Return the load [N] on the left and the right wheel, as the engine has it now."""
        plant, out = self.parts.plant, np.zeros(2)
        met = plant.get_contact_results_output_port().Eval(self.context)
        bodies = [joint.child_body().index() for joint in self.parts.joints]
        for k in range(met.num_point_pair_contacts()):
            pair = met.point_pair_contact_info(k)
            for side, body in enumerate(bodies):
                if body in (pair.bodyA_index(), pair.bodyB_index()):
                    out[side] += abs(pair.contact_force()[2])
        return out

    def forward(self, duty: Array) -> Array:
        """Drive by duties on the grid of 0.5 ms; see `foreign.drive.Engine`."""
        out, pair, n = [], np.zeros(2), self.stride
        radius, g = self.setup.body["radius_left"], self.going
        for begun, k in enumerate(range(0, len(duty), n), 1):
            if self.setup.hooks and (begun - 1) % self.every == 0:
                self.hooks()
            both = self.state()
            rates, angles = both[self.size :][self.joint_v], both[self.joint_q]
            drive_step(
                STEP, n, duty[k : k + n], angles, rates, self.pack, self.ml, self.mr, self.left, self.right, self.supply, pair
            )  # fmt: skip
            self.forces[g : g + 6] = self.wrench
            self.forces[self.joint_v] = pair - self.drag * np.tanh(rates * radius / 0.03)
            self.step()
            self.time += n * STEP
            if begun % self.every == 0:
                out.append(self.row())
        return np.array(out)


def heading(q: Array) -> float:
    """Return the yaw [rad] of a quaternion w x y z, wrapped."""
    w, x, y, z = q[:4]
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
