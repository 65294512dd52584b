"""The robot of `engine.world` in Bullet: rigid bodies, hard contacts, round tyres, two sliding balls.

Motors are torques with a torque-speed line, computed here and applied to the joints each step; dead bands, delays and
clipping act on the command before, as in `engine.world`. Tilt is the direction of gravity, scrub Bullet's spinning
friction. Source: Coumans, Bullet Real-Time Physics (sequential impulses).
"""

from __future__ import annotations

import math

import numpy as np
import pybullet

from engine.world import BALL_ARM, BALL_RADIUS, HEIGHT, Robot, _mean_levels

STEP = 0.001  # s
CHUNK = 10  # steps between two looks at commands
WHEEL_MASS = 0.03  # kg


def build(robot: Robot, start: np.ndarray, client: int) -> int:
    """Make floor and robot in a world; return the robot's number."""
    p, r, half = pybullet, robot.radius, robot.axle / 2.0
    p.setTimeStep(STEP, physicsClientId=client)
    p.setGravity(-9.81 * robot.tilt_x, -9.81 * robot.tilt_y, -9.81, physicsClientId=client)
    p.setPhysicsEngineParameter(
        numSolverIterations=60, deterministicOverlappingPairs=1, physicsClientId=client
    )
    plane = p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client)
    floor = p.createMultiBody(0, plane, physicsClientId=client)
    p.changeDynamics(floor, -1, lateralFriction=1.0, physicsClientId=client)
    balls = p.createCollisionShapeArray(
        [p.GEOM_SPHERE] * 2,
        radii=[BALL_RADIUS] * 2,
        collisionFramePositions=[[x, 0.0, BALL_RADIUS - r + 2e-4] for x in (-BALL_ARM, BALL_ARM)],
        physicsClientId=client,
    )
    wheels = [p.createCollisionShape(p.GEOM_SPHERE, radius=r, physicsClientId=client) for _ in range(2)]
    body = p.createMultiBody(
        baseMass=robot.mass - 2 * WHEEL_MASS,
        baseCollisionShapeIndex=balls,
        basePosition=[start[0], start[1], r],
        baseOrientation=p.getQuaternionFromEuler([0.0, 0.0, start[2]]),
        baseInertialFramePosition=[0.0, 0.0, HEIGHT - 0.02],
        linkMasses=[WHEEL_MASS] * 2,
        linkCollisionShapeIndices=wheels,
        linkVisualShapeIndices=[-1, -1],
        linkPositions=[[0, half, 0], [0, -half, 0]],
        linkOrientations=[[0, 0, 0, 1]] * 2,
        linkInertialFramePositions=[[0, 0, 0]] * 2,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 2,
        linkParentIndices=[0, 0],
        linkJointTypes=[p.JOINT_REVOLUTE] * 2,
        linkJointAxis=[[0, 1, 0]] * 2,
        physicsClientId=client,
    )
    quiet = {"linearDamping": 0.0, "angularDamping": 0.0, "jointDamping": 0.0, "physicsClientId": client}
    inertia = [0.6 * robot.inertia, 0.7 * robot.inertia, robot.inertia]
    p.changeDynamics(body, -1, lateralFriction=0.0, localInertiaDiagonal=inertia, **quiet)
    light = 0.4 * WHEEL_MASS * r * r
    for link in range(2):
        p.changeDynamics(
            body,
            link,
            lateralFriction=robot.mu,
            spinningFriction=robot.scrub,
            rollingFriction=0.0,
            localInertiaDiagonal=[light, light + 2e-5, light],
            **quiet,
        )
        p.setJointMotorControl2(body, link, p.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
    return body


def simulate(
    robot: Robot, drive, start: np.ndarray, end: float, rng: np.random.Generator | None
) -> tuple[np.ndarray, np.ndarray]:
    """Drive from rest; times (n,) every 10 ms and states (n, 10) as `engine.world.simulate` returns them."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        return _driven(robot, drive, start, end, rng, client)
    finally:
        pybullet.disconnect(client)


def _driven(robot: Robot, drive, start, end: float, rng, client: int) -> tuple[np.ndarray, np.ndarray]:
    body = build(robot, start, client)
    for _ in range(300):
        pybullet.stepSimulation(physicsClientId=client)
    count = int(end / (STEP * CHUNK))
    times, states = np.arange(count) * STEP * CHUNK, np.zeros((count, 10))
    reached = np.stack(
        [_mean_levels(robot, drive, side, times) for side in (drive.left, drive.right)], axis=1
    )
    reached = reached * [robot.gain_left, robot.gain_right]
    turned, before, force = 0.0, start[2], np.zeros(2)
    keep = math.exp(-STEP * CHUNK / robot.ou_tau)
    spread = np.array([robot.ou_force, robot.ou_moment]) * math.sqrt(1.0 - keep * keep)
    for i in range(count):
        at, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
        speed, spin = pybullet.getBaseVelocity(body, physicsClientId=client)
        yaw = pybullet.getEulerFromQuaternion(turn)[2]
        turned += math.remainder(yaw - before, 2.0 * math.pi)
        before = yaw
        states[i, :3] = at[0], at[1], start[2] + turned
        if rng is not None:
            force = keep * force + spread * rng.standard_normal(2)
        moving = min(1.0, (math.hypot(*speed[:2]) / 0.02) ** 2 + (spin[2] / 0.2) ** 2)
        push = [moving * force[0] * math.cos(yaw), moving * force[0] * math.sin(yaw), 0.0]
        for _ in range(CHUNK):
            _step(robot, body, reached[i], push, moving * force[1], client)
    return times, states


def _step(robot: Robot, body: int, command, push: list[float], moment: float, client: int) -> None:
    """Advance by one step with the motors' torques and the random force and moment."""
    p = pybullet
    rates = np.array([s[1] for s in p.getJointStates(body, [0, 1], physicsClientId=client)])
    torque = robot.stall * (command - rates / robot.no_load)
    p.setJointMotorControlArray(body, [0, 1], p.TORQUE_CONTROL, forces=list(torque), physicsClientId=client)
    if moment or any(push):
        at, _ = p.getBasePositionAndOrientation(body, physicsClientId=client)
        p.applyExternalForce(body, -1, push, at, p.WORLD_FRAME, physicsClientId=client)
        p.applyExternalTorque(body, -1, [0.0, 0.0, moment], p.WORLD_FRAME, physicsClientId=client)
    p.stepSimulation(physicsClientId=client)
