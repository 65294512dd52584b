"""The same robot in MuJoCo: rigid bodies in 3-D, two driven wheels, a ball or a swivelling caster behind,
a smooth skid in front that hangs just above the floor (without it hard braking turns the robot over), mass behind the axle.

Effects of motors, commands, hands and trackers are those of the other modules; those of contact come by their natural
cause: gravity leans, a hub sits off the wheel's centre, friction changes under a wheel, a tyre resists by torsion, a
caster's ball or its two joints rub. Source: Todorov, Erez & Tassa, IROS 2012 (soft contacts, elliptic cones).
"""

from __future__ import annotations

import mujoco
import numpy as np

from foreign.motor import MOTOR_STATES, VOLTS, drive_step
from foreign.planar import HOOKS, MU_L, MU_R, SLACK_R, STEP
from foreign.setup import Array, Setup

STRIDE = 4  # grid steps in one step of the engine: 2 ms
HOOK_EVERY = 5  # engine steps


def model_text(setup: Setup) -> str:
    """Return the robot as MJCF; the base frame is the axle centre."""
    b, pieces = setup.body, setup.pieces
    r, half, cx = b["radius_left"], 0.5 * b["axle"], b["caster_x"]
    mw = 0.03 * b["mass"]
    body_mass = b["mass"] - 2 * mw
    com_x, com_y = b["com_x"] * b["mass"] / body_mass, b["com_y"] * b["mass"] / body_mass
    iz = max(b["inertia"] - 2 * mw * half**2, 0.3 * b["inertia"])
    small = 0.3 * r
    wheels = ""
    for side, sign in (("left", 1), ("right", -1)):
        e, phase = b.get(f"ecc_{side}", (0.0, 0.0))[:2]
        motor = setup.left if side == "left" else setup.right
        rotor = motor["rotor"] * (0.25 if motor.get("gap", 0.0) > 0 else 1.0)
        armature = max(rotor - 0.5 * mw * r * r, 0.2 * rotor)
        wheels += f"""
   <body name="{side}" pos="0 {sign * half} 0">
    <joint name="{side}" type="hinge" axis="0 1 0" armature="{armature}" damping="0"/>
    <inertial pos="0 0 0" mass="{mw}" diaginertia="{0.25 * mw * r * r} {0.5 * mw * r * r} {0.25 * mw * r * r}"/>
    <geom name="{side}" type="cylinder" size="{r} {0.12 * r}" pos="{e * np.sin(phase)} 0 {e * np.cos(phase)}" euler="90 0 0"
     friction="{b["friction"]} {max(b.get("pivot", 0.0), 1e-4)} 0.0001" condim="4" priority="1"/>
   </body>"""
    if pieces.get("swivel_caster"):
        trail, rub = 0.22 * abs(cx), pieces.get("caster_rub", 0.0) * setup.weight
        caster = f"""
   <body name="fork" pos="{cx} 0 {small - r}"><joint name="fork" type="hinge" axis="0 0 1" frictionloss="{0.25 * rub * trail}" damping="{1e-5 * b["mass"]}"/>
    <inertial pos="{-trail} 0 0" mass="{0.01 * b["mass"]}" diaginertia="{1e-3 * b["mass"] * r * r} {1e-3 * b["mass"] * r * r} {2e-3 * b["mass"] * r * r}"/>
    <body pos="{-trail} 0 0"><joint type="hinge" axis="0 1 0" frictionloss="{0.4 * rub * small}" armature="{1e-4 * b["mass"] * r * r}"/>
     <geom type="sphere" size="{small}" mass="{0.01 * b["mass"]}" friction="0.7 0.0001 0.0001" condim="3" priority="1"/></body></body>"""
    else:
        grip = pieces.get("caster_friction", 0.01)
        caster = f'<geom type="sphere" size="{small}" pos="{cx} 0 {small - r}" mass="0" friction="{grip} 0 0" condim="3" priority="2"/>'
    gx, gy = setup.gravity
    return (
        f"""<mujoco><compiler angle="degree"/><option timestep="0.002" gravity="{gx} {gy} -9.81" cone="elliptic" impratio="5" integrator="implicitfast"/>
 <worldbody><geom name="floor" type="plane" size="50 50 1" friction="0.8 0.001 0.0001" contype="1" conaffinity="2"/>
  <body name="base" pos="0 0 {r}"><freejoint/>
   <inertial pos="{com_x} {com_y} 0" mass="{body_mass}" diaginertia="{0.6 * iz} {0.6 * iz} {iz}"/>
   {caster}{wheels}
   <geom type="sphere" size="{small}" pos="{-cx} 0 {small - 0.96 * r}" mass="0" friction="0.01 0 0" condim="3" priority="2"/>
  </body></worldbody></mujoco>""".replace("<geom type", '<geom contype="2" conaffinity="1" type')
        .replace('<geom name="left"', '<geom contype="2" conaffinity="1" name="left"')
        .replace('<geom name="right"', '<geom contype="2" conaffinity="1" name="right"')
    )


