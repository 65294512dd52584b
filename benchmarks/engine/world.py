"""A two-wheeled robot in MuJoCo, driven by held commands; shares nothing with `fsm_calib.world2d`.

Body, wheels and two sliding balls (before and behind, so that the centre of mass may lie on the axle) are rigid bodies
in three dimensions. Wheels are ellipsoids on a plane with elliptic friction cones, so that tyres slip, scrub and bounce
as MuJoCo's soft contacts do (Todorov 2014, DOI 10.1109/ICRA.2014.6907751). The motors are MuJoCo actuators with a
torque-speed line, torque = stall (gain command - rate / no_load). Payload, tilt, friction of the drive train, scrub,
pushes and eccentric wheels are MuJoCo's own; dead bands, delays and clipping act on the command before it reaches the
actuator.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

STEP = 0.001  # s
CHUNK = 10  # steps between two looks at commands, disturbances and the floor
WHEEL_WIDTH = 0.012  # m, half the ellipsoid's axis
BALL_ARM, BALL_RADIUS = 0.07, 0.012  # m before and behind the axle, m
BALL_GAP = 2e-5  # m under each ball: a tenth of what the tyres sink in, so that the body cannot rock between the balls
HEIGHT = 0.03  # m of the body's centre above the axle's height
PUSH_LASTS = 0.25  # s


class Robot(NamedTuple):
    """Plain robot first, hidden physics after; SI units."""

    gain_left: float = 1.0
    gain_right: float = 1.0
    stall: float = 0.21  # N m at command 1
    no_load: float = 20.5  # rad/s at command 1
    axle: float = 0.10
    radius: float = 0.0318
    mass: float = 1.1
    inertia: float = 0.0065  # kg m2, of the body about its vertical
    mu: float = 0.8
    ou_force: float = 0.03  # N, random force along the body
    ou_moment: float = 0.0015  # N m
    ou_tau: float = 0.3  # s
    deadband: float = 0.0
    saturation: float = 1.0
    reverse: float = 0.0  # share lost (or won) backward
    delay: float = 0.0  # s
    coulomb: float = 0.0  # N m on each wheel's axle
    tilt_x: float = 0.0  # slope, uphill components
    tilt_y: float = 0.0
    payload: float = 0.0  # kg
    payload_x: float = 0.0  # m in base
    payload_y: float = 0.0
    scrub: float = 0.0  # m, torsional friction of each tyre per N of load and mu
    eccentric_left: float = 0.0  # share of the radius
    eccentric_right: float = 0.0
    patch_x: float = 0.0
    patch_y: float = 0.0
    patch_r: float = 0.0
    patch_mu: float = 1.0  # factor on mu inside the patch
    fault_left: float = 0.0  # share of the command lost
    fault_right: float = 0.0
    fault_start: float = 0.0
    fault_end: float = 0.0
    push_time: float = -1.0
    push_fx: float = 0.0
    push_fy: float = 0.0
    push_m: float = 0.0


def model_text(robot: Robot) -> str:
    """Return the robot as MuJoCo's XML."""
    r, half = robot.radius, robot.axle / 2.0
    gravity = f"{-9.81 * robot.tilt_x} {-9.81 * robot.tilt_y} -9.81"
    payload = (
        f'<body pos="{robot.payload_x} {robot.payload_y} {r + HEIGHT}"><geom type="sphere" size="0.02" '
        f'mass="{robot.payload}" contype="0" conaffinity="0"/></body>'
        if robot.payload > 0.0
        else ""
    )
    inertia = max(robot.inertia, 1e-4)

    def wheel(side: str, y: float, eccentric: float) -> str:
        return f"""
        <body name="{side}" pos="0 {y} {r}">
          <joint name="{side}" type="hinge" axis="0 1 0" armature="2e-5" frictionloss="{robot.coulomb}"/>
          <geom name="{side}" type="ellipsoid" size="{r} {WHEEL_WIDTH} {r}" pos="{eccentric * r} 0 0" mass="0.03"
            friction="{robot.mu} {1e-5 + robot.scrub} 0.0001" condim="4" priority="1"/>
        </body>"""

    def motor(side: str, gain: float) -> str:
        return (
            f'<general name="{side}" joint="{side}" gainprm="{robot.stall * gain}" biastype="affine" '
            f'biasprm="0 0 {-robot.stall / robot.no_load}"/>'
        )

    def ball(x: float) -> str:
        return f'<geom type="sphere" size="{BALL_RADIUS}" pos="{x} 0 {BALL_RADIUS + BALL_GAP}" mass="0" condim="1" priority="2"/>'

    return f"""
    <mujoco><option timestep="{STEP}" gravity="{gravity}" cone="elliptic" impratio="20" integrator="implicitfast"/>
      <default><geom solref="0.004 1"/></default>
      <worldbody><geom name="floor" type="plane" size="20 20 1" condim="4" friction="1 0.005 0.0001"/>
        <body name="base"><freejoint/>
          <inertial pos="0 0 {r + HEIGHT}" mass="{robot.mass - 0.06}"
            diaginertia="{0.6 * inertia} {0.7 * inertia} {inertia}"/>
          {ball(-BALL_ARM)}{ball(BALL_ARM)}
          {payload}
          {wheel("left", half, robot.eccentric_left)}{wheel("right", -half, robot.eccentric_right)}
        </body></worldbody>
      <actuator>{motor("left", robot.gain_left)}{motor("right", robot.gain_right)}</actuator></mujoco>"""


