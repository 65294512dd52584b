"""Laws of gears, wheels, casters and load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from benchmarks.physx_robots.laws import BALL, BRUSH, DUTY, ENGINE, SWIVEL, Law, log_uniform, register, which
from benchmarks.physx_robots.robots import GRAVITY, Caster, Motor, Rng, Robot, Tyre, Wheel, change_motors

Sides = tuple[float, float]


def _wheels(robot: Robot, change: Callable[[Wheel, int], Wheel]) -> Robot:
    return replace(robot, wheels=(change(robot.wheels[0], 0), change(robot.wheels[1], 1)))


def _tyre(robot: Robot, **changes: float) -> Robot:
    tyre: Tyre = replace(robot.tyre, **changes)  # type: ignore[arg-type]
    return replace(robot, tyre=tyre)


def _caster_load(robot: Robot) -> float:
    """Return what the first caster carries [N]."""
    return float(robot.mass * GRAVITY * robot.centre[0] / robot.casters[0].x)


def _casters(robot: Robot, change: Callable[[Caster], Caster]) -> Robot:
    return replace(robot, casters=tuple(change(c) for c in robot.casters))


@register
@dataclass(frozen=True)
class TightBearings(Law):
    """Dry friction in the drive: `share` of the stall torque."""

    label, law, grows, span, needs = "coulomb_friction", "tight_bearings", {"share": 1}, (0.003, 0.5), DUTY
    cause = (
        "preloaded or dirty bearings and gear teeth (Armstrong-Helouvry, Control of Machines with Friction)"
    )
    sides: Sides
    share: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the friction."""
        return cls(which(rng, 0.75), log_uniform(rng, 0.02, 0.15))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with more friction."""
        return change_motors(
            robot, lambda m: replace(m, coulomb=m.coulomb + self.share * m.stall), self.sides
        )


@register
@dataclass(frozen=True)
class StickySeals(Law):
    """Dry friction that is `breakaway` times as large at rest."""

    label, law, grows, span, needs = "coulomb_friction", "sticky_seals", {"share": 1}, (0.003, 0.4), DUTY
    cause = "lip seals and grease at rest: Stribeck friction (Olsson et al., Eur. J. Control 1998)"
    share: float
    breakaway: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw friction and break-away."""
        return cls(log_uniform(rng, 0.05, 0.2), float(rng.uniform(1.2, 1.9)))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with seals."""
        return change_motors(
            robot, lambda m: replace(m, coulomb=m.coulomb + self.share * m.stall, breakaway=self.breakaway)
        )


class Gear(Law):
    """Play of `play_rad` at the wheel between rotor and wheel."""

    play_rad: float
    hardness = 0.12

    def build(self, robot: Robot) -> Robot:
        """Return the robot with rotors of their own; the mesh is as stiff as the step follows."""

        def change(m: Motor, wheel: Wheel) -> Motor:
            light = min(m.rotor, 0.5 * robot.mass * wheel.radius**2 * 0.15)
            return replace(m, play=self.play_rad, mesh=self.hardness * light / 0.002**2)

        left, right = (change(m, w) for m, w in zip(robot.motors, robot.wheels))
        return replace(robot, motors=(left, right))


@register
@dataclass(frozen=True)
class StiffMesh(Gear):
    """Worn spur gears: `play_rad` at the wheel between a rotor that turns freely and the wheel."""

    label, law, grows, span = "gear_backlash", "stiff_mesh", {"play_rad": 1}, (0.01, 0.9)
    cause = "worn or printed spur gears; hobby gear motors have 2 to 8 degrees of play at the output when new"
    play_rad: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the play."""
        return cls(log_uniform(rng, 0.06, 0.35))


@register
@dataclass(frozen=True)
class RubberCoupling(Gear):
    """The same play with a rubber coupling that gives before it pulls."""

    label, law, grows, span = "gear_backlash", "rubber_coupling", {"play_rad": 1}, (0.01, 0.9)
    cause = "worn spider of a jaw coupling or a loose belt: play and then a soft spring"
    hardness = 0.012
    play_rad: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the play."""
        return cls(log_uniform(rng, 0.06, 0.35))


@register
@dataclass(frozen=True)
class OffsetHub(Law):
    """A wheel bored `offset_m` off its centre; in the engine the rim itself is off."""

    label, law, grows, span = "wheel_eccentricity", "offset_hub", {"offset_m": 1}, (0.0002, 0.04)
    needs = ENGINE
    cause = "hub bored or glued off the centre of the rim"
    offset_m: float
    sides: Sides
    phase: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw offset and angle."""
        return cls(
            robot.radius * log_uniform(rng, 0.04, 0.15), which(rng, 0.2), float(rng.uniform(-np.pi, np.pi))
        )

    def build(self, robot: Robot) -> Robot:
        """Return the robot with the rim off the axle."""
        offset = min(self.offset_m, 0.3 * robot.radius)
        return _wheels(
            robot, lambda w, i: replace(w, hub_offset=offset, phase=self.phase + i) if self.sides[i] else w
        )


@register
@dataclass(frozen=True)
class OvalRim(Law):
    """A rim pressed oval: the rolling radius changes by `oval` (share) twice in a turn."""

    label, law, grows, span = "wheel_eccentricity", "oval_rim", {"oval": 1}, (0.005, 0.15)
    needs = BRUSH
    cause = "soft wheel that stood under load, or a split rim pressed oval"
    oval: float
    sides: Sides
    phase: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw shape and angle."""
        return cls(log_uniform(rng, 0.04, 0.15), which(rng, 0.2), float(rng.uniform(-np.pi, np.pi)))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with oval wheels."""
        return _wheels(
            robot, lambda w, i: replace(w, oval=self.oval, phase=self.phase + i) if self.sides[i] else w
        )