class MuJoCo:
    """A drive in MuJoCo; the robot settles on its wheels before the clock starts."""

    def __init__(self, setup: Setup, pose: Array) -> None:
        self.setup, self.time, self.count = setup, 0.0, 0
        self.model = mujoco.MjModel.from_xml_string(model_text(setup))
        self.data = mujoco.MjData(self.model)
        self.left, self.right = setup.motors()
        self.supply, self.pack = setup.battery(), np.zeros(3)
        self.pack[VOLTS] = 1.0
        self.ml, self.mr = np.zeros(MOTOR_STATES), np.zeros(MOTOR_STATES)
        self.base = self.model.body("base").id
        self.geoms = [self.model.geom(side).id for side in ("left", "right")]
        self.joint_q = [int(self.model.joint(side).qposadr[0]) for side in ("left", "right")]
        self.joint_v = [int(self.model.joint(side).dofadr[0]) for side in ("left", "right")]
        d = self.data
        d.qpos[:2] = pose[:2]
        d.qpos[3:7] = [np.cos(pose[2] / 2), 0, 0, np.sin(pose[2] / 2)]
        for _ in range(300):
            mujoco.mj_step(self.model, d)
        d.qpos[:2] = pose[:2]
        self.turns, self.last = 0.0, self.heading()
        self.zero = [d.qpos[q] for q in self.joint_q]
        body = setup.body
        self.loss = body["rolling"] * 0.5 * body["mass"] * 9.81 * body["radius_left"]

    def heading(self) -> float:
        """Return the yaw [rad], wrapped."""
        w, x, y, z = self.data.qpos[3:7]
        return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    def row(self) -> list[float]:
        """Return x, y, theta, vx, vy, omega, phl, phr of the axle centre."""
        now = self.heading()
        self.turns += float(np.angle(np.exp(1j * (now - self.last))))
        self.last = now
        d = self.data
        if not hasattr(self, "first"):
            self.first = now
        turned = [d.qpos[q] - z for q, z in zip(self.joint_q, self.zero)]
        return [d.qpos[0], d.qpos[1], self.first + self.turns, d.qvel[0], d.qvel[1], d.qvel[5], *turned]

    def hooks(self) -> None:
        """Let hooks write forces and the friction under each wheel."""
        hook = np.zeros(HOOKS)
        hook[MU_L : SLACK_R + 1] = 1.0
        state = np.array(self.row()[:6])
        for act in self.setup.hooks:
            act(self.time, state, hook)
        self.data.xfrc_applied[self.base, :2] = hook[:2]
        self.data.xfrc_applied[self.base, 5] = hook[2]
        friction = self.setup.body["friction"]
        for geom, factor in zip(self.geoms, (hook[MU_L], hook[MU_R])):
            self.model.geom_friction[geom, 0] = max(friction * factor, 1e-3)

    def forward(self, duty: Array) -> Array:
        """Drive by duties on the grid of 0.5 ms; see `foreign.drive.Engine`."""
        out, d, pair = [], self.data, np.zeros(2)
        radius = self.setup.body["radius_left"]
        for k in range(0, len(duty), STRIDE):
            if self.setup.hooks and self.count % HOOK_EVERY == 0:
                self.hooks()
            rates, angles = d.qvel[self.joint_v], d.qpos[self.joint_q]
            drive_step(
                STEP, STRIDE, duty[k : k + STRIDE], angles, rates, self.pack, self.ml, self.mr, self.left, self.right, self.supply, pair
            )  # fmt: skip
            d.qfrc_applied[self.joint_v] = pair - self.loss * np.tanh(rates * radius / 0.01)
            mujoco.mj_step(self.model, d)
            self.count += 1
            self.time += STRIDE * STEP
            if self.count % HOOK_EVERY == 0:
                out.append(self.row())
        return np.array(out)