def shaped(robot: Robot, command: float) -> float:
    """Return the command [1] that reaches the motor."""
    u = max(-robot.saturation, min(robot.saturation, command))
    if robot.deadband > 0.0:
        u = math.copysign(max(abs(u) - robot.deadband, 0.0), u)
    elif u != 0.0:
        u -= robot.deadband * math.copysign(1.0, u)  # over-compensated: a piece is added
    return u * (1.0 - robot.reverse) if u < 0.0 else u


def simulate(
    robot: Robot, drive, start: np.ndarray, end: float, rng: np.random.Generator | None
) -> tuple[np.ndarray, np.ndarray]:
    """Drive from rest; return times (n,) every 10 ms and states (n, 10): x, y, theta, 0..., wheel angles in 8 and 9.

    `drive` has times [s], left, right [1] that hold until the next; `rng` None: no random disturbance.
    """
    model = mujoco.MjModel.from_xml_string(model_text(robot))
    data = mujoco.MjData(model)
    data.qpos[:7] = [start[0], start[1], 0.0, math.cos(start[2] / 2), 0.0, 0.0, math.sin(start[2] / 2)]
    base, sides = model.body("base").id, [model.geom(side).id for side in ("left", "right")]
    mujoco.mj_step(model, data, 300)  # let it sink into its contacts
    count = int(end / (STEP * CHUNK))
    times = np.arange(count) * STEP * CHUNK
    states = np.zeros((count, 10))
    reached = np.stack(
        [_mean_levels(robot, drive, side, times) for side in (drive.left, drive.right)], axis=1
    )
    turned, before, force = 0.0, start[2], np.zeros(2)
    keep = math.exp(-STEP * CHUNK / robot.ou_tau)
    spread = np.array([robot.ou_force, robot.ou_moment]) * math.sqrt(1.0 - keep * keep)
    for i in range(count):
        q = data.qpos
        yaw = math.atan2(2.0 * (q[3] * q[6] + q[4] * q[5]), 1.0 - 2.0 * (q[5] ** 2 + q[6] ** 2))
        turned += math.remainder(yaw - before, 2.0 * math.pi)
        before = yaw
        states[i, :3] = q[0], q[1], start[2] + turned
        states[i, 8:10] = q[7], q[8]
        t = times[i]
        for side in range(2):
            lost = (
                (robot.fault_left, robot.fault_right)[side]
                if robot.fault_start <= t < robot.fault_end
                else 0.0
            )
            data.ctrl[side] = reached[i, side] * (1.0 - lost)
            _grip(model, data, robot, sides[side])
        if rng is not None:
            force = keep * force + spread * rng.standard_normal(2)
        _push(data, robot, base, t, yaw, force)
        mujoco.mj_step(model, data, CHUNK)
    return times, states


def _mean_levels(robot: Robot, drive, levels, times: np.ndarray) -> np.ndarray:
    """Return the mean command [1] at the motor over each chunk, shape (n,): no edge is late by a part of a chunk."""
    edges = np.append(np.asarray(drive.times), max(drive.times[-1], times[-1]) + 1.0)
    total = np.concatenate([[0.0], np.cumsum(np.diff(edges) * [shaped(robot, u) for u in levels])])
    ends = np.append(times, times[-1] + STEP * CHUNK) - robot.delay
    return np.diff(np.interp(ends, edges, total)) / (STEP * CHUNK)


def _grip(model, data, robot: Robot, wheel: int) -> None:
    """Set the friction of a wheel by the floor under it."""
    if robot.patch_r <= 0.0:
        return
    x, y, _ = data.geom_xpos[wheel]
    inside = math.hypot(x - robot.patch_x, y - robot.patch_y) < robot.patch_r
    model.geom_friction[wheel, 0] = robot.mu * (robot.patch_mu if inside else 1.0)


def _push(data, robot: Robot, base: int, t: float, yaw: float, force: np.ndarray) -> None:
    """Apply the random force and moment (only to a body that moves), and the push while it lasts."""
    moving = min(1.0, (math.hypot(data.qvel[0], data.qvel[1]) / 0.02) ** 2 + (data.qvel[5] / 0.2) ** 2)
    fx, moment = force * moving
    applied = np.array([fx * math.cos(yaw), fx * math.sin(yaw), 0.0, 0.0, 0.0, moment])
    if robot.push_time <= t < robot.push_time + PUSH_LASTS:
        applied += [robot.push_fx, robot.push_fy, 0.0, 0.0, 0.0, robot.push_m]
    data.xfrc_applied[base] = applied