@register
@dataclass(frozen=True)
class HairInBall(Law):
    """A ball caster that slides instead of rolling: friction coefficient `friction`."""

    label, law, grows, span, needs = (
        "caster_drag",
        "seized_ball",
        {"friction": 1},
        (0.02, 1.6),
        DUTY | BALL,
    )
    cause = "hair and dust lock a ball caster (Pololu ball caster notes); plastic on floors 0.2 to 0.6"
    friction: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the friction."""
        return cls(log_uniform(rng, 0.2, 0.6))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with the caster that carries load seized."""
        return _casters(robot, lambda c: replace(c, friction=c.friction + self.friction))


@register
@dataclass(frozen=True)
class StiffSwivel(Law):
    """A fork that turns stiffly: dry torque of `share` of load times trail."""

    label, law, grows, span, needs = (
        "caster_drag",
        "stiff_swivel",
        {"share": 1},
        (0.02, 1.5),
        DUTY | SWIVEL,
    )
    cause = (
        "overtightened or rusty swivel bearing of a cart's caster; it aligns late and pushes the robot's rear"
    )
    share: float
    torque: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the torque [N m] for a share of 1 from the caster's load."""
        return cls(log_uniform(rng, 0.15, 0.6), _caster_load(robot) * robot.casters[0].trail)

    def build(self, robot: Robot) -> Robot:
        """Return the robot with the stiff fork."""
        return _casters(robot, lambda c: replace(c, swivel=self.share * self.torque))


@register
@dataclass(frozen=True)
class DryAxle(Law):
    """A caster wheel whose axle drags: dry torque of `share` of load times its radius."""

    label, law, grows, span, needs = (
        "caster_drag",
        "dry_axle",
        {"share": 1},
        (0.02, 0.65),
        DUTY | SWIVEL,
    )
    cause = "thread and hair wound on a caster's axle"
    share: float
    torque: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the torque [N m] for a share of 1 from the caster's load."""
        return cls(log_uniform(rng, 0.1, 0.5), _caster_load(robot) * robot.casters[0].radius)

    def build(self, robot: Robot) -> Robot:
        """Return the robot with the dragging wheel."""
        return _casters(robot, lambda c: replace(c, axle=self.share * self.torque))


@register
@dataclass(frozen=True)
class WideTyre(Law):
    """Each wheel stands on two lines `half_width_m` either side of its middle, which rub in turns (engine's
    contact).
    """

    label, law, grows, span = "tyre_scrub", "wide_tyre", {"half_width_m": 1}, (0.001, 0.08)
    needs = DUTY | ENGINE
    cause = (
        "a wide flat tyre turns about its middle, its edges rub (scrub torque of wide tyres, Gillespie ch. 8)"
    )
    half_width_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the width."""
        return cls(robot.axle * log_uniform(rng, 0.03, 0.12))

    def build(self, robot: Robot) -> Robot:
        """Return the robot on wide tyres."""
        return _wheels(robot, lambda w, i: replace(w, half_width=min(self.half_width_m, 0.25 * robot.axle)))


@register
@dataclass(frozen=True)
class SoftTyre(Law):
    """A soft contact patch resists being turned, up to `arm_m` times load; rolling unwinds it."""

    label, law, grows, span = "tyre_scrub", "soft_patch", {"arm_m": 1}, (0.0003, 0.08)
    needs = DUTY | BRUSH
    cause = (
        "turn slip moment of a low-pressure tyre (Pacejka, Tyre and Vehicle Dynamics, ch. 9: parking torque)"
    )
    arm_m: float
    angle_rad: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the moment and the angle that it takes."""
        return cls(robot.axle * log_uniform(rng, 0.03, 0.12), float(rng.uniform(0.05, 0.25)))

    def build(self, robot: Robot) -> Robot:
        """Return the robot on soft tyres."""
        return _tyre(robot, spin_arm=self.arm_m, spin_angle=self.angle_rad)


@register
@dataclass(frozen=True)
class SoftSidewall(Law):
    """Tyres that yield sideways: side force over load for a unit of slip is `stiffness` only."""

    label, law, grows, span = "lateral_slip", "soft_sidewall", {"stiffness": -1}, (0.15, 9.0)
    needs = BRUSH
    cause = (
        "low cornering stiffness of foam and low-pressure tyres (Pacejka, ch. 1: slip angle over side force)"
    )
    stiffness: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the stiffness."""
        return cls(log_uniform(rng, 1.0, 4.0))

    def build(self, robot: Robot) -> Robot:
        """Return the robot on soft sidewalls."""
        return _tyre(robot, side_stiffness=self.stiffness)


@register
@dataclass(frozen=True)
class WornTread(Law):
    """Tyres that slide sideways at a friction coefficient of `side_grip` and creep before."""

    label, law, grows, span = "lateral_slip", "worn_tread", {"side_grip": -1, "stiffness": -1}, (0.01, 0.4)
    needs = BRUSH
    cause = "hard smooth wheels on a polished or dusty floor drift in fast turns"
    side_grip: float
    stiffness: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the grip, and a creep stiffness of 12 to 30 times it."""
        grip = log_uniform(rng, 0.04, 0.15)
        return cls(grip, grip * float(rng.uniform(12, 30)))

    def build(self, robot: Robot) -> Robot:
        """Return the robot on worn tread."""
        return _tyre(
            robot, side_grip=self.side_grip, side_stiffness=min(self.stiffness, robot.tyre.side_stiffness)
        )
