"""The same robot in Bullet: rigid bodies with hard contacts, rounded tyres, a ball caster behind and a skid in front,
the mass behind the axle.

Source: Coumans, Bullet physics (sequential impulses, friction as a product of both surfaces). Effects of contact come by
their natural cause: gravity leans, hubs sit off the wheels' centres, friction changes under a wheel, tyres have spinning
friction, the caster's ball rubs.
"""

from __future__ import annotations

import numpy as np
import pybullet

from foreign.motor import MOTOR_STATES, VOLTS, drive_step
from foreign.planar import HOOKS, MU_L, MU_R, SLACK_R, STEP
from foreign.setup import Array, Setup

DT = 0.002  # s
STRIDE = 4  # grid steps in one step of the engine
HOOK_EVERY = 5  # engine steps


class Bullet:
    """A drive in Bullet; the robot settles on its wheels before the clock starts."""

    def __init__(self, setup: Setup, pose: Array) -> None:
        self.setup, self.time, self.count = setup, 0.0, 0
        self.p = pybullet
        self.client = pybullet.connect(pybullet.DIRECT)
        self.left, self.right = setup.motors()
        self.supply, self.pack = setup.battery(), np.zeros(3)
        self.pack[VOLTS] = 1.0
        self.ml, self.mr = np.zeros(MOTOR_STATES), np.zeros(MOTOR_STATES)
        self.robot = self.build(pose)
        self.friction = [1.0, 1.0]
        for _ in range(300):
            pybullet.stepSimulation(physicsClientId=self.client)
        self.last, self.turns = self.heading(), self.heading()
        self.zero = [s[0] for s in pybullet.getJointStates(self.robot, [0, 1], physicsClientId=self.client)]
        body = setup.body
        self.loss = body["rolling"] * 0.5 * body["mass"] * 9.81 * body["radius_left"]

    def __del__(self) -> None:
        """Give the world back."""
        if pybullet.isConnected(self.client):
            pybullet.disconnect(self.client)

    def build(self, pose: Array) -> int:
        """Make floor and robot; the base frame is the axle centre."""
        p, c, b = pybullet, self.client, self.setup.body
        p.setTimeStep(DT, physicsClientId=c)
        p.setGravity(*self.setup.gravity, -9.81, physicsClientId=c)
        p.setPhysicsEngineParameter(
            numSolverIterations=60, enableFileCaching=0, deterministicOverlappingPairs=1, physicsClientId=c
        )
        floor = p.createMultiBody(
            0, p.createCollisionShape(p.GEOM_PLANE, physicsClientId=c), physicsClientId=c
        )
        p.changeDynamics(floor, -1, lateralFriction=1.0, physicsClientId=c)
        r, half = b["radius_left"], 0.5 * b["axle"]
        mw, small = 0.03 * b["mass"], 0.3 * r
        mass = b["mass"] - 2 * mw
        self.com = np.array([b["com_x"], b["com_y"], 0.0]) * b["mass"] / mass
        ends = [[b["caster_x"], 0, small - r], [-b["caster_x"], 0, small - 0.96 * r]]
        caster = p.createCollisionShapeArray(
            [p.GEOM_SPHERE] * 2, radii=[small] * 2, collisionFramePositions=ends, physicsClientId=c
        )
        shapes = []
        for side in ("left", "right"):
            e, phase = b.get(f"ecc_{side}", (0.0, 0.0))[:2]
            at = [e * np.sin(phase), 0, e * np.cos(phase)]
            shapes.append(
                p.createCollisionShape(p.GEOM_SPHERE, radius=r, collisionFramePosition=at, physicsClientId=c)
            )
        robot = p.createMultiBody(
            baseMass=mass, baseCollisionShapeIndex=caster, basePosition=[pose[0], pose[1], r],
            baseOrientation=p.getQuaternionFromEuler([0, 0, pose[2]]), baseInertialFramePosition=list(self.com),
            linkMasses=[mw, mw], linkCollisionShapeIndices=shapes, linkVisualShapeIndices=[-1, -1],
            linkPositions=[[0, half, 0], [0, -half, 0]], linkOrientations=[[0, 0, 0, 1]] * 2,
            linkInertialFramePositions=[[0, 0, 0]] * 2, linkInertialFrameOrientations=[[0, 0, 0, 1]] * 2,
            linkParentIndices=[0, 0], linkJointTypes=[p.JOINT_REVOLUTE] * 2, linkJointAxis=[[0, 1, 0]] * 2, physicsClientId=c,
        )  # fmt: skip
        iz = max(b["inertia"] - 2 * mw * half**2, 0.3 * b["inertia"])
        rub = self.setup.pieces.get("caster_friction", 0.01)
        quiet = {
            "linearDamping": 0.0,
            "angularDamping": 0.0,
            "jointDamping": 0.0,
            "restitution": 0.0,
            "physicsClientId": c,
        }
        p.changeDynamics(
            robot,
            -1,
            lateralFriction=rub,
            localInertiaDiagonal=[0.6 * iz, 0.6 * iz, iz],
            activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING,
            **quiet,
        )
        for link, motor in enumerate((self.setup.left, self.setup.right)):
            rotor = motor["rotor"] * (0.25 if motor.get("gap", 0.0) > 0 else 1.0)
            light = 0.25 * mw * r * r
            p.changeDynamics(
                robot,
                link,
                lateralFriction=b["friction"],
                spinningFriction=b.get("pivot", 0.0),
                rollingFriction=0.0,
                localInertiaDiagonal=[light, rotor, light],
                **quiet,
            )
            p.setJointMotorControl2(robot, link, p.VELOCITY_CONTROL, force=0, physicsClientId=c)
        return robot

    def heading(self) -> float:
        """Return the yaw [rad], wrapped."""
        _, (x, y, z, w) = pybullet.getBasePositionAndOrientation(self.robot, physicsClientId=self.client)
        return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    def row(self) -> list[float]:
        """Return x, y, theta, vx, vy, omega, phl, phr of the axle centre."""
        at, (qx, qy, qz, qw) = pybullet.getBasePositionAndOrientation(self.robot, physicsClientId=self.client)
        (vx, vy, _), (_, _, omega) = pybullet.getBaseVelocity(self.robot, physicsClientId=self.client)
        now = float(np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))
        self.turns += float(np.arctan2(np.sin(now - self.last), np.cos(now - self.last)))
        self.last = now
        c, s = np.cos(now), np.sin(now)
        ox, oy = c * self.com[0] - s * self.com[1], s * self.com[0] + c * self.com[1]
        turned = [
            st[0] - z
            for st, z in zip(
                pybullet.getJointStates(self.robot, [0, 1], physicsClientId=self.client), self.zero
            )
        ]
        return [at[0] - ox, at[1] - oy, self.turns, vx + omega * oy, vy - omega * ox, omega, *turned]

    def hooks(self) -> Array:
        """Let hooks write forces and the friction under each wheel; return the force and moment."""
        hook = np.zeros(HOOKS)
        hook[MU_L : SLACK_R + 1] = 1.0
        state = np.array(self.row()[:6])
        for act in self.setup.hooks:
            act(self.time, state, hook)
        for link, factor in enumerate((hook[MU_L], hook[MU_R])):
            if factor != self.friction[link]:
                self.friction[link] = factor
                pybullet.changeDynamics(
                    self.robot,
                    link,
                    lateralFriction=max(self.setup.body["friction"] * factor, 1e-3),
                    physicsClientId=self.client,
                )
        return hook[:3]

    def forward(self, duty: Array) -> Array:
        """Drive by duties on the grid of 0.5 ms; see `foreign.drive.Engine`."""
        p, c, out, wrench, pair = pybullet, self.client, [], np.zeros(3), np.zeros(2)
        radius = self.setup.body["radius_left"]
        for k in range(0, len(duty), STRIDE):
            if self.setup.hooks and self.count % HOOK_EVERY == 0:
                wrench = self.hooks()
            states = p.getJointStates(self.robot, [0, 1], physicsClientId=c)
            angles, rates = np.array([states[0][0], states[1][0]]), np.array([states[0][1], states[1][1]])
            drive_step(
                STEP, STRIDE, duty[k : k + STRIDE], angles, rates, self.pack, self.ml, self.mr, self.left, self.right, self.supply, pair
            )  # fmt: skip
            torques = list(pair - self.loss * np.tanh(rates * radius / 0.01))
            p.setJointMotorControlArray(
                self.robot, [0, 1], p.TORQUE_CONTROL, forces=torques, physicsClientId=c
            )
            if wrench.any():
                at, _ = p.getBasePositionAndOrientation(self.robot, physicsClientId=c)
                p.applyExternalForce(
                    self.robot, -1, [wrench[0], wrench[1], 0.0], at, p.WORLD_FRAME, physicsClientId=c
                )
                p.applyExternalTorque(self.robot, -1, [0.0, 0.0, wrench[2]], p.WORLD_FRAME, physicsClientId=c)
            p.stepSimulation(physicsClientId=c)
            self.count += 1
            self.time += DT
            if self.count % HOOK_EVERY == 0:
                out.append(self.row())
        return np.array(out)
