"""The robot in Exudyn: a kinematic tree of 3-D rigid bodies on rolling-disc contacts, and one run of it.

Tree: x, y, z, yaw, pitch, roll (chassis), left and right wheel, then a pivot and a wheel for each
swivelling caster.
Contacts: ObjectConnectorRollingDiscPenalty for drive wheels, caster wheels, ball casters and the
anti-tip skid (a disc
that does not turn: it slides). Integrator: implicit trapezoidal rule, modified Newton.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

sys.exudynFast = True  # the build without range checks; must be set before the import
import exudyn as exu
from exudyn import itemInterface as eii

from benchmarks.exudyn_robots import physics
from benchmarks.exudyn_robots.params import STATE
from benchmarks.exudyn_robots.physics import G

STEP = 0.0025
KEEP = 4  # one row of truth every KEEP steps


@dataclass
class Caster:
    """A ball (slides with friction mu) or a swivelling wheel: place in m from the axle's middle."""

    kind: str
    x: float
    y: float
    radius: float
    mu: float = 0.05
    trail: float = 0.0
    pivot_friction: float = 0.0
    axle_friction: float = 0.0
    aside: float = 0.0  # a real caster's wheel is not quite in its pivot's plane
    gap: float = 0.0


@dataclass
class Body:
    """Masses (kg), lengths (m) and inertias (kg m2) of the chassis and what stands on it."""

    mass: float
    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    wheel_mass: float
    casters: list[Caster] = field(default_factory=list)
    payload: float = 0.0
    payload_at: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def chassis(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Mass, centre of mass and inertia about it (box law, parallel axes with the payload)."""
        m = self.mass - 2.0 * self.wheel_mass
        parts = [(m, np.array(self.centre) * self.mass / m, self.size)]
        if self.payload > 0.0:
            parts.append((self.payload, np.array(self.payload_at), tuple(0.4 * s for s in self.size)))
        total = sum(p[0] for p in parts)
        centre = sum(p[0] * p[1] for p in parts) / total
        inertia = np.zeros((3, 3))
        for mass, at, (a, b, c) in parts:
            inertia += mass / 12.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
            d = at - centre
            inertia += mass * (d @ d * np.eye(3) - np.outer(d, d))
        return total, centre, inertia


@dataclass
class Truth:
    """A run: time s, x m, y m, theta rad (unwrapped), wheel angles rad (encoder side), active flag."""

    t: np.ndarray
    pose: np.ndarray
    angle: np.ndarray
    active: np.ndarray
    load: np.ndarray


Commander = Callable[[float, np.ndarray], tuple[float, float]]


def contact_stiffness(body: Body, par: np.ndarray) -> float:
    """Vertical stiffness of a drive wheel, N/m: static sink of `sink` under half of the weight."""
    return 0.5 * (body.mass + body.payload) * G / float(par["sink"][0])


def build(body: Body, par: np.ndarray, start: np.ndarray) -> tuple[Any, Any, int, list[int]]:
    """The assembled system at a starting pose (x, y, theta): container, system, tree, discs of the
    drive wheels.
    """
    joint = exu.JointType
    radius = par["radius"][0]
    axle = float(par["axle"][0])
    middle = float(radius.mean())
    types = [
        joint.PrismaticX,
        joint.PrismaticY,
        joint.PrismaticZ,
        joint.RevoluteZ,
        joint.RevoluteY,
        joint.RevoluteX,
        joint.RevoluteY,
        joint.RevoluteY,
    ]
    parents = [-1, 0, 1, 2, 3, 4, 5, 5]
    offsets: list[list[float]] = [[0.0, 0.0, 0.0]] * 6 + [[0.0, axle / 2, 0.0], [0.0, -axle / 2, 0.0]]
    mass, centre, inertia = body.chassis()
    masses = [0.0] * 5 + [mass, body.wheel_mass, body.wheel_mass]
    centres = [np.zeros(3)] * 5 + [centre, np.zeros(3), np.zeros(3)]
    inertias = [np.zeros((3, 3))] * 5 + [inertia]
    for i in range(2):
        own = 0.5 * body.wheel_mass * radius[i] ** 2
        rotor = float(par["rotor_inertia"][0, i]) * (0.5 if par["play_on"][0] > 0.5 else 1.0)
        inertias.append(np.diag([0.5 * own, own + rotor, 0.5 * own]))
    side = float(par["grip_side"][0])
    discs: list[tuple[int, float, list[float], float, float]] = []
    for i in range(2):
        discs.append((6 + i, float(radius[i]), [0.0, 0.0, 0.0], float(par["grip"][0]), 1.0))
    brakes: list[tuple[int, float, float]] = []
    for caster in body.casters:
        height = -middle + caster.radius + caster.gap
        part = (0.7, 0.7, 0.3, 0.12, 0.12)[sum(c.gap == 0.0 for c in body.casters)]
        if caster.kind == "ball":
            discs.append((5, caster.radius, [caster.x, caster.y, height], caster.mu, part))
            continue
        k = len(types)
        types += [joint.RevoluteZ, joint.RevoluteY]
        parents += [5, k]
        offsets += [[caster.x, caster.y, 0.0], [-caster.trail, caster.aside, height]]
        wheel = max(0.02, 0.01 * body.mass)
        masses += [wheel, wheel]
        centres += [np.array([-0.5 * caster.trail, 0.0, height]), np.zeros(3)]
        own = 0.5 * wheel * caster.radius**2
        inertias += [np.eye(3) * own, np.diag([0.5 * own, own, 0.5 * own])]
        discs.append((k + 1, caster.radius, [0.0, 0.0, 0.0], 0.7, part))
        brakes += [(k, caster.pivot_friction, 0.1), (k + 1, caster.axle_friction, 0.3)]

    n = len(types)
    first = np.zeros(n)
    first[:4] = [start[0], start[1], middle - float(par["sink"][0]) * 0.8, start[2]]
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(
        eii.NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=list(first),
            initialCoordinates_t=[0.0] * n,
            numberOfODE2Coordinates=n,
        )
    )
    tree = mbs.AddObject(
        eii.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=types,
            linkParents=parents,
            gravity=[0.0, 0.0, -G],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList(offsets),
            linkInertiasCOM=exu.Matrix3DList(inertias),
            linkCOMs=exu.Vector3DList(centres),
            linkMasses=masses,
            jointForceVector=[0.0] * n,
        )
    )
    ground = mbs.AddObject(eii.ObjectGround())
    floor = mbs.AddMarker(eii.MarkerBodyRigid(bodyNumber=ground))
    stiff = contact_stiffness(body, par)
    damp = 0.7 * math.sqrt(stiff * 0.5 * body.mass)
    drive = []
    for k, (link, size, at, mu, share) in enumerate(discs):
        mark = mbs.AddMarker(
            eii.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=link, localPosition=at)
        )
        data = mbs.AddNode(eii.NodeGenericData(initialCoordinates=[0.0, 0.0, 0.0], numberOfDataCoordinates=3))
        disc = mbs.AddObject(
            eii.ObjectConnectorRollingDiscPenalty(
                markerNumbers=[floor, mark],
                nodeNumber=data,
                discRadius=size,
                discAxis=[0.0, 1.0, 0.0],
                contactStiffness=share * stiff,
                contactDamping=share * damp,
                dryFriction=[mu * side, mu] if k < 2 else [mu, mu],
                dryFrictionProportionalZone=float(par["zone"][0]) if k < 2 else 0.01,
                useLinearProportionalZone=True,
            )
        )
        if k < 2:
            drive.append(disc)
    zero = mbs.AddMarker(
        eii.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(eii.NodePointGround()), coordinate=0)
    )
    for coordinate, torque, zone in brakes:
        if torque > 0.0:
            mark = mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            mbs.AddObject(
                eii.ObjectConnectorCoordinateSpringDamperExt(
                    markerNumbers=[zero, mark], fDynamicFriction=torque, frictionProportionalZone=zone
                )
            )
    mbs.Assemble()
    return container, mbs, tree, drive


def settings(duration: float, step: float) -> Any:
    """Solver settings: fixed steps, nothing written."""
    s = exu.SimulationSettings()
    ti = s.timeIntegration
    ti.endTime = duration
    ti.numberOfSteps = round(duration / step)
    ti.adaptiveStep = True  # halves a step only where Newton's method does not converge
    ti.verboseMode = 0
    s.solution.file.write = False
    s.linearSolver.solverType = exu.LinearSolverType.EXUdense
    ti.newton.useModifiedNewton = True
    ti.newton.maxModifiedNewtonIterations = 6
    ti.newton.relativeTolerance = 1e-4
    ti.newton.absoluteTolerance = 1e-6
    ti.discontinuous.ignoreMaxIterations = True
    ti.discontinuous.maxIterations = 1
    ti.generalizedAlpha.computeInitialAccelerations = False
    return s


def run(
    body: Body,
    par: np.ndarray,
    start: np.ndarray,
    duration: float,
    commander: Commander,
    step: float = STEP,
    keep: int = KEEP,
) -> Truth:
    """Simulate. `commander(t, history)` is asked before each step for the commands acting at t;
    history = truth rows.
    """
    container, mbs, tree, drive = build(body, par, start)
    par = par.copy()
    par["dt"] = step
    state = np.zeros(1, STATE)
    state["trailer_angle"] = start[2]
    state["slosh_x"], state["slosh_y"] = start[0], start[1]
    p, s = par[0], state[0]
    state["disc_radius"] = par["radius"]
    state["disc_grip"] = par["grip"]
    state["disc_zone"] = par["zone"]
    uneven = bool(np.any(p["off_centre"]) or np.any(p["oval"]))
    changing = bool(p["slick"] > 0.0 or p["creep"] > 0.0)
    tilting = bool(p["tilt_x"] != 0.0 or p["tilt_y"] != 0.0 or p["dish"] != 0.0)
    rows = round(duration / step) // keep + 2
    out = np.zeros((rows, 9))
    used = [0, 0]
    data = mbs.systemData
    side = float(p["grip_side"])
    force = np.zeros(len(data.GetODE2Coordinates()))
    cmd = np.zeros(2)
    last = np.array([p["grip"], p["grip"], p["zone"], p["zone"]])

    def before(mbs: Any, end: float) -> bool:
        k = used[0]
        if end < (k + 1e-3) * step:
            return True  # a part of a halved step: the forces hold
        q = np.asarray(data.GetODE2Coordinates())
        v = np.asarray(data.GetODE2Coordinates_t())
        cmd[0], cmd[1] = commander(k * step, out[: used[1]])
        physics.step(par, state, q, v, cmd, force)
        if k % keep == 0:
            row = out[used[1]]
            row[0] = k * step
            row[1:4] = q[0] + s["drift_x"], q[1] + s["drift_y"], q[3]
            row[4:6] = s["rotor"] if p["encoder_at_wheel"] < 0.5 else q[6:8]
            row[6] = s["active"]
            used[1] += 1
        mbs.SetObjectParameter(tree, "jointForceVector", force)
        if tilting:
            mbs.SetObjectParameter(tree, "gravity", [s["gravity_x"], s["gravity_y"], -G])
        if uneven:
            for i in range(2):
                mbs.SetObjectParameter(drive[i], "discRadius", float(s["disc_radius"][i]))
        if changing:
            for i in range(2):
                grip, zone = float(s["disc_grip"][i]), float(s["disc_zone"][i])
                if grip != last[i]:
                    last[i] = grip
                    mbs.SetObjectParameter(drive[i], "dryFriction", [grip * side, grip])
                if zone != last[2 + i]:
                    last[2 + i] = zone
                    mbs.SetObjectParameter(drive[i], "dryFrictionProportionalZone", zone)
        used[0] += 1
        return True

    mbs.SetPreStepUserFunction(before)
    try:
        mbs.SolveDynamic(settings(duration, step), solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    except exu.SolverError as error:
        raise FloatingPointError("Newton's method did not converge") from error
    mbs.SetPreStepUserFunction(0)
    del container
    out = out[: used[1]]
    if not np.all(np.isfinite(out)) or np.max(np.abs(out[:, 1:3])) > 50.0:
        raise FloatingPointError("the simulation left its bounds")
    return Truth(out[:, 0], out[:, 1:4].copy(), out[:, 4:6].copy(), out[:, 6].copy(), out[:, 7:9].copy())
