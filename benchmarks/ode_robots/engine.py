"""The Open Dynamics Engine (through panda3d): a world, its bodies and joints, and contacts with soft surfaces."""

from __future__ import annotations

import math
from typing import Any

from panda3d.core import Quat, Vec3  # type: ignore[import-not-found,import-untyped,unused-ignore]
from panda3d.ode import (  # type: ignore[import-not-found,import-untyped,unused-ignore]
    OdeBallJoint,
    OdeBody,
    OdeContact,
    OdeContactGeom,
    OdeContactJoint,
    OdeFixedJoint,
    OdeHingeJoint,
    OdeJointGroup,
    OdeMass,
    OdeSliderJoint,
    OdeSurfaceParameters,
    OdeUtil,
    OdeWorld,
)

GRAVITY = 9.81
STEP = 0.002  # s, unless told otherwise
CFM = 1e-5  # softness of the joints: next to nothing
MU2, FDIR1, SOFT_ERP, SOFT_CFM, SLIP1, SLIP2 = 0x1, 0x2, 0x8, 0x10, 0x100, 0x200
MOTION1, MOTION2, PYRAMID = 0x20, 0x40, 0x3000
PLAIN = MU2 | FDIR1 | SOFT_ERP | SOFT_CFM | SLIP1 | SLIP2 | PYRAMID
DAMPING = 0.7  # of a contact that one load stands on


def spring(step: float, stiffness: float, load: float) -> tuple[float, float]:
    """Return erp and cfm of a damped spring [N/m] that carries a load [N]."""
    damper = 2.0 * DAMPING * math.sqrt(stiffness * load / GRAVITY)
    return step * stiffness / (step * stiffness + damper), 1.0 / (step * stiffness + damper)


class World:
    """One world with a level floor at z = 0."""

    def __init__(self, step: float) -> None:
        """Begin empty."""
        OdeUtil.randSetSeed(7)
        self.step = step
        self.ode = OdeWorld()
        self.ode.setGravity(0.0, 0.0, -GRAVITY)
        self.ode.setErp(0.2)
        self.ode.setCfm(CFM)
        self.group = OdeJointGroup()
        self.kept: list[Any] = []  # the engine frees what Python lets go

    def body(
        self, place: tuple[float, float, float], yaw: float, mass: float, inertia: tuple[float, float, float]
    ) -> Any:
        """Return a body that does not collide by itself."""
        body, weights = OdeBody(self.ode), OdeMass()
        weights.setParameters(mass, 0.0, 0.0, 0.0, *inertia, 0.0, 0.0, 0.0)
        body.setMass(weights)
        body.setPosition(*place)
        body.setQuaternion(Quat(math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)))
        body.setAutoDisableFlag(False)
        self.kept.append(body)
        return body

    def hinge(
        self, one: Any, other: Any, place: tuple[float, float, float], axis: tuple[float, float, float]
    ) -> Any:
        """Return a hinge; its angle is that of `one` against `other`."""
        joint = OdeHingeJoint(self.ode)
        joint.attachBodies(one, other)
        joint.setAnchor(*place)
        joint.setAxis(*axis)
        self.kept.append(joint)
        return joint

    def slider(self, one: Any, other: Any, axis: tuple[float, float, float]) -> Any:
        """Return a slide of `one` along an axis of `other`."""
        joint = OdeSliderJoint(self.ode)
        joint.attachBodies(one, other)
        joint.setAxis(*axis)
        self.kept.append(joint)
        return joint

    def ball(self, one: Any, other: Any, place: tuple[float, float, float]) -> Any:
        """Return a ball joint."""
        joint = OdeBallJoint(self.ode)
        joint.attachBodies(one, other)
        joint.setAnchor(*place)
        self.kept.append(joint)
        return joint

    def fix(self, one: Any, other: Any) -> Any:
        """Glue two bodies where they are."""
        joint = OdeFixedJoint(self.ode)
        joint.attachBodies(one, other)
        joint.set()
        self.kept.append(joint)
        return joint

    def clear(self) -> None:
        """Forget the contacts of the last step."""
        self.group.empty()

    def advance(self) -> None:
        """Make one step of the exact solver."""
        self.ode.step(self.step)


class Pad:
    """A place of a body that stands on the floor, and the floor's surface there."""

    def __init__(self, world: World, stiffness: float, load: float) -> None:
        """Take a spring's stiffness [N/m] and the load at rest [N]."""
        self.world = world
        self.erp, self.cfm = spring(world.step, stiffness, load)
        self.params = OdeSurfaceParameters()
        self.params.setMode(PLAIN)
        self.params.setSoftErp(self.erp)
        self.params.setSoftCfm(self.cfm)
        self.geom = OdeContactGeom()
        self.geom.setNormal(Vec3(0.0, 0.0, 1.0))
        self.contact = OdeContact()
        self.moves = False

    def surface(
        self,
        along: float,
        across: float,
        slip_along: float,
        slip_across: float,
        drift: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Set friction and slip (m/s for a newton) along and across, and how fast the surface itself moves [m/s]."""
        p = self.params
        p.setMu(along)
        p.setMu2(across)
        p.setSlip1(slip_along)
        p.setSlip2(slip_across)
        if drift != (0.0, 0.0) or self.moves:
            self.moves = True
            p.setMode(PLAIN | MOTION1 | MOTION2)
            p.setMotion1(drift[0])
            p.setMotion2(drift[1])
        self.contact.setSurface(p)

    def touch(self, body: Any, x: float, y: float, depth: float, forward: Any) -> None:
        """Stand on the floor at x, y for one step."""
        geom = self.geom
        geom.setPos(Vec3(x, y, 0.0))
        geom.setDepth(depth)
        self.contact.setGeom(geom)
        self.contact.setFdir1(forward)
        OdeContactJoint(self.world.ode, self.world.group, self.contact).attachBody(body, 0)
